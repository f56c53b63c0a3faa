"""Seeded GrabCut at several scales: one candidate mask for each guess of the object's size.

A click says where an object is, not how large. Each scale takes a window around the clicks,
calls everything outside it background, and lets GrabCut decide inside; the window that fits
gives a mask that touches no side of it and agrees with its neighbours in scale.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from physagent_studio.reconstruction.photo.regions import BoolArray, Pixel
from physagent_studio.reconstruction.switches import at_work

Item = TypeVar("Item")
Made = TypeVar("Made")
SEED = 20
_BINS = (16, 24, 24)
SQUARE = (1.0, 1.0, 1.0)
OBLONG = ((1.3, 0.6, 0.6), (1.2, 1.0, 0.3), (0.55, 1.4, 0.6))
"""Windows as reach to both sides, up and down, in radii."""


@dataclass(frozen=True, eq=False, slots=True)
class Window:
    """A candidate mask with the window that it came from: (x0, y0, x1, y1), pixels."""

    mask: BoolArray
    box: tuple[int, int, int, int]


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


def side_by_side(
    work: Callable[[Item], Made],
    items: Sequence[Item],
    cost: Callable[[Item], float] | None = None,
) -> list[Made]:
    """What `work` makes of each item, in their order; two at a time.

    cost: how dear an item is; the dearest are begun first, so that none is waited for alone.
    Cuts run outside of Python, and each seeds the generator of its own thread.
    """
    order = range(len(items))
    if cost is not None:
        order = sorted(order, key=lambda k: -cost(items[k]))
    with ThreadPoolExecutor(2) as pool:
        made = {k: pool.submit(work, items[k]) for k in order}
        return [made[k].result() for k in range(len(items))]


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


def seeds(shape: tuple[int, int], points: Sequence[Pixel], radius: int, reach: float) -> BoolArray:
    """Discs at the clicks, and lines between clicks that are closer than `reach` pixels."""
    canvas = np.zeros(shape, np.uint8)
    for x, y in points:
        cv2.circle(canvas, (int(x), int(y)), radius, 1, -1)
    for (ax, ay), (bx, by) in pairwise(points):
        if np.hypot(bx - ax, by - ay) < reach:
            cv2.line(canvas, (int(ax), int(ay)), (int(bx), int(by)), 1, 2)
    return canvas.astype(bool)


def at_scales(
    image: NDArray[np.uint8],
    lab: NDArray[np.float32],
    inside: Sequence[Pixel],
    outside: Sequence[Pixel],
    scales: int = 6,
    *,
    filling: bool = True,
) -> list[Window]:
    """Candidates for windows of several sizes and proportions. Pixels are those of `image`.

    filling: whether the largest window, almost all of the picture, is one of them.

    Square windows start from the clicks' colours. Wide and tall ones start from everything
    inside, for things of many colours: what the surroundings do not explain is the object.
    """
    rows, columns = lab.shape[:2]
    spots = np.array(inside)
    low, high = spots.min(0), spots.max(0)
    guesses = [(share, SQUARE) for share in np.geomspace(0.07, 0.95, scales)]
    guesses = guesses if filling else guesses[:-1]
    if at_work("oblong windows"):
        guesses += [(share, window) for share in (0.18, 0.36) for window in OBLONG]

    def guess(one: tuple[float, tuple[float, float, float]]) -> Window | None:
        share, (reach_x, up, down) = one
        radius = share * max(rows, columns) / 2
        x0, y0 = np.maximum(np.round(low - radius * np.array([reach_x, up])).astype(int), 1)
        high_x, high_y = np.round(high + radius * np.array([reach_x, down])).astype(int)
        x1, y1 = min(int(high_x), columns - 1), min(int(high_y), rows - 1)
        if x1 - x0 < 6 or y1 - y0 < 6:
            return None
        box = (int(x0), int(y0), x1, y1)
        by_colour = (reach_x, up, down) == SQUARE
        mask = _in_window(image, lab, box, radius, inside, outside, by_colour)
        return Window(mask, box) if mask is not None and np.count_nonzero(mask) >= 30 else None

    def size(one: tuple[float, tuple[float, float, float]]) -> float:
        share, (reach_x, up, down) = one
        return share**2 * reach_x * (up + down)

    return [window for window in side_by_side(guess, guesses, size) if window is not None]


def _in_window(
    image: NDArray[np.uint8],
    lab: NDArray[np.float32],
    box: tuple[int, int, int, int],
    radius: float,
    inside: Sequence[Pixel],
    outside: Sequence[Pixel],
    by_colour: bool,
) -> BoolArray | None:
    rows, columns = lab.shape[:2]
    x0, y0, x1, y1 = box
    margin = int(max(6, radius * 0.5))
    window = np.zeros((rows, columns), bool)
    window[y0:y1, x0:x1] = True
    around = np.zeros_like(window)
    around[max(0, y0 - margin) : y1 + margin, max(0, x0 - margin) : x1 + margin] = True
    around &= ~window
    if np.count_nonzero(around) < 200:
        around = np.ones_like(window)
        around[6:-6, 6:-6] = False
    sure = seeds((rows, columns), inside, max(3, int(radius * 0.12)), 0.3 * max(rows, columns))
    trimap = np.full((rows, columns), cv2.GC_BGD, np.uint8)
    trimap[window] = cv2.GC_PR_BGD if by_colour else cv2.GC_PR_FGD
    if by_colour:
        ratio = likelihood_ratio(lab, sure, around)
        trimap[window & (ratio > 0)] = cv2.GC_PR_FGD
    trimap[sure] = cv2.GC_FGD
    for x, y in outside:
        cv2.circle(trimap, (int(x), int(y)), max(3, int(min(radius * 0.1, 6))), cv2.GC_BGD, -1)
    crop = (
        slice(max(0, y0 - margin), min(rows, y1 + margin)),
        slice(max(0, x0 - margin), min(columns, x1 + margin)),
    )
    part = cut(np.ascontiguousarray(image[crop]), np.ascontiguousarray(trimap[crop]), 2)
    if part is None:
        return None
    mask = np.zeros((rows, columns), bool)
    mask[crop] = part
    return mask


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
