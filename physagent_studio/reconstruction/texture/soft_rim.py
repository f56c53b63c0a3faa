"""How deep the surroundings shine into a thing's outline in a photo: blur, glare, compression."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.reconstruction.photo.regions import grow
from physagent_studio.reconstruction.texture.inward import nearest
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class SoftRimSettings:
    """Where a rim is held against what lies inside of it and outside."""

    most_px: int = 6  # 1..8: of a rim
    inner_px: int = 8  # 4..12: from the outline, where a thing shows its own colours
    outer_px: int = 3  # 2..6: from the outline, where the surroundings show theirs
    min_step_levels: float = 30.0  # 10..80: between both, for a mixture to be told
    min_pixels: int = 30  # count, 10..200: of a ring, below which nothing is told
    clean_share: float = 0.05  # 0.02..0.3: of the surroundings, up to which a ring is the thing's


SOFT_RIM = SoftRimSettings()


def soft_rim(photo: Image, mask: BoolArray) -> int:
    """Pixels from the outline of a thing (H, W) in which the photo (H, W, 3) mixes it with what is
    around it; 1 at least.

    The share of the surroundings at each distance is the median of where a pixel's colour lies
    between that of the nearest pixel well inside and that of the nearest one well outside.
    """
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)
    inside = (depth > SOFT_RIM.inner_px) & (depth <= SOFT_RIM.inner_px + 2)
    outside = grow(mask, SOFT_RIM.outer_px + 1) & ~grow(mask, SOFT_RIM.outer_px - 1)
    if min(np.count_nonzero(inside), np.count_nonzero(outside)) < SOFT_RIM.min_pixels:
        return 1
    own, around = _colours(photo, inside), _colours(photo, outside)
    step = around - own
    length = (step**2).sum(-1)
    told = length > SOFT_RIM.min_step_levels**2
    share = ((photo - own) * step).sum(-1) / np.maximum(length, 1.0)
    for rim in range(1, SOFT_RIM.most_px):
        ring = told & (depth > rim) & (depth <= rim + 1)
        clean = np.count_nonzero(ring) < SOFT_RIM.min_pixels
        if clean or float(np.median(share[ring])) < SOFT_RIM.clean_share:
            return rim
    return SOFT_RIM.most_px


def _colours(photo: Image, region: BoolArray) -> FloatArray:
    """(H, W, 3) the colour of the nearest pixel of a region."""
    place = nearest(region)
    return photo[place[..., 0], place[..., 1]].astype(np.float64)
