"""Ground in a mask: what lies between wheels, in the shade or in the gloss at a thing's foot.

A graph cut takes the upper part of the mask for the thing, what lies beside its lower part for the
ground, and settles between them. What it takes off is only taken off where its colours are those
of the ground and none of the thing's: panels, cuffs and poles in a colour of their own stay.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.reconstruction.masks.grabcut import cut, likelihood_ratio
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    bounds,
    grow,
    resized,
    shrink,
)
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class GroundSettings:
    """Where ground may be in a mask, and what it looks like."""

    low_share: float = 0.4  # 0.1..0.7: of a mask's height, at its foot, in which ground may be
    around_ratio: float = 0.25  # 0.1..1: over the mask's longer side, around it: ground to look at
    area_shares: tuple[float, float] = (0.004, 0.12)  # 0..0.3: of the mask that ground covers
    min_ground_log: float = 1.4  # 0.5..4: ratio, from which a colour is rather the ground's
    # 0.05..0.8: of what is taken off, in such colours: shade is of colours that both have
    min_ground_share: float = 0.2
    min_told_px: int = 30  # 10..300: of ground, from which its colours are told
    blur_ratio: float = 1 / 250  # 0..0.02: over the mask's longer side: sand has no edges
    # 200..2000: the longer side of what is looked at: blurred so much, more shows nothing more
    max_side_px: int = 500


GROUND = GroundSettings()


def without_ground(photo: Image, mask: BoolArray, others: BoolArray) -> BoolArray:
    """The mask (H, W) of what stands without the ground at its foot.

    others: (H, W) masks of other things, which say nothing about the ground.
    """
    if not mask.any():
        return mask
    x0, y0, x1, y1 = bounds(mask)
    side = max(x1 - x0, y1 - y0)
    pad = max(6, round(GROUND.around_ratio * side))
    window = slice(max(0, y0 - pad), y1 + pad), slice(max(0, x0 - pad), x1 + pad)
    own = mask[window]
    low = np.zeros_like(own)
    low[y1 - window[0].start - round(GROUND.low_share * (y1 - y0)) :] = True
    ground = low & ~own & ~others[window]
    upper = shrink(own, 2) & ~low
    if (
        np.count_nonzero(ground) < GROUND.min_told_px
        or np.count_nonzero(upper) < GROUND.min_told_px
    ):
        return mask
    calm = np.asarray(
        cv2.GaussianBlur(photo[window], (0, 0), max(0.6, GROUND.blur_ratio * side)), np.uint8
    )
    gone = _cut_off(calm, own, low, ground, min(1.0, GROUND.max_side_px / max(own.shape)))
    share = np.count_nonzero(gone) / np.count_nonzero(own)
    if not GROUND.area_shares[0] < share < GROUND.area_shares[1] or not _of_the_ground(
        calm, gone, upper, ground
    ):
        return mask
    out = mask.copy()
    out[window] = own & ~gone
    return out


def _cut_off(
    calm: Image, own: BoolArray, low: BoolArray, ground: BoolArray, scale: float
) -> BoolArray:
    """(h, w) the parts of the mask at its outline that a graph cut gives to the ground.

    scale: of the picture on which it is sought, up to 1.
    """
    if scale < 1:
        how = cv2.INTER_AREA
        small = np.asarray(cv2.resize(calm, None, fx=scale, fy=scale, interpolation=how), np.uint8)
        size = small.shape[1], small.shape[0]
        mine, lower, beside = (resized(part, size) for part in (own, low, ground))
        found = _cut_off(small, mine, lower, beside, 1.0)
        gone = resized(found, (own.shape[1], own.shape[0]))
        # No rim of it stays at the outline.
        return own & grow(gone, math.ceil(1 / scale))
    trimap = np.full(own.shape, cv2.GC_BGD, np.uint8)
    trimap[own] = cv2.GC_FGD
    trimap[own & low] = cv2.GC_PR_FGD
    # What is neither thing nor ground is painted over with the ground's own pixels.
    picture = calm.copy()
    neither = np.argwhere(~own & ~ground)
    source = np.argwhere(ground)
    drawn = source[np.random.default_rng(0).integers(len(source), size=len(neither))]
    picture[tuple(neither.T)] = calm[tuple(drawn.T)]
    kept = cut(picture, trimap, rounds=4)
    if kept is None:
        return np.zeros_like(own)
    gone = (own & ~kept).astype(np.uint8)
    gone = cv2.morphologyEx(gone, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
    _, labels = cv2.connectedComponents(gone.astype(np.uint8))
    return gone & np.isin(labels, np.unique(labels[gone & grow(~own, 2)]))


def _of_the_ground(calm: Image, gone: BoolArray, upper: BoolArray, ground: BoolArray) -> bool:
    lab = cv2.cvtColor(calm, cv2.COLOR_RGB2LAB).astype(np.float32)
    ratio = likelihood_ratio(lab, upper, ground)
    return float((ratio[gone] < -GROUND.min_ground_log).mean()) > GROUND.min_ground_share
