"""A ball's mask is what a sphere covers in the picture: no shade at its foot, no lost panel.

Sought is the circle on which most of the outline lies, by sampled consensus (Fischler and Bolles,
1981), once with what a wide lens does to balls beside the middle of the picture: it stretches them
away from it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.scene import Candidate


@dataclass(frozen=True, slots=True)
class RoundSettings:
    """Which outline is round, and which circle it is."""

    near_ratio: float = 0.03  # 0.01..0.1: over the radius: how far from its circle it may run
    near_px: float = 0.7  # 0.3..2: besides, as outlines run along whole pixels
    low_share: float = 0.2  # 0..0.4: of a mask, at its foot, not asked: shade sticks out there
    # 1..1.5: longer than wide, as wide lenses show balls away from the middle
    stretch_ratios: tuple[float, ...] = (1.0, 1.03, 1.06, 1.1, 1.15)
    max_stretch_ratio: float = 0.5  # 0.2..1: at the border of the widest picture, over its width
    triples_count: int = 400  # 100..2000: circles that are tried
    points_count: int = 240  # 60..1000: of the outline that are asked about each
    fits_count: int = 5  # 1..20: to the points that agree, until they do
    radius_ratios: tuple[float, float] = (0.3, 0.8)  # 0.1..2: of circles tried, over the box's side
    min_share: float = 0.6  # 0.4..0.9: of the outline, on the circle of what is round
    # 0.9..1: IoU with its own ellipse, beyond which a mask lost and took on nothing
    min_oval_ratio: float = 0.97
    max_lost_share: float = 0.15  # 0.05..0.4: of a mask: more that is missing was hidden, not lost
    score_share: float = 0.15  # 0..0.5: of a ball's mask's score, by how much of it is round


ROUND = RoundSettings()


@dataclass(frozen=True, slots=True)
class RoundOutline:
    """The outline of a ball, pixels: a circle around (x, y), stretched about `middle`.

    along: unit vector of the stretch. share: of the mask's outline that lies on it, 0 … 1.
    """

    x: float
    y: float
    radius: float
    stretch: float
    middle: tuple[float, float]
    along: tuple[float, float]
    share: float

    def area(self, shape: tuple[int, ...]) -> BoolArray:
        """(H, W) what it encloses."""
        rows, columns = np.indices(shape)
        points = np.stack([columns, rows], axis=-1).reshape(-1, 2) + 0.5
        flat = _pressed(points, np.array(self.middle), np.array(self.along), self.stretch)
        off = np.linalg.norm(flat - (self.x, self.y), axis=1)
        return np.asarray(off <= self.radius + 0.5).reshape(shape)


def as_ball(mask: BoolArray, others: BoolArray) -> BoolArray:
    """The mask (H, W) of a ball cut and filled to what a sphere covers.

    others: (H, W) what is in front of it. A mask that is a clean oval, or hardly round, stays.
    """
    outline = outline_of(mask)
    if len(outline) < 16 or iou(_oval(outline, mask.shape), mask) >= ROUND.min_oval_ratio:
        return mask
    found = round_outline(mask)
    if found is None or found.share < ROUND.min_share:
        return mask
    ball = found.area(mask.shape)
    lost = ball & ~mask & ~others
    if np.count_nonzero(lost) > ROUND.max_lost_share * np.count_nonzero(mask):
        return mask & ball
    return (mask & ball) | lost


def rounder_first(offers: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Masks of a ball, best first, each by its score and by how much of its outline is round."""
    own = ROUND.score_share
    weighed = [
        replace(offer, score=(1 - own) * offer.score + own * _roundness(offer.mask))
        for offer in offers
    ]
    return tuple(sorted(weighed, key=lambda offer: -offer.score))


def _roundness(mask: BoolArray) -> float:
    found = round_outline(mask)
    return 0.0 if found is None else found.share


def round_outline(
    mask: BoolArray, stretches: tuple[float, ...] = ROUND.stretch_ratios
) -> RoundOutline | None:
    """The circle on which most of a mask's outline lies; None where it is too small for one.

    stretches: how much longer than wide it may be.
    """
    outline = outline_of(mask)
    if not len(outline):
        return None
    top, bottom = outline[:, 1].min(), outline[:, 1].max()
    outline = outline[outline[:, 1] < bottom - ROUND.low_share * (bottom - top)]
    height, width = mask.shape
    rows, columns = mask.nonzero()
    middle = np.array([columns.mean(), rows.mean()]) + 0.5
    away = middle - (width / 2, height / 2)
    far = float(np.linalg.norm(away))
    along = away / max(far, 1e-9)
    best: tuple[float, RoundOutline] | None = None
    for stretch in stretches:
        if stretch > 1 + ROUND.max_stretch_ratio * far / width + 0.02:
            continue
        flat = _pressed(outline, middle, along, stretch)
        circle = _circle(flat)
        if circle is None:
            continue
        off = _off(flat, circle)[0]
        x, y, radius = circle
        agreed = float(np.maximum(1 - off**2, 0).mean())
        at, axis = (float(middle[0]), float(middle[1])), (float(along[0]), float(along[1]))
        found = RoundOutline(x, y, radius, stretch, at, axis, float((off < 1).mean()))
        if best is None or agreed > best[0]:
            best = agreed, found
    return best[1] if best else None


def outline_of(mask: BoolArray) -> FloatArray:
    """Points (N, 2) of a mask's outline, pixels, but for those on the border of the picture."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return np.zeros((0, 2))
    points = np.vstack([part[:, 0] for part in found]) + 0.5
    height, width = mask.shape
    within = (points > 1.5).all(axis=1) & (points < (width - 1.5, height - 1.5)).all(axis=1)
    return np.asarray(points[within], np.float64)


def _oval(outline: FloatArray, shape: tuple[int, ...]) -> BoolArray:
    ellipse = cv2.fitEllipse(outline.astype(np.float32))
    return cv2.ellipse(np.zeros(shape, np.uint8), ellipse, 1, -1).astype(bool)


def _pressed(
    points: FloatArray, middle: FloatArray, along: FloatArray, stretch: float
) -> FloatArray:
    """Points (N, 2) brought together along a direction, so that a stretched circle is one."""
    return points + ((points - middle) @ along)[:, None] * along * (1 / stretch - 1)


def _circle(points: FloatArray) -> tuple[float, float, float] | None:
    """Middle and radius of the circle that most points (N, 2) lie on; None for too few of them."""
    if len(points) < 16:
        return None
    asked = points[
        np.linspace(0, len(points) - 1, min(ROUND.points_count, len(points))).astype(int)
    ]
    rng = np.random.default_rng(0)
    circles = _through(asked[rng.integers(0, len(asked), (ROUND.triples_count, 3))])
    side = float(np.ptp(points, axis=0).max())
    circles = circles[
        (circles[:, 2] > ROUND.radius_ratios[0] * side)
        & (circles[:, 2] < ROUND.radius_ratios[1] * side)
    ]
    if not len(circles):
        return None
    agreed = np.maximum(1 - _off(asked, circles) ** 2, 0).sum(axis=1)
    x, y, radius = circles[int(agreed.argmax())]
    for _ in range(ROUND.fits_count):
        own = points[_off(points, (x, y, radius))[0] < 1]
        if len(own) < 3:
            return None
        terms = np.column_stack([2 * own, np.ones(len(own))])
        x, y, rest = np.linalg.lstsq(terms, (own**2).sum(axis=1), rcond=None)[0]
        radius = np.sqrt(max(rest + x * x + y * y, 1e-12))
    return float(x), float(y), float(radius)


def _through(triples: FloatArray) -> FloatArray:
    """(N, 3) middles and radii of the circles through three points each (N, 3, 2)."""
    first = triples[:, 0]
    (bx, by), (cx, cy) = (triples[:, 1] - first).T, (triples[:, 2] - first).T
    twice = 2 * (bx * cy - by * cx)
    plain = np.abs(twice) > 1e-9
    twice = np.where(plain, twice, 1.0)
    b, c = bx**2 + by**2, cx**2 + cy**2
    x, y = (cy * b - by * c) / twice, (bx * c - cx * b) / twice
    radius = np.where(plain, np.hypot(x, y), np.inf)
    return np.column_stack([first[:, 0] + x, first[:, 1] + y, radius])


def _off(points: FloatArray, circles: tuple[float, float, float] | FloatArray) -> FloatArray:
    """(M, N) how far points (N, 2) lie from circles (M, 3), in parts of how far they may."""
    each = np.atleast_2d(np.asarray(circles, np.float64))
    away = np.linalg.norm(points[None] - each[:, None, :2], axis=2)
    return np.abs(away - each[:, 2:]) / (ROUND.near_ratio * each[:, 2:] + ROUND.near_px)
