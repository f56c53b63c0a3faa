"""Sand that has run is seen as one heap: no spikes, no gaps, one tone with grain."""

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering import heaps
from physagent_studio.rendering.raster import Hits, Lens

LENS = Lens(120, 90, 100.0, 60.0, 45.0)
HEAP, OTHER = 0, 1


def hits_of(owner: NDArray[np.int8], depth: NDArray[np.float64]) -> Hits:
    """Hits of an image of owners, −1 for none; the face of each is its owner."""
    pixel = np.flatnonzero(owner.ravel() >= 0)
    weights = np.full((len(pixel), 3), 1 / 3)
    return Hits(pixel, owner.ravel()[pixel].astype(np.int32), weights, depth.ravel()[pixel])


def scene(*, other: bool = False) -> tuple[Hits, NDArray[np.bool_]]:
    """A disc of sand with spikes and gaps on its right; its right half is loose."""
    image = np.full((90, 120), -1, np.int8)
    cv2.circle(image.view(np.uint8), (60, 45), 30, 0, -1)
    random = np.random.default_rng(1)
    for angle in random.uniform(-1.2, 1.2, 12):
        tip = np.array([60, 45]) + 36 * np.array([np.cos(angle), np.sin(angle)])
        cv2.line(image.view(np.uint8), (60, 45), [int(v) for v in tip], 0, 1)
    for x, y in random.integers((66, 30), (82, 60), (10, 2)):
        image[y : y + 2, x : x + 2] = -1
    depth = np.full(image.shape, 2.0)
    if other:
        image[44:47, 70:73], depth[44:47, 70:73] = OTHER, 1.0
    hits = hits_of(image, depth)
    return hits, (hits.pixel % 120 > 62) & (hits.face == HEAP)


def shown(hits: Hits) -> NDArray[np.uint8]:
    image = np.zeros(90 * 120, np.uint8)
    image[hits.pixel[hits.face == HEAP]] = 1
    return image.reshape(90, 120)


def test_spikes_go_and_gaps_close_where_it_has_run() -> None:
    hits, loose = scene()
    disc = np.zeros((90, 120), np.uint8)
    cv2.circle(disc, (60, 45), 30, 1, -1)
    before = (shown(hits) != disc).sum()
    after = heaps.closed(hits, hits.face == HEAP, loose, LENS)
    assert (shown(after) != disc).sum() < before / 4
    assert (np.diff(after.pixel) > 0).all()
    np.testing.assert_array_equal(shown(after)[:, :50], shown(hits)[:, :50])


def test_what_stands_before_the_heap_stays() -> None:
    hits, loose = scene(other=True)
    after = heaps.closed(hits, hits.face == HEAP, loose, LENS)
    np.testing.assert_array_equal(after.pixel[after.face == OTHER], hits.pixel[hits.face == OTHER])


def test_what_has_run_loses_its_picture_and_keeps_its_tone() -> None:
    hits, loose = scene()
    mine = hits.face == HEAP
    stripes = np.where((hits.pixel % 120) // 2 % 2, 200.0, 100.0).astype(np.float32)
    colors = np.repeat(stripes[:, None], 3, 1)
    heap = heaps.heap_of(hits, mine, loose, LENS)
    sand = heaps.as_sand(heap, hits, colors, np.zeros(len(colors), np.float32), LENS)
    left, right = hits.pixel % 120 < 50, hits.pixel % 120 > 70
    np.testing.assert_array_equal(sand[left], colors[left])
    assert sand[right].std() < 0.2 * colors[right].std()
    assert abs(sand[right].mean() - 150) < 5
