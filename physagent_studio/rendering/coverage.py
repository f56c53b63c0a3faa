"""How much of each pixel an object covers, exactly, from the outline of its projection.

The faces that are seen, as one oriented patch, cancel along every inner edge; what is left is
the outline. Its signed area, accumulated pixel by pixel and summed along each row, is the area
that the object covers: the way of font rasterisers, and far cheaper than more samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.raster import NEAR, FloatArray, Lens

_CERTAIN = 1 / 512


@dataclass(frozen=True, eq=False, slots=True)
class Partial:
    """Pixels that an object covers in part: flat index (K,), share covered (K,) in 0 … 1."""

    pixel: NDArray[np.int64]
    share: NDArray[np.float32]


def partial_pixels(
    batch: Batch, points: FloatArray, lens: Lens, torn: NDArray[np.bool_] | None = None
) -> list[Partial]:
    """Partly covered pixels of each object, whether or not something stands before it.

    points: (V, 3) camera frame. Objects that reach behind the camera have none. torn: (F,) faces
    that are not drawn.
    """
    count = len(batch.first) - 1
    nothing = Partial(np.zeros(0, np.int64), np.zeros(0, np.float32))
    if not len(points):
        return [nothing] * count
    behind = np.zeros(count, bool)
    np.logical_or.at(behind, batch.owner, points[:, 2] < NEAR)
    pixels = lens.project(np.maximum(points, (-np.inf, -np.inf, NEAR)))
    weight = _outline_weight(batch, pixels, torn)
    outline = np.flatnonzero(weight)
    start = np.searchsorted(batch.edges.owner[outline], np.arange(count + 1))
    result = []
    for index in range(count):
        edge = outline[start[index] : start[index + 1]]
        if behind[index] or not len(edge):
            result.append(nothing)
            continue
        ends = pixels[batch.edges.ends[edge]]
        result.append(_partial(ends, weight[edge].astype(float), lens))
    return result


def _outline_weight(
    batch: Batch, pixels: FloatArray, torn: NDArray[np.bool_] | None
) -> NDArray[np.int8]:
    """(E,) how often the seen patch runs along each edge, as stored minus against."""
    x, y = pixels.T
    a, b, c = batch.faces.T
    area = (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a])
    # Rows grow downwards, so a face that looks at the camera runs clockwise: negative area.
    facing = np.where(area < 0, np.int8(1), np.where(batch.one_sided, np.int8(0), np.int8(-1)))
    if torn is not None:
        facing[torn] = 0
    edges = batch.edges
    total = np.zeros(len(edges.ends), np.int8)
    for slot in range(edges.face.shape[1]):
        total += edges.sign[:, slot] * facing[edges.face[:, slot]]
    return total


def _partial(ends: FloatArray, weight: FloatArray, lens: Lens) -> Partial:
    left = int(np.clip(np.floor(ends[..., 0].min()), 0, lens.width))
    right = int(np.clip(np.ceil(ends[..., 0].max()), 0, lens.width))
    top = int(np.clip(np.floor(ends[..., 1].min()), 0, lens.height))
    bottom = int(np.clip(np.ceil(ends[..., 1].max()), 0, lens.height))
    if left >= right or top >= bottom:
        return Partial(np.zeros(0, np.int64), np.zeros(0, np.float32))
    width = right - left
    sums = _accumulate(ends - (left, top), weight, width, bottom - top)
    share = np.clip(np.abs(sums[:, :width]), 0, 1)
    y, x = np.nonzero((share > _CERTAIN) & (share < 1 - _CERTAIN))
    return Partial((y + top) * lens.width + x + left, share[y, x].astype(np.float32))


def _accumulate(ends: FloatArray, weight: FloatArray, width: int, height: int) -> FloatArray:
    """(height, width + 2) signed covered area of each pixel."""
    start, stop, weight = _split(ends[:, 0], ends[:, 1], weight, axis=1, size=height)
    inside = (np.maximum(start[:, 1], stop[:, 1]) > 0) & (
        np.minimum(start[:, 1], stop[:, 1]) < height
    )
    start, stop, weight = start[inside], stop[inside], weight[inside]
    start[:, 0] = np.clip(start[:, 0], 0, width)
    stop[:, 0] = np.clip(stop[:, 0], 0, width)
    start, stop, weight = _split(start, stop, weight, axis=0, size=width)
    middle = (start + stop) / 2
    x = np.clip(np.floor(middle[:, 0]), 0, width).astype(np.int64)
    y = np.clip(np.floor(middle[:, 1]), 0, height - 1).astype(np.int64)
    rise = (stop[:, 1] - start[:, 1]) * weight
    inner = np.clip(middle[:, 0] - x, 0, 1)
    cell = y * (width + 2) + x
    total = np.bincount(cell, rise * (1 - inner), minlength=height * (width + 2))
    total += np.bincount(cell + 1, rise * inner, minlength=height * (width + 2))
    return np.cumsum(total.reshape(height, width + 2), axis=1, dtype=np.float64)


def _split(
    start: FloatArray, stop: FloatArray, weight: FloatArray, axis: int, size: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Cut segments where they cross whole numbers of one axis between 0 and `size`.

    What lies beyond either side stays in one piece.
    """
    begin, end = start[:, axis], stop[:, axis]
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    first = np.clip(np.floor(low), -1, size).astype(np.int64)
    last = np.clip(np.ceil(high) - 1, first, size).astype(np.int64)
    count = last - first + 1
    segment = np.repeat(np.arange(len(count)), count)
    cell = np.arange(len(segment)) - (np.cumsum(count) - count)[segment] + first[segment]
    lower = np.where(cell == first[segment], low[segment], cell)
    upper = np.where(cell == last[segment], high[segment], cell + 1)
    length = (high - low)[segment]
    safe = np.where(length > 0, length, 1)
    t0 = np.where(length > 0, (lower - low[segment]) / safe, 0)
    t1 = np.where(length > 0, (upper - low[segment]) / safe, 1)
    falling = (end < begin)[segment]
    t0, t1 = np.where(falling, 1 - t0, t0), np.where(falling, 1 - t1, t1)
    t0, t1 = np.where(falling, t1, t0), np.where(falling, t0, t1)
    along = (stop - start)[segment]
    origin = start[segment]
    return origin + along * t0[:, None], origin + along * t1[:, None], weight[segment]
