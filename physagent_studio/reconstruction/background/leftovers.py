"""What a mask has missed of its thing: it would stay behind in the background when this moves.

Found by colour: beside the outline, more usual on the thing than anywhere around it, and small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatImage
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, shrink
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class LeftoverSettings:
    """How colours are counted, and how far from the thing."""

    bins_count: int = 20  # 8..40: of each of lightness and the two colours
    reach_ratio: float = 0.45  # 0.1..1: over the thing's size, how far from it is looked
    scrap_reach_ratio: float = 0.1  # 0.03..0.3: the same for scraps, which end that near
    min_scrap_px: int = 6  # 3..30: smaller ones are noise
    max_scrap_share: float = 0.01  # 0.001..0.05: of the thing's area: larger is no scrap
    ground_ratio: float = 0.35  # 0.1..1: over that reach, spread of the ground's mean colour
    least_off_levels: float = 16.0  # 6..40: from which on something stands out of it
    smooth_percent: float = 80.0  # %, 50..95: so much of smooth ground is off by half of that


LEFTOVER = LeftoverSettings()


def leftovers(photo: Image, masks: Sequence[BoolArray], hole: BoolArray) -> BoolArray:
    """(H, W) pixels outside the hole that look like parts of the masked things beside them."""
    lab = cv2.cvtColor(cv2.GaussianBlur(photo, (0, 0), 0.8), cv2.COLOR_RGB2LAB)
    out = np.zeros(hole.shape, bool)
    for mask in masks:
        if not mask.any():
            continue
        x0, y0, x1, y1 = bounds(mask)
        reach = max(8, round(LEFTOVER.reach_ratio * max(x1 - x0, y1 - y0)))
        rows = slice(max(0, y0 - 2 * reach), y1 + 2 * reach)
        window = rows, slice(max(0, x0 - 2 * reach), x1 + 2 * reach)
        out[window] |= _of_one(np.asarray(lab[window], np.uint8), mask[window], hole[window], reach)
    return out


def scraps(photo: Image, masks: Sequence[BoolArray], hole: BoolArray) -> BoolArray:
    """(H, W) small bits at the rim of the hole that stand out of smooth ground: tips of stems and

    leaves, hairs, the soft rim of a thing. Of whatever colour: nothing else is there by itself.
    """
    out = np.zeros(hole.shape, bool)
    for mask in masks:
        if not mask.any():
            continue
        x0, y0, x1, y1 = bounds(mask)
        size = max(x1 - x0, y1 - y0)
        reach = max(6, round(LEFTOVER.scrap_reach_ratio * size))
        window = (
            slice(max(0, y0 - 3 * reach), y1 + 3 * reach),
            slice(max(0, x0 - 3 * reach), x1 + 3 * reach),
        )
        near = grow(mask[window], reach) & ~hole[window]
        far = grow(mask[window], 2 * reach) & ~near & ~hole[window]
        stands = _standing_out(photo[window], hole[window], near | far, reach)
        if stands is None:
            continue
        _, labels, stats, _ = cv2.connectedComponentsWithStats(stands.astype(np.uint8))
        touching = np.unique(labels[grow(hole[window], 2) & stands])
        beyond = set(np.unique(labels[far & stands]).tolist())
        most = max(12.0, LEFTOVER.max_scrap_share * np.count_nonzero(mask))
        areas = stats[:, cv2.CC_STAT_AREA]
        kept = [
            k
            for k in touching
            if k and k not in beyond and LEFTOVER.min_scrap_px <= areas[k] <= most
        ]
        out[window] |= np.isin(labels, kept) & near
    return out


def _standing_out(photo: Image, hole: BoolArray, beside: BoolArray, reach: int) -> BoolArray | None:
    """(H, W) what differs from the mean colour around it beside a hole; None on rough ground."""
    weight = (~hole).astype(np.float32)
    picture = photo.astype(np.float32)
    spread = max(3.0, LEFTOVER.ground_ratio * reach)
    off = np.zeros(hole.shape, np.float32)
    for _ in range(3):
        count = _blurred(weight, spread)[..., None]
        mean = _blurred(picture * weight[..., None], spread)
        off = np.abs(picture - mean / np.maximum(count, 1e-4)).max(-1)
        weight = (~hole) / (1 + (off / LEFTOVER.least_off_levels) ** 2).astype(np.float32)
    if not beside.any():
        return None
    usual = float(np.percentile(off[beside], LEFTOVER.smooth_percent))
    if usual > LEFTOVER.least_off_levels / 2:
        return None
    return beside & (off > LEFTOVER.least_off_levels)


def _blurred(picture: FloatImage, spread: float) -> FloatImage:
    """The picture (H, W) or (H, W, C) blurred by so many pixels; far, on a smaller one."""
    fine_px = 8.0  # 4..20: spread up to which every pixel is looked at
    if spread <= fine_px:
        return np.asarray(cv2.GaussianBlur(picture, (0, 0), spread), np.float32)
    rows, columns = picture.shape[:2]
    size = max(round(columns * fine_px / spread), 1), max(round(rows * fine_px / spread), 1)
    small = cv2.GaussianBlur(
        cv2.resize(picture, size, interpolation=cv2.INTER_AREA), (0, 0), fine_px
    )
    return np.asarray(cv2.resize(small, (columns, rows)), np.float32)


def _of_one(lab: Image, mask: BoolArray, hole: BoolArray, reach: int) -> BoolArray:
    near = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5) <= reach
    around = ~near & ~hole
    inner = shrink(mask, 2)
    if np.count_nonzero(around) < 200 or np.count_nonzero(inner) < 30:
        return np.zeros_like(mask)
    own, other = _usual(lab, inner), _usual(lab, around)
    bins = _bins(lab)
    gap_ratio = 0.03  # 0.01..0.1: over the thing's size, between it and a leftover
    gap = max(2, round(gap_ratio * reach / LEFTOVER.reach_ratio))
    more_factor = 8.0  # 2..30: by which a colour is more usual on the thing than around it
    rare_ratio = 0.01  # 0.001..0.1: over the thing's commonest colour: less is a chance find
    like = (own[bins] > more_factor * other[bins] + own.max() * rare_ratio) & near & ~hole
    return _small(like, mask, hole, near, gap)


def _small(
    like: BoolArray, mask: BoolArray, hole: BoolArray, near: BoolArray, gap: int
) -> BoolArray:
    """The parts of what is like the thing that touch the hole, and are small and end near it."""
    like = cv2.morphologyEx(like.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) > 0
    _, labels, stats, _ = cv2.connectedComponentsWithStats(like.astype(np.uint8))
    touching = np.unique(labels[grow(hole, gap) & like])
    # What goes on beyond the reach, or is large, is something else of this colour.
    rim = like & ~shrink(near, 2)
    beyond = set(np.unique(labels[rim]).tolist())
    largest_share = 0.12  # 0.03..0.4: of the thing's area
    most = largest_share * np.count_nonzero(mask)
    kept = [
        int(k)
        for k in touching
        if k and k not in beyond and 4 <= stats[k, cv2.CC_STAT_AREA] <= most
    ]
    # Where more than a little around it has its colours, these tell nothing.
    found = np.isin(labels, kept) & ~hole
    return found if np.count_nonzero(found) <= most else np.zeros_like(found)


def _bins(lab: Image) -> tuple[NDArray[np.intp], ...]:
    return tuple((lab[..., k].astype(np.intp) * LEFTOVER.bins_count) // 256 for k in range(3))


def _usual(lab: Image, where: BoolArray) -> FloatImage:
    """How usual each colour is in a part of the picture, (BINS, BINS, BINS)."""
    counts = np.zeros((LEFTOVER.bins_count, LEFTOVER.bins_count, LEFTOVER.bins_count), np.float32)
    np.add.at(counts, tuple(b[where] for b in _bins(lab)), 1.0)
    counts /= counts.sum()
    for axis in range(3):
        side = np.zeros_like(counts)
        before = [slice(None)] * 3
        after = [slice(None)] * 3
        before[axis], after[axis] = slice(None, -1), slice(1, None)
        side[tuple(after)] += counts[tuple(before)]
        side[tuple(before)] += counts[tuple(after)]
        counts = counts + 0.5 * side
    return counts
