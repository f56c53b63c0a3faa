"""Large ellipses in the picture: circles painted or lying on a level plane."""

from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class RimSettings:
    """When an outline shows the rim of a round flat thing."""

    least_px: int = 30  # count, 10..100: of outline that is its own
    # count, 2..12: of fits, after each of which what is off the ellipse is left out
    rounds_count: int = 6
    off_ratio: float = 0.04  # 0.01..0.1: of its radius, by which its outline may be off
    kept_share: float = 0.6  # 0.4..0.9: of the outline, that has to be on it
    # count, 12..72: into which its round is cut, to tell how much of it is seen
    sectors_count: int = 24
    least_shown_share: float = 0.45  # 0.3..0.8: of them, in which it has to be seen


RIM = RimSettings()


@dataclass(frozen=True, slots=True)
class Ellipse:
    """x, y: middle, pixels. width, height: full axes, pixels; the long one is level."""

    x: float
    y: float
    width: float
    height: float

    @property
    def flatness(self) -> float:
        """Height over width: 1 seen from straight above."""
        return self.height / max(self.width, 1e-9)


def rim_of(mask: BoolArray, others: BoolArray) -> Ellipse | None:
    """The ellipse, long axis level, around a round flat thing; None where too little shows it.

    mask: (H, W) of the thing. others: (H, W) what may hide a part of it: where they meet, and at
    the picture's border, the outline is not its own. What sticks out (a spoon) is left out.
    """
    near = cv2.dilate(np.pad(others, 2, constant_values=True).astype(np.uint8), np.ones((5, 5)))
    edge = mask & ~(cv2.erode(mask.astype(np.uint8), np.ones((3, 3)), borderValue=0) > 0)
    rows, columns = np.nonzero(edge & ~(near[2:-2, 2:-2] > 0))
    if len(rows) < RIM.least_px:
        return None
    hull = cv2.convexHull(np.argwhere(mask)[:, ::-1].astype(np.int32))
    canvas = cv2.polylines(np.zeros(mask.shape, np.uint8), [hull], True, 1, 1)
    span = float(np.ptp(hull[:, 0, 0])) / 2
    away = cv2.distanceTransform(1 - canvas, cv2.DIST_L2, 5)[rows, columns]
    outer = away < 2.0
    points = np.stack([columns[outer], rows[outer]], 1).astype(np.float64) + 0.5
    return _ellipse_through(points, span)


def _ellipse_through(pixels: FloatArray, span: float) -> Ellipse | None:
    """Through points (N, 2) of an outline, what is off left out step by step. span: pixels."""
    if len(pixels) < RIM.least_px:
        return None
    middle = pixels.mean(0)
    points = (pixels - middle) / span
    kept, off, at = np.ones(len(points), bool), np.zeros(len(points)), points
    fit: FloatArray | None = None
    for _ in range(RIM.rounds_count):
        fit = _least_squares(points[kept])
        if fit is None:
            return None
        at = (points - fit[0]) / fit[1]
        off = np.abs(np.hypot(at[:, 0], at[:, 1]) - 1)
        kept = off < max(RIM.off_ratio, float(np.quantile(off, RIM.kept_share)))
    good = off < RIM.off_ratio
    sectors = np.floor(np.arctan2(at[good, 1], at[good, 0]) / (2 * np.pi) * RIM.sectors_count)
    shown = len(np.unique(sectors)) / RIM.sectors_count
    if fit is None or np.mean(good) < RIM.kept_share or shown < RIM.least_shown_share:
        return None
    (x, y), (wide, tall) = (span * fit).tolist()
    return Ellipse(x + float(middle[0]), y + float(middle[1]), 2 * wide, 2 * tall)


def _least_squares(points: FloatArray) -> FloatArray | None:
    """Middle and half axes (2, 2) of the level ellipse x² + b x + c y² + d y + e = 0."""
    x, y = points.T
    terms = np.stack([x, y**2, y, np.ones_like(x)], 1)
    b, c, d, e = (float(one) for one in np.linalg.lstsq(terms, -(x**2), rcond=None)[0])
    if c <= 0:
        return None
    size = b**2 / 4 + d**2 / (4 * c) - e
    return np.array([(-b / 2, -d / (2 * c)), np.sqrt((size, size / c))]) if size > 0 else None


def level_circles(image: Image, ignore: BoolArray | None = None) -> list[Ellipse]:
    """Ellipses with a level long axis, largest first, each outline once.

    ignore: pixels (H, W) of objects, whose own outlines do not count.
    """
    longest_side_px = 360  # 200..800: large ellipses show in a small picture, and dirt does not
    factor = longest_side_px / max(image.shape[:2])
    small = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(cv2.medianBlur(small, 5), cv2.COLOR_RGB2LAB)
    found: list[Ellipse] = []
    for channel in range(3):
        plane = lab[..., channel]
        low, high = (float(v) for v in np.percentile(plane, (1, 99)))
        if high - low < 18:
            continue
        for level in np.linspace(low, high, 7)[1:-1]:
            for sign in (cv2.THRESH_BINARY, cv2.THRESH_BINARY_INV):
                _, binary = cv2.threshold(plane, float(level), 255, sign)
                found += _round_parts(binary)
    scaled = [
        Ellipse(e.x / factor, e.y / factor, e.width / factor, e.height / factor) for e in found
    ]
    if ignore is not None:
        scaled = [e for e in scaled if not _is_object(e, ignore)]
    return _each_once(scaled)


def _round_parts(binary: np.ndarray) -> list[Ellipse]:
    out: list[Ellipse] = []
    rows, columns = binary.shape
    contours, _ = cv2.findContours(binary, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for contour in contours:
        x, y, width, height = cv2.boundingRect(contour)
        inside = x > 1 and y > 1 and x + width < columns - 1 and y + height < rows - 1
        if not inside or width < 0.12 * columns or height < 0.04 * rows or len(contour) < 30:
            continue
        hull = cv2.convexHull(contour)
        if len(hull) < 6:
            continue
        (cx, cy), (first, second), angle = cv2.fitEllipse(hull)
        long, short = max(first, second), min(first, second)
        tilt = angle - 90 if first < second else angle
        tilt = abs((tilt + 90) % 180 - 90)
        if long <= 0 or not 0.08 < short / long < 0.93 or tilt > 6:
            continue
        area = float(cv2.contourArea(hull))
        if abs(area / (np.pi * long * short / 4) - 1) < 0.04 and _fits(hull, cx, cy, long, short):
            out.append(Ellipse(float(cx) + 0.5, float(cy) + 0.5, float(long), float(short)))
    return out


def _fits(hull: np.ndarray, cx: float, cy: float, long: float, short: float) -> bool:
    """Whether the hull's corners lie on the ellipse within 4 % of its radius."""
    points = hull.reshape(-1, 2).astype(float)
    radius = np.hypot((points[:, 0] - cx) / (long / 2), (points[:, 1] - cy) / (short / 2))
    return bool(np.percentile(np.abs(radius - 1), 85) < 0.04)


def _is_object(ellipse: Ellipse, ignore: BoolArray) -> bool:
    canvas = np.zeros(ignore.shape, np.uint8)
    axes = (max(1, round(ellipse.width / 2)), max(1, round(ellipse.height / 2)))
    cv2.ellipse(canvas, (round(ellipse.x), round(ellipse.y)), axes, 0, 0, 360, 1, -1)
    region = canvas.astype(bool)
    return float((region & ignore).sum()) > 0.5 * float(region.sum())


def _each_once(found: list[Ellipse]) -> list[Ellipse]:
    out: list[Ellipse] = []
    for one in sorted(found, key=lambda e: -e.width):
        twin = any(
            abs(one.x - other.x) + abs(one.y - other.y) < 0.08 * other.width
            and abs(one.width - other.width) < 0.08 * other.width
            for other in out
        )
        if not twin:
            out.append(one)
    return out[:6]
