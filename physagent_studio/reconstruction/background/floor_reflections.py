"""Mirror images of things on polished ground: they leave with their things."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.records.case import Image

FloatImage = NDArray[np.float32]
FloatArray = NDArray[np.float64]
NEAREST = 0.2
"""How far below the foot its outline is looked at first, in heights: nearer there is shade."""
SEEN = 0.15
"""How much of it has to be in view below that, in heights."""
OFF = 3
"""How far inside and outside of the outline colours are compared, pixels."""
CLEAR = 2.8
"""Least difference between the two, in L*a*b*."""
BETTER = 2.2
"""How much larger it is than along the same outline somewhere beside."""
ALSO = 1.4
"""The same where the ground is known to mirror other things."""
BESIDE = (-1.1, -0.8, -0.5, 0.5, 0.8, 1.1)
"""Where, in widths of the thing."""
STANDS = 0.3
"""Share of the thing's width below which there is another one, to stand on that."""
STEPS = (-0.16, -0.12, -0.08, -0.04, 0.0, 0.04, 0.08)
"""How much lower than the mask's lowest row it may begin, in heights: masks end a little too high,
or hold the beginning of the image itself, and the foot's near side is lower than its middle."""


def mirrored(photo: Image, masks: Sequence[BoolArray]) -> BoolArray:
    """(H, W) where the ground shows the masked things upside down below their feet."""
    soft = cv2.GaussianBlur(photo, (0, 0), 1.2).astype(np.float32) / 255
    lab = np.asarray(cv2.cvtColor(soft, cv2.COLOR_RGB2LAB), np.float32)
    out = np.zeros(photo.shape[:2], bool)
    covered = np.any(list(masks), axis=0) if len(masks) else out
    images = [_of_one(lab, mask, grow(covered, 2)) for mask in masks if mask.any()]
    polished = any(
        image.contrast > CLEAR and image.contrast > BETTER * image.beside for image in images
    )
    for image in images:
        # Ground that mirrors one thing mirrors the others, if less clearly.
        if polished and image.contrast > CLEAR / 2 and image.contrast > ALSO * image.beside:
            out |= image.where
    return out & ~covered


@dataclass(frozen=True, eq=False, slots=True)
class _Mirrored:
    """Where a thing's mirror image would be (H, W), how much its outline is seen there, and how
    much the same outline is seen beside."""

    where: BoolArray
    contrast: float
    beside: float


def _of_one(lab: FloatImage, mask: BoolArray, covered: BoolArray) -> _Mirrored:
    x0, y0, x1, y1 = bounds(mask)
    wide, high = round((BESIDE[-1] + 0.1) * (x1 - x0)), round((1.1 + STEPS[-1]) * (y1 - y0))
    window = slice(y0, y1 + high + 3 * OFF), slice(max(0, x0 - wide), x1 + wide)
    found = _in_window(lab[window], mask[window], covered[window])
    where = np.zeros_like(mask)
    where[window] = found.where
    return _Mirrored(where, found.contrast, found.beside)


def _in_window(lab: FloatImage, mask: BoolArray, covered: BoolArray) -> _Mirrored:
    x0, y0, x1, y1 = bounds(mask)
    high = y1 - y0
    best = _Mirrored(np.zeros_like(mask), 0.0, 0.0)
    low = y1 + max(2 * OFF, round(NEAREST * high))
    # What stands on another thing is mirrored by none of the ground that is seen below it.
    if mask.shape[0] - low < SEEN * high or covered[low - 1, x0:x1].mean() > STANDS:
        return best
    for step in STEPS:
        image = _upside_down(mask, y1 + round(step * high))
        own = _contrast(lab, image, covered, low)
        if own < CLEAR / 2:
            continue
        beside = max(
            _contrast(lab, _shifted(image, round(share * (x1 - x0))), covered, low)
            for share in BESIDE
        )
        if own - BETTER * beside > best.contrast - BETTER * best.beside or not best.contrast:
            best = _Mirrored(grow(image, OFF + 2), own, beside)
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


def _contrast(lab: FloatImage, shape: BoolArray, covered: BoolArray, low: int) -> float:
    """How much the two sides of an outline differ below a row, the same way all along it."""
    solid = shape.astype(np.uint8)
    inner = solid - cv2.erode(solid, np.ones((2 * OFF + 1,) * 2, np.uint8))
    outer = cv2.dilate(solid, np.ones((2 * OFF + 1,) * 2, np.uint8)) - solid
    sides = []
    for band in (inner, outer):
        band = (band > 0) & ~covered
        band[:low] = False
        if np.count_nonzero(band) < 40:
            return 0.0
        sides.append(band)
    rows = [np.nonzero(side.any(1))[0] for side in sides]
    both = np.intersect1d(rows[0], rows[1])
    steps = [lab[row][sides[0][row]].mean(0) - lab[row][sides[1][row]].mean(0) for row in both]
    return float(np.linalg.norm(np.median(steps, axis=0))) if len(steps) > 8 else 0.0
