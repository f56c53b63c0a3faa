"""Operations on boolean masks that every segmenter shares."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray


@dataclass(frozen=True, slots=True)
class RegionSettings:
    """How masks are widened and narrowed by much."""

    # 8..40: from which the distances of all pixels are sooner known than a disc is laid on each
    wide_px: int = 16
    rounded_px: float = 0.3  # 0..0.5: by which OpenCV's discs of such radii reach beyond them


REGIONS = RegionSettings()
FloatArray = NDArray[np.float32]
Pixel = tuple[float, float]


def iou(first: BoolArray, second: BoolArray) -> float:
    """Intersection over union of two masks of one size; 0 where both are empty."""
    union = int(np.count_nonzero(first | second))
    return int(np.count_nonzero(first & second)) / union if union else 0.0


def disc(radius: int) -> NDArray[np.uint8]:
    """A round structuring element."""
    size = 2 * max(int(radius), 1) + 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)).astype(np.uint8)


def grow(mask: BoolArray, radius: int) -> BoolArray:
    """The mask widened by `radius` pixels."""
    if radius <= 0 or (radius > REGIONS.wide_px and not mask.any()):
        return mask
    if radius > REGIONS.wide_px:
        return _away(~mask) <= radius + REGIONS.rounded_px
    return cv2.dilate(mask.astype(np.uint8), disc(radius)).astype(bool)


def shrink(mask: BoolArray, radius: int) -> BoolArray:
    """The mask narrowed by `radius` pixels; outside the picture counts as inside."""
    if radius <= 0 or (radius > REGIONS.wide_px and mask.all()):
        return mask
    if radius > REGIONS.wide_px:
        return _away(mask) > radius + REGIONS.rounded_px
    return cv2.erode(mask.astype(np.uint8), disc(radius)).astype(bool)


def _away(mask: BoolArray) -> FloatArray:
    """(H, W) how far each pixel of a mask is from the nearest that is not in it."""
    away = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(away, np.float32)


def holding(mask: BoolArray, points: Sequence[Pixel], reach: int = 4) -> BoolArray:
    """The connected parts of the mask that lie within `reach` pixels of a point."""
    if not len(points) or not mask.any():
        return mask
    count, found = cv2.connectedComponents(mask.astype(np.uint8))
    labels = np.asarray(found, np.int32)
    kept = np.zeros(count, bool)
    rows, columns = mask.shape
    for x, y in points:
        column = int(np.clip(x, 0, columns - 1))
        row = int(np.clip(y, 0, rows - 1))
        near = labels[
            max(0, row - reach) : row + reach + 1, max(0, column - reach) : column + reach + 1
        ]
        kept[near.ravel()] = True
    kept[0] = False
    return kept[labels]


def without_pinholes(mask: BoolArray, share: float) -> BoolArray:
    """The mask with those of its holes filled that are smaller than `share` of its area."""
    if not mask.any():
        # Around nothing there is no hole, however large they may be.
        return mask.copy()
    holes = (~mask).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(holes, connectivity=4)
    rows, columns = mask.shape
    limit = share * np.count_nonzero(mask)
    out = mask.copy()
    for label in range(1, count):
        x, y, width, height, area = (int(value) for value in stats[label])
        inside = x > 0 and y > 0 and x + width < columns and y + height < rows
        if inside and area < limit:
            out[labels == label] = True
    return out


def smooth(mask: BoolArray, share: float = 0.02) -> BoolArray:
    """The mask without single-pixel hairs, its notches closed up to `share` of its width."""
    radius = max(1, round(float(np.sqrt(np.count_nonzero(mask))) * share))
    opened = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, disc(1))
    return cv2.morphologyEx(opened, cv2.MORPH_CLOSE, disc(radius)).astype(bool)


def resized(mask: BoolArray, size: tuple[int, int]) -> BoolArray:
    """The mask at another size (width, height), its outline smoothed, not stepped."""
    factor = size[0] / mask.shape[1]
    small = mask.astype(np.float32)
    early_factor = 4.0  # 2..10: an outline enlarged more is smoothed while it is small
    if factor > early_factor:
        # Smoothed before it is enlarged: the same outline for a fraction of the work.
        small = cv2.GaussianBlur(small, (0, 0), 0.6)
        return np.asarray(cv2.resize(small, size, interpolation=cv2.INTER_LINEAR) > 0.5)
    big = cv2.resize(small, size, interpolation=cv2.INTER_LINEAR)
    if factor > 1.2:
        big = cv2.GaussianBlur(big, (0, 0), 0.45 * factor)
    return np.asarray(big > 0.5)


def outline_length(mask: BoolArray) -> float:
    """Number of outline pixels, holes included."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    return float(sum(len(part) for part in found))


def solidity(mask: BoolArray) -> float:
    """Area of the mask over the area of its convex hull."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return 0.0
    hull = cv2.convexHull(np.vstack(found))
    return float(np.count_nonzero(mask)) / max(cv2.contourArea(hull), 1.0)


def border_share(mask: BoolArray, width: int = 2) -> float:
    """Share of the outline that runs along the border of the picture."""
    edges = (mask[:width], mask[-width:], mask[:, :width], mask[:, -width:])
    touching = sum(int(np.count_nonzero(edge)) for edge in edges) / width
    return touching / max(outline_length(mask), 1.0)


def bounds(mask: BoolArray) -> tuple[int, int, int, int]:
    """(x0, y0, x1, y1) of the mask, the last two exclusive; zeros for an empty mask."""
    rows = np.flatnonzero(mask.any(1))
    columns = np.flatnonzero(mask.any(0))
    if not len(rows):
        return (0, 0, 0, 0)
    return (int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1)
