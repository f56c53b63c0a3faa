"""Seeded GrabCut: from a trimap, and inside a box."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from physagent_studio.reconstruction.photo.regions import BoolArray, Pixel


@dataclass(frozen=True, slots=True)
class CutSettings:
    """What a graph cut begins with, and how finely colours are told apart."""

    # number, 0..1000: of OpenCV's generator, from which its k-means draws: the same bits each time
    random_seed: int = 20
    bins_count: tuple[int, int, int] = (16, 24, 24)  # 4..64: of lightness and of the two hues


CUT = CutSettings()


def cut(image: NDArray[np.uint8], trimap: NDArray[np.uint8], rounds: int = 3) -> BoolArray | None:
    """GrabCut from a trimap (`cv2.GC_*`); None where a side has no pixel. Repeats to the bit."""
    sure_or_likely = _inside(trimap)
    if np.count_nonzero(sure_or_likely) < 10 or np.count_nonzero(~sure_or_likely) < 10:
        return None
    labels = trimap.copy()
    cv2.setRNGSeed(CUT.random_seed)  # its k-means draws from the global generator
    background, foreground = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(image, labels, (0, 0, 0, 0), background, foreground, rounds, cv2.GC_INIT_WITH_MASK)
    return _inside(labels)


def _inside(labels: NDArray[np.uint8]) -> BoolArray:
    return (labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)


def likelihood_ratio(lab: NDArray[np.float32], inside: BoolArray, outside: BoolArray) -> NDArray:
    """Log ratio of smoothed colour histograms of two regions, at every pixel; (H, W)."""
    scaled = np.clip((lab / 256 * CUT.bins_count).astype(int), 0, np.array(CUT.bins_count) - 1)
    index = (scaled[..., 0] * CUT.bins_count[1] + scaled[..., 1]) * CUT.bins_count[2] + scaled[
        ..., 2
    ]
    size = int(np.prod(CUT.bins_count))

    def histogram(region: BoolArray) -> NDArray:
        counts = (
            np.bincount(index[region], minlength=size).astype(np.float32).reshape(CUT.bins_count)
        )
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
