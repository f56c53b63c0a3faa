"""Rims of cups, bowls and cans: a level circle whose far half ends the silhouette above.

The near half of the circle that a can stands on ends its silhouette below.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from physagent_studio.knowledge import is_disc, is_open
from physagent_studio.reconstruction.camera.estimate import Disc
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds


@dataclass(frozen=True, slots=True)
class RimSettings:
    """When the end of a silhouette is a level circle."""

    # 0.003..0.05: over the width: of the silhouette from the ellipse, root mean square
    max_off_ratio: float = 0.012
    flattest_ratio: float = 0.06  # 0.01..0.2: height over width of an ellipse that says something
    roundest_ratio: float = 0.9  # 0.6..1: likewise: nearer to a circle, its slope is not told
    rim_spread_deg: float = 1.5  # 0.5..5: of the slope that a rim tells
    widest_share: float = 0.96  # 0.8..1: of the whole's width: such things are widest at the rim
    base_spread_deg: float = 3.0  # 1..10: of the slope that the base of a can tells
    cut_factor: float = 3.0  # 1..10: less surely it is not steeper: shadows cut a base flat
    # 0..1: of a can's height, between which its sides are straight
    side_shares: tuple[float, float] = (0.3, 0.7)
    rough_ratio: float = 0.008  # 0.002..0.05: over the width: of those sides from their lines
    min_width_px: int = 24  # 10..100: of a rim that is looked at


RIM = RimSettings()


def has_a_rim(name: str) -> bool:
    """Whether a thing of that name ends above in a level circle."""
    return is_open(name) or is_disc(name)


def rim_of(mask: BoolArray) -> Disc | None:
    """The ellipse whose upper half ends a silhouette above; None where there is none."""
    x0, y0, x1, y1 = bounds(mask)
    if x1 - x0 < RIM.min_width_px:
        return None
    part = mask[y0:y1, x0:x1]
    wide = np.flatnonzero(part.sum(1) >= RIM.widest_share * (x1 - x0))
    if not len(wide):
        return None
    ends = np.flatnonzero(part[wide[0]])
    half, middle = (ends[-1] + 1 - ends[0]) / 2, (ends[-1] + 1 + ends[0]) / 2
    # Near its ends an ellipse is steep, and a pixel to the side is many pixels down.
    across = (np.arange(x1 - x0) + 0.5 - middle) / half
    inner = (np.abs(across) < 0.93) & part.any(0)
    bulge = np.sqrt(1 - across[inner] ** 2)
    top = part.argmax(0)[inner].astype(float)
    (row, rise), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(bulge), -bulge]), top)
    off = float(np.sqrt(np.mean((top - row + rise * bulge) ** 2))) / (2 * half)
    flatness = float(rise) / half
    if (
        off > RIM.max_off_ratio + 0.3 / half
        or not -RIM.flattest_ratio < flatness < RIM.roundest_ratio
        or row > 1.2 * (x1 - x0)
    ):
        return None
    sigma = math.hypot(RIM.rim_spread_deg, math.degrees(1 / half))
    return Disc(y0 + float(row), max(flatness, 0.0), sigma, either=True)


def base_of(mask: BoolArray) -> Disc | None:
    """The ellipse whose lower half ends the silhouette of an upright cylinder below.

    None where its sides are not straight, where it is cut off by the picture's border, or where
    no ellipse between the sides ends it.
    """
    x0, y0, x1, y1 = bounds(mask)
    if x1 - x0 < RIM.min_width_px or y1 >= mask.shape[0] - 1:
        return None
    part = mask[y0:y1, x0:x1]
    lean = _lean(part)
    if lean is None:
        return None
    upright, back = _turned(part, lean)
    fit = _lower_half(upright)
    if fit is None:
        return None
    column, row, half, flatness = fit
    if not -RIM.flattest_ratio < flatness < RIM.roundest_ratio:
        return None
    seen = float(back @ np.array([column, row, 1.0]))
    sigma = math.hypot(RIM.base_spread_deg, math.degrees(1 / half))
    return Disc(y0 + seen, max(flatness, 0.0), sigma, cut=RIM.cut_factor)


def top_of(mask: BoolArray) -> Disc | None:
    """Likewise the ellipse that ends an upright cylinder above, seen from above or from below."""
    disc = base_of(mask[::-1])
    return None if disc is None else replace(disc, row=mask.shape[0] - disc.row, either=True)


def _sides(part: BoolArray) -> tuple[np.ndarray, np.ndarray] | None:
    """The lines (slope, column at row 0) of the left and the right side; None if not straight."""
    height, width = part.shape
    rows = np.arange(round(RIM.side_shares[0] * height), round(RIM.side_shares[1] * height))
    if len(rows) < 6 or not part[rows].any(1).all():
        return None
    left, right = part[rows].argmax(1), width - part[rows][:, ::-1].argmax(1)
    lines = [np.polyfit(rows + 0.5, side, 1) for side in (left, right)]
    off = [
        np.std(side - np.polyval(line, rows + 0.5))
        for side, line in zip((left, right), lines, strict=True)
    ]
    across = float(np.median(right - left))
    return (lines[0], lines[1]) if max(off) < RIM.rough_ratio * across + 0.25 else None


def _lean(part: BoolArray) -> float | None:
    """How far the axis between the sides leans to the left below, rad."""
    sides = _sides(part)
    return None if sides is None else float(-np.arctan((sides[0][0] + sides[1][0]) / 2))


def _turned(part: BoolArray, lean: float) -> tuple[BoolArray, np.ndarray]:
    """The mask with its axis upright, and (3,) what gives the row before of a place in it."""
    height, width = part.shape
    side = round(math.hypot(height, width)) + 2
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), math.degrees(lean), 1.0)
    turn[:, 2] += (side - width) / 2, (side - height) / 2
    turned = cv2.warpAffine(part.astype(np.float32), turn, (side, side), flags=cv2.INTER_LINEAR)
    return np.asarray(turned > 0.5), cv2.invertAffineTransform(turn)[1]


def _lower_half(part: BoolArray) -> tuple[float, float, float, float] | None:
    """Column and row of the middle, half width and flatness of the ellipse that ends it below."""
    x0, y0, x1, y1 = bounds(part)
    part = part[y0:y1, x0:x1]
    sides = _sides(part)
    if sides is None:
        return None
    height, width = part.shape
    low = (height - part[::-1].argmax(0)).astype(float)
    row = height - 0.15 * width
    column, half, rise, off = 0.0, 1.0, 0.0, 1.0
    for _ in range(6):
        left, right = (float(np.polyval(line, row)) for line in sides)
        column, half = (left + right) / 2, (right - left) / 2
        if half < RIM.min_width_px / 3:
            return None
        across = (np.arange(width) + 0.5 - column) / half
        inner = (np.abs(across) < 0.93) & part.any(0)
        if np.count_nonzero(inner) < RIM.min_width_px / 3:
            return None
        bulge = np.sqrt(1 - across[inner] ** 2)
        lower = low[inner]
        (row, rise), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(bulge), bulge]), lower)
        off = float(np.sqrt(np.mean((lower - row - rise * bulge) ** 2)))
    if off > (RIM.max_off_ratio + 0.3 / half) * 2 * half:
        return None
    return x0 + column, y0 + float(row), half, float(rise) / half
