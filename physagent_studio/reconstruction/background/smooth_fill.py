"""A smooth fill with the photo's grain: what bare walls and table tops are filled with.

Colours run on from the rim of the hole and meet at the lines that are known to go through it, as
in pictures that are drawn by their edges (Orzan et al. 2008). Nothing is copied, so nothing can
be torn; texture coarser than grain is lost.
"""

from __future__ import annotations

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray, FloatImage
from physagent_studio.reconstruction.background.harmonic_fill import from_steps, nearest_along
from physagent_studio.reconstruction.background.poisson_blend import View
from physagent_studio.reconstruction.background.structure import Structure


def smooth_fill(
    part: FloatImage, missing: BoolArray, barred: BoolArray, structure: Structure
) -> FloatImage:
    """The picture (H, W, 3) with everything barred (H, W) filled smoothly.

    missing: (H, W) the hole. structure: over which no colour runs.
    """
    longer_px = 220  # 100..400: side of the picture in which colours run on
    view = View.of(part, missing, barred, longer_px)
    own = structure.scaled(view.ratio)
    rough = cv2.resize(_grain(part, barred), view.missing.shape[::-1])
    known = np.dstack([view.image, rough]).astype(np.float32)
    start = nearest_along(known, view.barred, own)
    right, below = own.crossed(view.missing.shape)
    # 0.05..1: up and down against along a row: floors and walls run across pictures
    upwards_ratio = 0.15
    weights = (np.where(right, 1e-6, 1.0), np.where(below, 1e-6, upwards_ratio))
    anchor_weight = 1e-4  # weight, 1e-5..1e-2: of the nearest colour: what no rim reaches gets it
    filled = from_steps(start[..., :3].copy(), view.barred, None, weights, anchor_weight)
    colour = _enlarged(
        np.dstack([filled, start[..., 3]]), barred, structure.clear(missing), view.ratio
    )
    random_seed = 11  # number, 0..1000: of the generator of grain: the same bits each time
    noise = cv2.GaussianBlur(
        np.random.default_rng(random_seed).normal(0, 1, barred.shape), (0, 0), 0.6
    ).astype(np.float32)
    noise *= colour[..., 3] / noise.std()
    return np.where(barred[..., None], colour[..., :3] + noise[..., None], part).astype(np.float32)


def _enlarged(
    small: FloatImage, barred: BoolArray, structure: Structure, ratio: FloatArray
) -> FloatImage:
    """The fill (h, w, C) at full size, every pixel from those on its own side of all lines."""
    size = barred.shape[::-1]
    out = np.asarray(cv2.resize(small, size, interpolation=cv2.INTER_LINEAR), np.float32)
    if structure.empty:
        return out
    coarse = structure.scaled(ratio).sides(small.shape[:2])
    fine = structure.sides(barred.shape)
    for side in np.unique(fine[barred]):
        own = (coarse == side).astype(np.float32)
        share = cv2.resize(own, size, interpolation=cv2.INTER_LINEAR)
        here = barred & (fine == side) & (share > 1e-3)
        total = cv2.resize(small * own[..., None], size, interpolation=cv2.INTER_LINEAR)
        out[here] = total[here] / share[here][:, None]
    return out


def _grain(part: FloatImage, barred: BoolArray) -> FloatImage:
    """(H, W) standard deviation of the finest detail around each pixel, grey levels."""
    known = (~cv2.dilate(barred.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)).astype(
        np.float32
    )
    grey = part.mean(-1)
    grain_px = 1.2  # 0.6..3: what is finer than this spread is grain
    fine = (grey - cv2.GaussianBlur(grey, (0, 0), grain_px)) * known
    around_px = 15  # 7..31: side of the square over which grain is measured
    size = (around_px, around_px)
    count = cv2.blur(known, size)
    # Outlines of things are no grain: many pixels have to be like that.
    level = cv2.blur(np.minimum(np.abs(fine), 6.0), size) / np.maximum(count, 1e-3)
    return np.asarray(1.25 * level, np.float32)
