"""Masks to choose from where all methods agree: with the shadow or mirror image, wider, tighter."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.draft_score import Draft
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    bounds,
    grow,
    holding,
    shrink,
    smooth,
)
from physagent_studio.reconstruction.photo.statistics import lengths

VARIANT = "variant"
"""Family of drafts whose outline is meant to stay beside the picture's edges."""


@dataclass(frozen=True, slots=True)
class VariantSettings:
    """What else a mask may have been meant to be."""

    min_darker_levels: float = 14.0  # 4..40: lightness of shade below that of the ground around
    max_tint_lab: float = 12.0  # 3..30: from the ground's, of what is its shade and no thing
    rim_ratio: float = 0.05  # 0.01..0.2: of its size, by which a mask is made wider or tighter


VARIANTS = VariantSettings()


def variants(lab: NDArray[np.float32], leader: Draft) -> Iterator[Draft]:
    """Other readings of a mask, the likeliest first; lab (H, W, 3), OpenCV's 0 … 255."""
    mask = leader.mask
    area = int(np.count_nonzero(mask))
    shaded = shadowed(lab, leader)
    if shaded is not None:
        yield shaded
    mirrored = reflection_of(lab, mask)
    if np.count_nonzero(mirrored) > 0.1 * area:
        yield Draft(mask | mirrored, "with reflection", VARIANT)
    rim = max(2, round(VARIANTS.rim_ratio * float(np.sqrt(area))))
    yield Draft(shrink(mask, rim), "tighter", VARIANT)
    yield Draft(grow(mask, rim), "wider", VARIANT)


def shadowed(lab: NDArray[np.float32], leader: Draft) -> Draft | None:
    """A mask with its shadow; None where it casts none to speak of."""
    shade = shadow_of(lab, leader.mask)
    if np.count_nonzero(shade) <= 0.05 * np.count_nonzero(leader.mask):
        return None
    return Draft(leader.mask | shade, "with shadow", VARIANT)


def shadow_of(lab: NDArray[np.float32], mask: BoolArray) -> BoolArray:
    """What touches the mask and is darker than the ground around, in the ground's own tint."""
    x0, y0, x1, y1 = bounds(mask)
    reach = max(4, (x1 - x0 + y1 - y0) // 4)
    near = grow(mask, reach) & ~mask
    near[: (y0 + y1) // 2] = False
    if np.count_nonzero(near) < 20:
        return np.zeros_like(mask)
    ground = np.percentile(lab[near], 70, axis=0)
    tint = lengths(lab[..., 1:] - ground[1:])
    dark = (
        near
        & (lab[..., 0] < ground[0] - VARIANTS.min_darker_levels)
        & (tint < VARIANTS.max_tint_lab)
    )
    return _touching(smooth(dark), mask)


def reflection_of(lab: NDArray[np.float32], mask: BoolArray) -> BoolArray:
    """What lies below the mask like its mirror image and differs from the ground beside."""
    x0, _, x1, y1 = bounds(mask)
    depth = min(len(mask) - y1, y1, x1 - x0)
    if depth < 4:
        return np.zeros_like(mask)
    flipped = np.zeros_like(mask)
    flipped[y1 : y1 + depth] = mask[y1 - depth : y1][::-1]
    image = np.zeros_like(lab)
    image[y1 : y1 + depth] = lab[y1 - depth : y1][::-1]
    side = (grow(flipped, max(4, (x1 - x0) // 5)) & ~flipped & ~mask).astype(bool)
    side[:y1] = False
    if np.count_nonzero(side) < 20 or not flipped.any():
        return np.zeros_like(mask)
    ground = np.median(lab[side], axis=0)
    own = lengths(lab[..., 1:] - image[..., 1:])
    other = lengths(lab[..., 1:] - ground[1:])
    return _touching(smooth(flipped & (own < 0.6 * other) & (other > 6)), mask)


def _touching(part: BoolArray, mask: BoolArray) -> BoolArray:
    """The connected pieces of `part` that touch the mask."""
    rim = grow(mask, 2) & part
    if not rim.any():
        return np.zeros_like(mask)
    found = cv2.findNonZero(rim.astype(np.uint8)).reshape(-1, 2)
    some = found[:: max(1, len(found) // 40)]
    return holding(part, [(float(x), float(y)) for x, y in some], 0) & ~mask
