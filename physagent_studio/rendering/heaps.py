"""Heaps of grains as a camera sees them: one surface of sand, not the crumbs that make it up.

Where grains have run, the crumbs of their skin (`rendering.crumbs`) stand out as spikes, gape, and
carry bits of what the thing looked like. There, the outline is smoothed over the picture, gaps are
closed by what is seen beside them, and the colours are those of the surroundings with the fine
grain of the thing's own texture.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.raster import Hits, Lens

Image = NDArray[np.float32]

OUTLINE, TONE = 0.08, 0.03
"""Width of what is smoothed away of an outline, and spread of the mean of colours, both in parts of
the heap's size in the picture (the root of its area)."""


@dataclass(frozen=True, eq=False, slots=True)
class Heap:
    """Where a heap has run, in one frame. size: px, the root of its area. mine: (K,) which hits
    are its own. run: (K,) 0 … 1 how near each is to grains that have run."""

    size: float
    mine: NDArray[np.bool_]
    run: Image


def closed(hits: Hits, mine: NDArray[np.bool_], loose: NDArray[np.bool_], lens: Lens) -> Hits:
    """Hits with the heap's outline smoothed and its gaps closed, where crumbs are loose.

    mine, loose: (K,) hits of the heap, and those of its loose crumbs. A pixel that joins the heap
    takes the hit of the nearest pixel of it, unless something nearer is seen there.
    """
    heap, running = _image(hits, mine, lens), _image(hits, loose, lens)
    size = max(float(np.sqrt(mine.sum())), 1.0)
    width = 2 * int(OUTLINE * size / 2) + 1
    if width < 3:
        return hits
    ellipse = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
    near = cv2.dilate(running, ellipse) > 0
    smooth = cv2.GaussianBlur(heap.astype(np.float32), (0, 0), width / 2.5) > 0.5
    whole = cv2.morphologyEx(heap, cv2.MORPH_CLOSE, ellipse) > 0
    left = (near & (heap > 0) & ~(smooth & whole)).ravel()
    added = np.flatnonzero(near & (heap == 0) & smooth & whole)
    nearest = _nearest(heap)[added]
    row = np.full(heap.size, -1)
    row[hits.pixel] = np.arange(len(hits.pixel))
    source, before = row[nearest], row[added]
    front = (before < 0) | (hits.depth[before] > hits.depth[source])
    keep = ~left[hits.pixel]
    keep[before[front & (before >= 0)]] = False
    pixel = np.concatenate([hits.pixel[keep], added[front].astype(hits.pixel.dtype)])
    order = np.argsort(pixel, kind="stable")
    rows = np.concatenate([np.flatnonzero(keep), source[front]])[order]
    return Hits(pixel[order], hits.face[rows], hits.weights[rows], hits.depth[rows])


def heap_of(hits: Hits, mine: NDArray[np.bool_], loose: NDArray[np.bool_], lens: Lens) -> Heap:
    """The heap as these hits show it. mine, loose: as for `closed`."""
    size = max(float(np.sqrt(mine.sum())), 1.0)
    spread = cv2.GaussianBlur(_image(hits, loose, lens).astype(np.float32), (0, 0), TONE * size)
    run = np.clip(2 * spread.ravel()[hits.pixel], 0, 1).astype(np.float32)
    return Heap(size, mine, run)


def as_sand(heap: Heap, hits: Hits, colors: Image, grain: Image, lens: Lens) -> Image:
    """Colours (K, 3) with the heap as sand where it has run. grain: (K,) grey levels."""
    pixel = hits.pixel[heap.mine]
    shape = (lens.height, lens.width)
    painted, weight = np.zeros((*shape, 3), np.float32), np.zeros(shape, np.float32)
    painted.reshape(-1, 3)[pixel] = colors[heap.mine]
    weight.ravel()[pixel] = 1
    spread = TONE * heap.size
    tone = cv2.GaussianBlur(painted, (0, 0), spread)
    tone /= np.maximum(cv2.GaussianBlur(weight, (0, 0), spread), 1e-3)[:, :, None]
    sand = np.clip(tone.reshape(-1, 3)[pixel] + grain[heap.mine, None], 0, 255)
    run = heap.run[heap.mine, None]
    result = colors.copy()
    result[heap.mine] = colors[heap.mine] * (1 - run) + sand * run
    return result


def _image(hits: Hits, chosen: NDArray[np.bool_], lens: Lens) -> NDArray[np.uint8]:
    image = np.zeros((lens.height, lens.width), np.uint8)
    image.ravel()[hits.pixel[chosen]] = 1
    return image


def _nearest(heap: NDArray[np.uint8]) -> NDArray[np.int64]:
    """(H W,) the nearest pixel of the heap to each pixel."""
    _, label = cv2.distanceTransformWithLabels(
        (heap == 0).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    pixels = np.flatnonzero(heap)
    found = np.zeros(int(label.max()) + 1, np.int64)
    found[label.ravel()[pixels]] = pixels
    return found[label.ravel()]
