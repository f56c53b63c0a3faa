"""Seeded GrabCut: from a trimap, and inside a box."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from physagent_studio.reconstruction.photo.regions import BoolArray, Pixel

SEED = 20
_BINS = (16, 24, 24)


def cut(image: NDArray[np.uint8], trimap: NDArray[np.uint8], rounds: int = 3) -> BoolArray | None:
    """GrabCut from a trimap (`cv2.GC_*`); None where a side has no pixel. Repeats to the bit."""
    sure_or_likely = _inside(trimap)
    if np.count_nonzero(sure_or_likely) < 10 or np.count_nonzero(~sure_or_likely) < 10:
        return None
    labels = trimap.copy()
    cv2.setRNGSeed(SEED)  # its k-means draws from the global generator
    background, foreground = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(image, labels, (0, 0, 0, 0), background, foreground, rounds, cv2.GC_INIT_WITH_MASK)
    return _inside(labels)


def _inside(labels: NDArray[np.uint8]) -> BoolArray:
    return (labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)


def likelihood_ratio(lab: NDArray[np.float32], inside: BoolArray, outside: BoolArray) -> NDArray:
    """Log ratio of smoothed colour histograms of two regions, at every pixel; (H, W)."""
    scaled = np.clip((lab / 256 * _BINS).astype(int), 0, np.array(_BINS) - 1)
    index = (scaled[..., 0] * _BINS[1] + scaled[..., 1]) * _BINS[2] + scaled[..., 2]
    size = int(np.prod(_BINS))

    def histogram(region: BoolArray) -> NDArray:
        counts = np.bincount(index[region], minlength=size).astype(np.float32).reshape(_BINS)
        smoothed = gaussian_filter(counts, 1.2)
        return smoothed / (smoothed.sum() + 1e-9)

    ratio = np.log(histogram(inside) + 1e-6) - np.log(histogram(outside) + 1e-6)
    return ratio.reshape(-1)[index]


def in_box(
    image: NDArray[np.uint8],
    box: tuple[float, float, float, float],
    inside: Sequence[Pixel],
    outside: Sequence[Pixel],
    core: BoolArray | None = None,
) -> BoolArray | None:
    """GrabCut inside a person's box; `core` (H, W) may say what is likely inside."""
    rows, columns = image.shape[:2]
    x0, y0 = max(1, int(box[0])), max(1, int(box[1]))
    x1, y1 = min(columns - 2, int(box[2])), min(rows - 2, int(box[3]))
    trimap = np.full((rows, columns), cv2.GC_BGD, np.uint8)
    trimap[y0 : y1 + 1, x0 : x1 + 1] = cv2.GC_PR_FGD
    if core is not None:
        trimap[(trimap == cv2.GC_PR_FGD) & ~core] = cv2.GC_PR_BGD
    for x, y in inside:
        cv2.circle(trimap, (int(x), int(y)), 4, cv2.GC_FGD, -1)
    for x, y in outside:
        cv2.circle(trimap, (int(x), int(y)), 4, cv2.GC_BGD, -1)
    margin = int(max(12, 0.4 * max(x1 - x0, y1 - y0)))
    crop = (
        slice(max(0, y0 - margin), min(rows, y1 + margin)),
        slice(max(0, x0 - margin), min(columns, x1 + margin)),
    )
    part = cut(np.ascontiguousarray(image[crop]), np.ascontiguousarray(trimap[crop]), 5)
    if part is None:
        return None
    mask = np.zeros((rows, columns), bool)
    mask[crop] = part
    return mask
