"""Mirror images of things on polished ground: they leave with their things."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray, FloatImage
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class MirrorSettings:
    """What is taken for a mirror image."""

    off_px: int = 3  # 1..8: inside and outside of the outline, where colours are compared
    clear_lab: float = 1.1  # 1..8: L*a*b* between the two, at least
    one_way_share: float = 0.9  # 0.5..1: of its rows on which the two differ the same way
    better_factor: float = 2.2  # 1.2..5: over the same outline somewhere beside
    # -2..2: of the thing's width, where that is
    beside_ratios: tuple[float, ...] = (-1.1, -0.8, -0.5, 0.5, 0.8, 1.1)
    # -0.3..0.3: heights by which it begins lower than the mask ends: masks stray
    step_ratios: tuple[float, ...] = (-0.16, -0.12, -0.08, -0.04, 0.0, 0.04, 0.08)


MIRROR = MirrorSettings()


def mirrored(photo: Image, masks: Sequence[BoolArray]) -> BoolArray:
    """(H, W) where the ground shows the masked things upside down below their feet."""
    soft = cv2.GaussianBlur(photo, (0, 0), 1.2).astype(np.float32) / 255
    lab = np.asarray(cv2.cvtColor(soft, cv2.COLOR_RGB2LAB), np.float32)
    out = np.zeros(photo.shape[:2], bool)
    masks = [mask for mask in masks if mask.any()]
    covered = np.any(masks, axis=0) if masks else out
    images = [
        _of_one(lab, mask, grow(covered, 2), _mirrored_beside(masks, own))
        for own, mask in enumerate(masks)
    ]
    polished = any(
        image.contrast > MIRROR.clear_lab and image.contrast > MIRROR.better_factor * image.beside
        for image in images
    )
    also_factor = 1.4  # 1..3: the same where the ground is known to mirror other things
    for image in images:
        # Ground that mirrors one thing mirrors the others, if less clearly.
        if (
            polished
            and image.contrast > MIRROR.clear_lab / 2
            and image.contrast > also_factor * image.beside
        ):
            out |= image.where
    return out & ~covered


@dataclass(frozen=True, eq=False, slots=True)
class _Mirrored:
    """Where a thing's mirror image would be (H, W), how much its outline is seen there, and how
    much the same outline is seen beside."""

    where: BoolArray
    contrast: float
    beside: float


def _mirrored_beside(masks: Sequence[BoolArray], own: int) -> BoolArray:
    """(H, W) where the others' mirror images would be: they tell nothing of one's own."""
    out = np.zeros_like(masks[own])
    for number, mask in enumerate(masks):
        if number != own:
            out |= _upside_down(mask, bounds(mask)[3])
    return grow(out, 2 * MIRROR.off_px)


def _of_one(lab: FloatImage, mask: BoolArray, covered: BoolArray, others: BoolArray) -> _Mirrored:
    x0, y0, x1, y1 = bounds(mask)
    wide, high = (
        round((MIRROR.beside_ratios[-1] + 0.1) * (x1 - x0)),
        round((1.1 + MIRROR.step_ratios[-1]) * (y1 - y0)),
    )
    window = slice(y0, y1 + high + 3 * MIRROR.off_px), slice(max(0, x0 - wide), x1 + wide)
    found = _in_window(lab[window], mask[window], covered[window], others[window])
    where = np.zeros_like(mask)
    where[window] = found.where
    return _Mirrored(where, found.contrast, found.beside)


def _in_window(
    lab: FloatImage, mask: BoolArray, covered: BoolArray, others: BoolArray
) -> _Mirrored:
    x0, y0, x1, y1 = bounds(mask)
    high = y1 - y0
    best = _Mirrored(np.zeros_like(mask), 0.0, 0.0)
    nearest_ratio = 0.2  # 0.05..0.5: heights below the foot: nearer there is shade
    low = y1 + max(2 * MIRROR.off_px, round(nearest_ratio * high))
    seen_ratio = 0.15  # 0.05..0.5: heights that have to be in view below that
    stands_share = 0.3  # 0.1..0.8: of its width that is above another thing: it stands on that
    # What stands on another thing is mirrored by none of the ground that is seen below it.
    if mask.shape[0] - low < seen_ratio * high or covered[low - 1, x0:x1].mean() > stands_share:
        return best
    for step in MIRROR.step_ratios:
        image = _upside_down(mask, y1 + round(step * high))
        own = _contrast(lab, image, covered, low, MIRROR.one_way_share)
        if own < MIRROR.clear_lab / 2:
            continue
        beside = max(
            _contrast(lab, _shifted(image, round(share * (x1 - x0))), covered | others, low)
            for share in MIRROR.beside_ratios
        )
        if (
            own - MIRROR.better_factor * beside > best.contrast - MIRROR.better_factor * best.beside
            or not best.contrast
        ):
            best = _Mirrored(grow(image, MIRROR.off_px + 2), own, beside)
    return best


def _upside_down(mask: BoolArray, foot: int) -> BoolArray:
    """The mask (H, W) mirrored at a row."""
    rows = 2 * foot - 1 - np.arange(mask.shape[0])
    inside = (rows >= 0) & (rows < mask.shape[0])
    return np.asarray(mask[rows.clip(0, mask.shape[0] - 1)] & inside[:, None])


def _shifted(mask: BoolArray, by: int) -> BoolArray:
    out = np.zeros_like(mask)
    width = mask.shape[1]
    if abs(by) < width:
        out[:, max(0, by) : width + min(0, by)] = mask[:, max(0, -by) : width - max(0, by)]
    return out


def _contrast(
    lab: FloatImage, shape: BoolArray, covered: BoolArray, low: int, one_way: float = 0.0
) -> float:
    """How much the two sides of an outline differ below a row, to its left and to its right alike.

    0 where they do not differ the same way on this share of its rows: an image ends all along it.
    """
    solid = shape.astype(np.uint8)
    square = np.ones((2 * MIRROR.off_px + 1,) * 2, np.uint8)
    inner, outer = solid - cv2.erode(solid, square), cv2.dilate(solid, square) - solid
    bands = np.stack([inner > 0, outer > 0]) & ~covered
    bands[:, :low] = False
    columns = np.nonzero(shape.any(0))[0]
    if not len(columns):
        return 0.0
    middle = int(columns.mean()) + 1
    steps = [
        found
        for part in (slice(None, middle), slice(middle, None))
        if len(found := _steps(lab[:, part], bands[:, :, part])) > 4
    ]
    if sum(map(len, steps)) <= 8:
        return 0.0
    usual = np.median(np.concatenate(steps), axis=0)
    size = float(np.linalg.norm(usual))
    along = [step @ usual / max(size, 1e-6) for step in steps]
    alike = np.concatenate(along) > 0.25 * size
    return max(0.0, min(float(np.median(one)) for one in along)) if alike.mean() >= one_way else 0.0


def _steps(lab: FloatImage, bands: BoolArray) -> FloatArray:
    """(N, 3) by how much the inner of two bands (2, H, W) differs from the outer in each row."""
    counts = bands.sum(2)
    both = (counts > 0).all(0)
    sums = [np.einsum("hwc,hw->hc", lab[both], band[both]) for band in bands]
    inner, outer = (total / number[both, None] for total, number in zip(sums, counts, strict=True))
    return np.asarray(inner - outer)
