"""What a mask shows by itself: its colours, the clicks it covers, its outline's contrast."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    Pixel,
    bounds,
    grow,
)
from physagent_studio.reconstruction.photo.statistics import lengths, median

_SQUARE = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False, slots=True)
class Draft:
    """A candidate before it is scored.

    method: short name. family: what it goes by: colour, contour, the map, a union of two families,
    or another draft.
    """

    mask: BoolArray
    method: str
    family: str


@dataclass(frozen=True, slots=True)
class Shown:
    """What a draft shows by itself, each 0 … 1: how far the colours inside are those around, and

    how many clicks it covers.
    """

    overlap: float
    covered: float


def shown_by(
    drafts: Sequence[Draft], lab: NDArray[np.float32], inside: Sequence[Pixel]
) -> list[Shown]:
    """What each draft shows on a view (h, w, 3), L*a*b* as 0 … 255, with clicks inside."""
    palette = _palette(lab)
    return [Shown(_overlap(palette, one.mask), _covered(one.mask, inside)) for one in drafts]


def likeness(drafts: Sequence[Draft]) -> FloatArray:
    """(N, N) IoU of any two drafts."""
    every = np.stack([draft.mask.ravel() for draft in drafts]).astype(np.float32)
    shared = (every @ every.T).astype(float)
    area = np.diag(shared)
    return shared / np.maximum(area[:, None] + area[None] - shared, 1)


def _overlap(palette: NDArray, mask: BoolArray) -> float:
    """How far the colours inside a mask are those around it, 0 … 1."""
    x0, y0, x1, y1 = bounds(mask)
    crop = (slice(max(0, y0 - 12), y1 + 12), slice(max(0, x0 - 12), x1 + 12))
    own = np.ascontiguousarray(mask[crop])
    area = int(np.count_nonzero(own))
    ring = grow(own, max(3, int(np.sqrt(area) * 0.12))) & ~grow(own, 1)
    inside = np.bincount(palette[crop][own], minlength=2048) / max(area, 1)
    around = np.bincount(palette[crop][ring], minlength=2048) / max(np.count_nonzero(ring), 1)
    return float(np.sqrt(inside * around).sum())


def _palette(lab: NDArray[np.float32]) -> NDArray[np.int64]:
    """Each pixel's colour as one of 2048 bins."""
    q = np.clip((lab / 256 * (8, 16, 16)).astype(int), 0, (7, 15, 15))
    return (q[..., 0] * 16 + q[..., 1]) * 16 + q[..., 2]


def _covered(mask: BoolArray, inside: Sequence[Pixel]) -> float:
    """Share of the clicks that the mask covers; one beside the view counts at its border."""
    if not inside:
        return 1.0
    rows, columns = mask.shape
    at = [(int(np.clip(y, 0, rows - 1)), int(np.clip(x, 0, columns - 1))) for x, y in inside]
    return float(np.mean([mask[pixel] for pixel in at]))


def outline_contrast(lab: NDArray[np.float32], mask: BoolArray) -> float:
    """The median, along the outline, of the colour step across it."""
    solid = mask.astype(np.uint8)
    inner = mask & ~cv2.erode(solid, _SQUARE, iterations=3).astype(bool)
    core = cv2.erode(solid, _SQUARE).astype(bool)
    # A thin part has no core: its own pixels have to do.
    inner = np.where(cv2.boxFilter(core.astype(np.float32), -1, (5, 5)) > 0, inner & core, inner)
    outer = cv2.dilate(solid, _SQUARE, iterations=4).astype(bool)
    outer &= ~cv2.dilate(solid, _SQUARE).astype(bool)
    if np.count_nonzero(inner) < 8 or np.count_nonzero(outer) < 8:
        return 0.0
    within, beyond = (_sums_about(lab, region) for region in (inner, outer))
    rim = mask & ~core
    rim[:2] = rim[-2:] = False
    rim[:, :2] = rim[:, -2:] = False
    rim &= (within[1] > 0) & (beyond[1] > 0)
    if np.count_nonzero(rim) < 8:
        return 0.0
    inside, outside = (total[rim] / count[rim][:, None] for total, count in (within, beyond))
    return median(np.sort(lengths(inside - outside)))


def _sums_about(lab: NDArray[np.float32], region: BoolArray) -> tuple[NDArray, NDArray]:
    """Sum (H, W, 3) of the colours of a region near each pixel, and how many (H, W) they are."""
    weight = region.astype(np.float32)
    count = cv2.boxFilter(weight, -1, (9, 9), normalize=False)
    own = cv2.copyTo(lab, region.view(np.uint8))
    total = cv2.boxFilter(own, -1, (9, 9), normalize=False)
    return np.asarray(total), np.asarray(count)
