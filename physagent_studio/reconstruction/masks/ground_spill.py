"""Ground in a mask: what lies between wheels, in the shade or in the gloss at a thing's foot.

A graph cut takes the upper part of the mask for the thing, what lies beside its lower part for the
ground, and settles between them. What it takes off is only taken off where its colours are those
of the ground and none of the thing's: panels, cuffs and poles in a colour of their own stay.
"""

from __future__ import annotations

import cv2
import numpy as np

from physagent_studio.reconstruction.masks.grabcut import cut, likelihood_ratio
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, shrink
from physagent_studio.records.case import Image

LOW = 0.4
"""Lowest share of a mask's height in which ground may be."""
AROUND = 0.25
"""How far around the mask ground is looked at, in its longer side."""
LEAST, LARGEST = 0.004, 0.12
"""Share of the mask that ground covers, at least and at most."""
SURELY, MOSTLY = 1.4, 0.2
"""Log ratio from which a colour is the ground's rather than the thing's, and the share of what is
taken off that has such colours: shade is of colours that both have."""
FEWEST = 30
"""Pixels of ground from which its colours are told."""
SOFT = 1 / 250
"""Blur of the picture, in the mask's longer side: sand and pebbles are no edges."""


def without_ground(photo: Image, mask: BoolArray, others: BoolArray) -> BoolArray:
    """The mask (H, W) of what stands without the ground at its foot.

    others: (H, W) masks of other things, which say nothing about the ground.
    """
    if not mask.any():
        return mask
    x0, y0, x1, y1 = bounds(mask)
    side = max(x1 - x0, y1 - y0)
    pad = max(6, round(AROUND * side))
    window = slice(max(0, y0 - pad), y1 + pad), slice(max(0, x0 - pad), x1 + pad)
    own = mask[window]
    low = np.zeros_like(own)
    low[y1 - window[0].start - round(LOW * (y1 - y0)) :] = True
    ground = low & ~own & ~others[window]
    upper = shrink(own, 2) & ~low
    if np.count_nonzero(ground) < FEWEST or np.count_nonzero(upper) < FEWEST:
        return mask
    calm = np.asarray(cv2.GaussianBlur(photo[window], (0, 0), max(0.6, SOFT * side)), np.uint8)
    gone = _cut_off(calm, own, low, ground)
    share = np.count_nonzero(gone) / np.count_nonzero(own)
    if not LEAST < share < LARGEST or not _of_the_ground(calm, gone, upper, ground):
        return mask
    out = mask.copy()
    out[window] = own & ~gone
    return out


def _cut_off(calm: Image, own: BoolArray, low: BoolArray, ground: BoolArray) -> BoolArray:
    """(h, w) the parts of the mask at its outline that a graph cut gives to the ground."""
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
    return float((ratio[gone] < -SURELY).mean()) > MOSTLY
