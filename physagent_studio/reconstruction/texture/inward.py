"""The picture that hidden sides show: a thing's own, without its rim and what is there once."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.reconstruction.photo.regions import bounds, grow, shrink
from physagent_studio.records.case import Image
from physagent_studio.rendering.lit import bilinear


@dataclass(frozen=True, slots=True)
class FeatureSettings:
    """What on a thing is there once, on its front. Ratios are over its smaller extent."""

    around_ratio: float = 0.3  # 0.1..0.6: the width of what a spot is held against
    min_levels: float = 24.0  # 8..60: by which a spot is of another colour
    stray_factor: float = 3.0  # 1..8: likewise, over how its colours stray
    min_share: float = 0.0004  # 0..0.01: of the thing; smaller spots are noise
    max_share: float = 0.05  # 0.005..0.1: larger ones are parts
    max_whole_share: float = 0.06  # 0.01..0.2: of all of them; more are a pattern
    rim_ratio: float = 0.015  # 0..0.05: a spot's soft rim
    side_ratio: float = 0.08  # 0.02..0.2: from the outline, what is drawn out on a side
    calm_ratio: float = 0.04  # 0.01..0.1: over which it is made even


FEATURES = FeatureSettings()


def led_inward(picture: Image, own: BoolArray, ring: float) -> Image:
    """The picture (h, w, 3) of a thing that is `own` (h, w), its outer ring and what lies beyond
    replaced by what lies as far inside of that. ring: its width, as a share of the thing's smaller
    extent."""
    y, x = np.indices(own.shape)
    pixels = np.stack([x.ravel(), y.ravel()], 1).astype(np.float64) + 0.5
    led = bilinear(picture, _folded(pixels, own, ring) - 0.5).reshape(picture.shape)
    # Where it is folded from two sides, no edge.
    soft = cv2.GaussianBlur(led, (0, 0), 1.0)
    moved = np.abs(led - picture).max(-1, keepdims=True) > 0
    return np.asarray(np.where(moved, soft, led) + 0.5, np.uint8)


def without_features(picture: Image, own: BoolArray) -> Image:
    """The picture (h, w, 3) of a thing that is `own` (h, w) without the few small spots of other
    colours on it: eyes, a beak, a button are there once. Many are a pattern, and stay."""
    x0, y0, x1, y1 = bounds(own)
    size = min(x1 - x0, y1 - y0)
    usual = cv2.medianBlur(picture, 2 * max(1, round(FEATURES.around_ratio * size / 2)) + 1)
    off = np.abs(cv2.GaussianBlur(picture, (0, 0), 1.0).astype(float) - usual).mean(-1)
    least = max(FEATURES.min_levels, FEATURES.stray_factor * float(np.median(off[own])))
    _, labels, stats, _ = cv2.connectedComponentsWithStats((own & (off > least)).astype(np.uint8))
    share = stats[:, cv2.CC_STAT_AREA] / np.count_nonzero(own)
    small = (share < FEATURES.max_share) & (share > FEATURES.min_share)
    small[0] = False
    # What reaches the outline is a part.
    small[labels[own & ~shrink(own, 2)]] = False
    if not 0 < share[small].sum() < FEATURES.max_whole_share:
        return picture
    hole = grow(small[labels], max(2, round(FEATURES.rim_ratio * size)))
    filled = cv2.inpaint(picture, hole.astype(np.uint8), 3, cv2.INPAINT_TELEA)
    return np.asarray(filled, np.uint8)


def calmed(picture: Image, own: BoolArray) -> Image:
    """The picture (h, w, 3) of a thing that is `own` (h, w), even along its outline, where a few
    pixels are drawn out over all of a side."""
    x0, y0, x1, y1 = bounds(own)
    size = min(x1 - x0, y1 - y0)
    even = cv2.GaussianBlur(picture, (0, 0), max(0.5, FEATURES.calm_ratio * size))
    away = cv2.distanceTransform(own.astype(np.uint8), cv2.DIST_L2, 5)[..., None]
    share = np.clip(1 - away / max(FEATURES.side_ratio * size, 1.0), 0, 1)
    return np.asarray(picture + share * (even.astype(float) - picture) + 0.5, np.uint8)


def _folded(pixels: FloatArray, mask: BoolArray, ring: float) -> FloatArray:
    """Pixels (N, 2) of a mask's outer ring reflected at the ring's inner border.

    ring: its width, as a share of the mask's smaller extent.
    """
    x0, y0, x1, y1 = bounds(mask)
    core = _core(mask, max(2, round(ring * min(x1 - x0, y1 - y0))))
    if not core.any() or not len(pixels):
        return pixels
    near = nearest(core)
    x = np.clip(pixels[:, 0].astype(int), 0, mask.shape[1] - 1)
    y = np.clip(pixels[:, 1].astype(int), 0, mask.shape[0] - 1)
    border = near[y, x][:, ::-1] + 0.5
    outside = ~core[y, x]
    folded = 2 * border - pixels
    # Where the outline is narrow the reflection leaves it again: its middle will do.
    column = np.clip(folded[:, 0].astype(int), 0, mask.shape[1] - 1)
    row = np.clip(folded[:, 1].astype(int), 0, mask.shape[0] - 1)
    folded = np.where(core[row, column][:, None], folded, border)
    return np.where(outside[:, None], folded, pixels)


def _core(mask: BoolArray, ring: int) -> BoolArray:
    """The mask without its outer ring, pixels; of what is narrower than that, its middle."""
    core, reach = shrink(mask, ring), ring + 1 + ring // 2
    while ring > 0:
        # What lies farther from the core than the ring is wide belongs to something narrow.
        narrow = mask & ~grow(core, reach)
        ring //= 2
        core = core | (shrink(mask, ring) & narrow)
    return core


def nearest(core: BoolArray) -> NDArray[np.int64]:
    """(H, W, 2) row and column of the nearest pixel of the core."""
    _, labels = cv2.distanceTransformWithLabels(
        (~core).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    labels = labels.astype(np.int64)
    nearest = np.zeros((int(labels.max()) + 1, 2), np.int64)
    nearest[labels[core]] = np.argwhere(core)
    return nearest[labels]
