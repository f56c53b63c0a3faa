"""The background plate: the photo with the objects filled in from their surroundings.

An exemplar-based fill at reduced size finds for each missing pixel one to copy; what is copied,
at full size, is put together from its steps so that no seam shows. Lines that run behind the
objects are kept by the first guess.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.exemplar import STRAY, Copied, improve, put_together
from physagent_studio.reconstruction.harmonic import membrane, nearest_along, reduced
from physagent_studio.reconstruction.masks import BoolArray, bounds, grow
from physagent_studio.reconstruction.shade import shaded
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]
FloatImage = NDArray[np.float32]
ROUNDS = (8, 4)
"""Rounds of search and vote, from the coarsest size to the finest."""
COARSEST = 120
"""Longer side of the smallest picture, on which the first guess is made."""
CLOSE = 0.3
"""How far from a thing its shade is filled in with it, as a share of its size."""
SLIT = 5
"""Widest slit between a thing and its shade, pixels."""
SEED = 7
NO_LINES: FloatArray = np.zeros((0, 2, 2))


def background(photo: Image, masks: Sequence[BoolArray], lines: FloatArray = NO_LINES) -> Image:
    """The photo (H, W, 3) without the masked things and the shade close around their feet.

    lines: (N, 2, 2) pixels, edges that go on behind them.
    """
    hole = hole_of(masks, photo.shape[:2])
    if not hole.any() or hole.all():
        return fill(photo, hole, lines)
    shade = shaded(photo, masks, hole)
    # The darkest shade is a line right at the foot: none of it shall be left between the two.
    shade |= grow(shade, SLIT) & grow(hole, SLIT)
    filled = fill(photo, hole | shade, lines)
    share = _close(shade, masks, hole)[..., None]
    mixed = photo + share * (filled.astype(np.float32) - photo)
    return np.where(share > 0, np.round(mixed), photo).astype(np.uint8)


def _close(shade: BoolArray, masks: Sequence[BoolArray], hole: BoolArray) -> FloatImage:
    """(H, W) how much of the fill is seen: all of it in the hole, less of it away from there.

    What lies farther off is lifted when the picture is drawn, by the light that casts it.
    """
    sides = [max(np.ptp(np.nonzero(mask), axis=1)) for mask in masks if mask.any()]
    reach = CLOSE * float(np.median(sides))
    away = cv2.distanceTransform((~hole).astype(np.uint8), cv2.DIST_L2, 5)
    soft = cv2.GaussianBlur((shade | hole).astype(np.float32), (0, 0), 2.0)
    fading = np.clip(2 * (1 - away / max(reach, 1.0)), 0, 1)
    return np.where(hole, 1.0, fading * soft).astype(np.float32)


def fill(photo: Image, hole: BoolArray, lines: FloatArray = NO_LINES, side: int = 256) -> Image:
    """The photo (H, W, 3) with the hole (H, W) filled; the rest is untouched.

    lines: (N, 2, 2) pixels, edges that go on behind the hole.
    """
    if not hole.any():
        return photo.copy()
    if hole.all():
        return np.full_like(photo, 128)
    crop = _surroundings(hole)
    part, missing = photo[crop], hole[crop]
    factor = min(1.0, side / max(missing.shape))
    origin = np.array([crop[1].start, crop[0].start])
    full = _patched(part, missing, factor, lines - origin)
    full = _seamless(part.astype(np.float32), full, missing)
    out = photo.copy()
    filled = np.where(missing[..., None], full, part)
    out[crop] = np.clip(np.round(filled), 0, 255).astype(np.uint8)
    return out


def hole_of(masks: Sequence[BoolArray], shape: tuple[int, int]) -> BoolArray:
    """All objects together, widened over their soft outline and what they keep dark below."""
    union = np.zeros(shape, bool)
    for mask in masks:
        union |= mask
        if mask.any():
            union |= _contact(mask)
    return grow(union, max(3, round(0.008 * max(shape))))


def _contact(mask: BoolArray) -> BoolArray:
    """The dark line below a thing that stands: the light does not get in there."""
    x0, y0, x1, y1 = bounds(mask)
    low = mask.copy()
    low[: y1 - max(1, round(0.15 * (y1 - y0)))] = False
    return grow(low, max(1, round(0.03 * min(x1 - x0, y1 - y0))))


def _surroundings(hole: BoolArray) -> tuple[slice, slice]:
    """The part of the picture that the fill may copy from."""
    x0, y0, x1, y1 = bounds(hole)
    margin = max(60, round(0.9 * max(x1 - x0, y1 - y0)))
    rows = slice(max(0, y0 - margin), min(hole.shape[0], y1 + margin))
    return rows, slice(max(0, x0 - margin), min(hole.shape[1], x1 + margin))


def _patched(part: Image, missing: BoolArray, factor: float, lines: FloatArray) -> FloatImage:
    """The crop at full size with its hole filled patch by patch, coarse to fine."""
    rng = np.random.default_rng(SEED)
    size = (max(8, round(part.shape[1] * factor)), max(8, round(part.shape[0] * factor)))
    levels = [reduced(part.astype(np.float32), missing, size)]
    while max(levels[-1][1].shape) > 1.5 * COARSEST and levels[-1][1].any():
        image, hole = levels[-1]
        half = (max(8, hole.shape[1] // 2), max(8, hole.shape[0] // 2))
        levels.append(reduced(image, hole, half))
    image, hole = levels[-1]
    ratio = np.array(hole.shape[::-1]) / np.array(missing.shape[::-1])
    current = nearest_along(image, hole, lines * ratio)
    found: Copied | None = None
    for step, (image, hole) in enumerate(reversed(levels)):
        rows, columns = hole.shape
        if current.shape[:2] != hole.shape:
            current = cv2.resize(current, (columns, rows), interpolation=cv2.INTER_CUBIC)
        current = np.where(hole[..., None], current, image).astype(np.float32)
        rounds = ROUNDS[min(step, len(ROUNDS) - 1)]
        found = improve(current, hole, found.offsets if found else None, rng, rounds)
        current = found.picture if found else current
    large = (part.shape[1], part.shape[0])
    if found is None:
        return cv2.resize(current, large, interpolation=cv2.INTER_CUBIC).astype(np.float32)
    image, hole = levels[0]
    joined = put_together(image, hole, found.offsets)
    full = cv2.resize(joined, large, interpolation=cv2.INTER_CUBIC).astype(np.float32)
    return full + _detail(part, missing, image, found.offsets) if factor < 0.8 else full


def _detail(
    part: Image, missing: BoolArray, image: FloatImage, offsets: NDArray[np.int64]
) -> FloatImage:
    """What the full picture has at the places copied from and the reduced one lacks."""
    ratio = np.array(missing.shape) / np.array(offsets.shape[:2])
    large = (part.shape[1], part.shape[0])
    wide = cv2.resize(offsets.astype(np.float32), large, interpolation=cv2.INTER_NEAREST)
    moved = np.round(wide * ratio).astype(np.int64)
    rows, columns = np.indices(missing.shape)
    y = np.clip(rows + moved[..., 0], 0, missing.shape[0] - 1)
    x = np.clip(columns + moved[..., 1], 0, missing.shape[1] - 1)
    usable = missing & ~grow(missing, 1)[y, x]
    soft = cv2.resize(image, large, interpolation=cv2.INTER_CUBIC)
    fine = part.astype(np.float32) - soft
    return np.where(usable[..., None], fine[y, x], 0).astype(np.float32)


def _seamless(part: FloatImage, filled: FloatImage, hole: BoolArray) -> FloatImage:
    """The fill shifted smoothly in colour, so that it meets the photo at the rim.

    Only where the two nearly agree: elsewhere something else begins there.
    """
    rim = grow(hole, 3) & ~hole
    error = part - filled
    near = rim & (np.abs(error).max(-1) < STRAY)
    error = np.where(near[..., None], error, 0).astype(np.float32)
    spread = membrane(cv2.GaussianBlur(error, (0, 0), 1.0).astype(np.float32), hole)
    return filled + spread
