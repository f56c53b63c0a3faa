"""Shadows of things in the air: they lie on the ground by themselves, off the thing's foot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatImage, IntArray
from physagent_studio.reconstruction.background.surfaces import SURFACE
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class DetachedSettings:
    """What is taken for the shadow of a thing in the air."""

    longer_px: int = 208  # 100..400: side of the picture in which it is looked for
    smallest_px: int = 24  # 8..100: size of a thing in it
    # own sizes, 0.5..6: to each side of a thing and below it, how far off its shadow may lie
    reach_sizes: tuple[float, float] = (2.0, 4.0)
    # own sizes, 1..4: side of the square whose median colour is taken for the ground's
    ground_sizes: float = 2.2
    # log, 0.02..0.5: by which every colour is darker than the ground, and the mean of them is
    min_darker_logs: tuple[float, float] = (0.04, 0.12)
    # log, 0.2..1: by which one colour may be darker than another: the sky lights a shadow blue
    max_tint_log: float = 0.6
    max_redder_log: float = 0.15  # log, 0..0.4: by which red may be less darkened than blue is
    # own sizes, 0.05..1: spread of the spots that are compared, across and down
    spot_shares: tuple[float, float] = (0.22, 0.1)
    peak_ratio: float = 1.5  # 1.1..4: of the darkest spot's darkness over that of any other
    min_peak_log: float = 0.06  # log, 0.02..0.3: how dark it is there in the mean of a spot
    peaks_count: int = 6  # count, 1..10: of the darkest places that are looked at
    same_ground_levels: int = 30  # grey levels, 10..80: by which ground of one kind differs
    area_shares: tuple[float, float] = (0.06, 0.9)  # 0.02..2: of its area over the thing's
    width_shares: tuple[float, float] = (0.45, 1.4)  # 0.2..4: of its width over the thing's
    min_solid_share: float = 0.78  # 0.5..1: of its convex hull that it fills: things are round
    rim_px: int = 3  # 1..8: of the smaller picture, over which it fades out
    faint_ratio: float = 0.3  # 0.1..0.6: of its darkness, of what its rim still has
    # 0.5..1: of the ground right around it that is less than half as dark
    min_lit_share: float = 0.8
    min_one_ground_share: float = 0.4  # 0.2..0.8: of what is right around it, of one colour


DETACHED = DetachedSettings()


def detached(
    photo: Image, aloft: Sequence[BoolArray], hole: BoolArray, faces: IntArray
) -> BoolArray:
    """(H, W) the shadow of each thing in the air, where one spot of the ground below looks like it.

    aloft: their masks. hole: (H, W) what is taken out anyway. faces: as `surfaces` gives them.
    """
    out = np.zeros(hole.shape, bool)
    for mask in aloft:
        if mask.any():
            out |= _of_one(photo, mask, hole, faces)
    return out & ~hole


def _of_one(photo: Image, mask: BoolArray, hole: BoolArray, faces: IntArray) -> BoolArray:
    x0, y0, x1, y1 = bounds(mask)
    side = max(x1 - x0, y1 - y0)
    factor = min(1.0, max(DETACHED.longer_px / max(hole.shape), DETACHED.smallest_px / side))
    size = (max(8, round(hole.shape[1] * factor)), max(8, round(hole.shape[0] * factor)))
    small = np.asarray(cv2.resize(photo, size, interpolation=cv2.INTER_AREA), np.uint8)
    inside, own, level = (
        cv2.resize(what.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
        for what in (hole, mask, faces != SURFACE.beyond_number)
    )
    if not own.any():
        return np.zeros_like(hole)
    spot = _spot(small, own, inside, level)
    wide = cv2.resize(spot.astype(np.float32), hole.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.asarray(wide > 0.4)


def _spot(photo: Image, own: BoolArray, inside: BoolArray, level: BoolArray) -> BoolArray:
    """The darkest spot of the ground that is as large and as round as a shadow would be."""
    x0, y0, x1, y1 = bounds(own)
    side, rows = max(x1 - x0, y1 - y0), np.arange(own.shape[0])[:, None]
    columns = np.arange(own.shape[1])[None, :]
    aside, below = (round(far * side) for far in DETACHED.reach_sizes)
    beside = (columns >= x0 - aside) & (columns < x1 + aside)
    near = level & ~grow(inside, 2) & beside & (rows > (y0 + y1) // 2) & (rows < y1 + below)
    window = min(2 * (round(DETACHED.ground_sizes * side) // 2) + 1, 255)
    usual = np.asarray(cv2.medianBlur(photo, window), np.uint8)
    darker = _darker(photo, usual)
    tinted = np.ptp(darker, axis=-1) < DETACHED.max_tint_log
    tinted &= darker[..., 2] - darker[..., 0] < DETACHED.max_redder_log
    dark = (darker.min(-1) > DETACHED.min_darker_logs[0]) & near & tinted
    depth = np.where(dark, darker.mean(-1), 0).astype(np.float32)
    spread = tuple(max(share * side, 1.0) for share in DETACHED.spot_shares)
    # Cut off at the top: what is black counts no more than a shadow.
    blurred = cv2.GaussianBlur(np.minimum(depth, 1.0), (0, 0), spread[0], sigmaY=spread[1])
    spots = np.asarray(blurred, np.float32)
    soft = np.asarray(cv2.GaussianBlur(depth, (0, 0), 1.0), np.float32)
    for peak, around in _peaks(spots, spread):
        if _is_unlike_others(spots, peak, around, usual):
            spot = _spot_at(soft, peak, own, near)
            if spot.any() and _is_on_one_ground(photo, spot):
                return spot
    return np.zeros_like(own)


def _peaks(
    spots: FloatImage, spread: tuple[float, ...]
) -> Iterator[tuple[tuple[int, int], BoolArray]]:
    """Row and column of the darkest places, one after the other, and (H, W) what is around each."""
    left, (rows, columns) = spots.copy(), np.indices(spots.shape)
    for _ in range(DETACHED.peaks_count):
        row, column = (int(k) for k in np.unravel_index(int(left.argmax()), left.shape))
        if left[row, column] < DETACHED.min_peak_log:
            return
        around = np.abs(rows - row) <= 4 * spread[1]
        around &= np.abs(columns - column) <= 4 * spread[0]
        yield (row, column), around
        left[around] = 0


def _is_unlike_others(
    spots: FloatImage, peak: tuple[int, int], around: BoolArray, usual: Image
) -> bool:
    """Whether no other spot of the same ground is nearly as dark, as those of a pattern are."""
    off = np.abs(usual.astype(int) - usual[peak].astype(int)).max(-1)
    others = ~around & (off < DETACHED.same_ground_levels)
    second = float(spots[others].max(initial=0.0))
    return float(spots[peak]) >= DETACHED.peak_ratio * second


def _spot_at(soft: FloatImage, peak: tuple[int, int], own: BoolArray, near: BoolArray) -> BoolArray:
    """(H, W) the spot there with its rim; nothing where it is no shadow by its size and outline.

    soft: (H, W) how dark it is, log.
    """
    deep = (soft > float(soft[peak]) / 2).astype(np.uint8)
    deep = cv2.morphologyEx(deep, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    _, labels, stats, _ = cv2.connectedComponentsWithStats(deep)
    number = int(labels[peak])
    spot = np.asarray(labels == number)
    is_dark = float(soft[peak]) > DETACHED.min_darker_logs[1]
    if not number or not is_dark or not _is_like(spot, stats[number], own):
        return np.zeros_like(own)
    if not _is_lit_around(spot, soft, near):
        return np.zeros_like(own)
    faint = near & (soft > DETACHED.faint_ratio * float(soft[spot].mean()))
    wide = spot
    for _ in range(DETACHED.rim_px):
        wide = spot | (grow(wide, 1) & faint)
    return grow(wide, DETACHED.rim_px)


def _darker(photo: Image, usual: Image) -> FloatImage:
    """(H, W, 3) by how much each colour is darker than what is usual around, log."""
    soft = cv2.GaussianBlur(photo, (0, 0), 1.0)
    logs = (np.log(np.maximum(one.astype(np.float32), 4.0)) for one in (usual, soft))
    return np.asarray(np.subtract(*logs), np.float32)


def _is_like(spot: BoolArray, stats: IntArray, own: BoolArray) -> bool:
    """Whether a spot may be the shadow of a thing by its size and outline."""
    x0, _, x1, _ = bounds(own)
    area = stats[cv2.CC_STAT_AREA] / np.count_nonzero(own)
    width = stats[cv2.CC_STAT_WIDTH] / (x1 - x0)
    if not DETACHED.area_shares[0] <= area <= DETACHED.area_shares[1]:
        return False
    if not DETACHED.width_shares[0] <= width <= DETACHED.width_shares[1]:
        return False
    outlines, _ = cv2.findContours(spot.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    hull = cv2.convexHull(np.concatenate(outlines))
    full = cv2.fillConvexPoly(np.zeros(spot.shape, np.uint8), hull, 1)
    return bool(np.count_nonzero(spot) >= DETACHED.min_solid_share * np.count_nonzero(full))


def _is_on_one_ground(photo: Image, spot: BoolArray) -> bool:
    """Whether the ground all around a spot is of one kind: it does not lie between things."""
    rim = grow(spot, DETACHED.rim_px) & ~spot
    colours = photo[rim].astype(int)
    off = np.abs(colours - np.median(colours, axis=0)).max(-1)
    same = off < DETACHED.same_ground_levels
    return len(off) > 0 and float(same.mean()) >= DETACHED.min_one_ground_share


def _is_lit_around(spot: BoolArray, depth: FloatImage, near: BoolArray) -> bool:
    """Whether lit ground is all around a spot. depth: (H, W) how dark it is, log."""
    rim = grow(spot, 2 * DETACHED.rim_px) & ~grow(spot, DETACHED.rim_px)
    if not rim.any() or near[rim].mean() < DETACHED.min_lit_share:
        return False
    lit = depth[rim] < float(depth[spot].mean()) / 2
    return bool(lit.mean() >= DETACHED.min_lit_share)
