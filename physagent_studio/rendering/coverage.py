"""How much of each pixel an object covers, exactly, from the outline of its projection.

The faces that are seen, as one oriented patch, cancel along every inner edge; what is left is
the outline. Its signed area, accumulated pixel by pixel and summed along each row, is the area
that the object covers: the way of font rasterisers, and far cheaper than more samples.
"""

from __future__ import annotations

import itertools
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
    behind = np.bincount(batch.owner[points[:, 2] < NEAR], minlength=count) > 0
    pixels = lens.project(np.maximum(points, (-np.inf, -np.inf, NEAR)))
    weight = _outline_weight(batch, pixels, torn)
    outline = np.flatnonzero(weight)
    owner = batch.edges.owner[outline]
    if behind.any():
        outline, owner = outline[~behind[owner]], owner[~behind[owner]]
    ends = pixels[batch.edges.ends[outline]]
    pieces = _Pieces.of(ends, weight[outline].astype(float), owner, lens)
    start = np.searchsorted(pieces.owner, np.arange(count + 1))
    return [
        _partial(pieces.part(slice(one, other)), lens) if other > one else nothing
        for one, other in itertools.pairwise(start)
    ]


@dataclass(frozen=True, eq=False, slots=True)
class _Pieces:
    """Outlines, cut where they pass from pixel to pixel.

    x, y: (P,) the pixel each piece lies in, `width` and beyond for what is to the right. rise: (P,)
    how far it goes down, signed. inner: (P,) how far into its pixel its middle lies, 0 … 1. owner:
    (P,) object, ascending.
    """

    x: NDArray[np.int64]
    y: NDArray[np.int64]
    rise: FloatArray
    inner: FloatArray
    owner: NDArray[np.int32]

    @classmethod
    def of(
        cls, ends: FloatArray, weight: FloatArray, owner: NDArray[np.int32], lens: Lens
    ) -> _Pieces:
        start, stop, of = _split(ends[:, 0], ends[:, 1], axis=1, size=lens.height)
        middle = (start[:, 1] + stop[:, 1]) / 2
        inside = np.flatnonzero((middle > 0) & (middle < lens.height))
        start, stop, of = start[inside], stop[inside], of[inside]
        start[:, 0] = np.clip(start[:, 0], 0, lens.width)
        stop[:, 0] = np.clip(stop[:, 0], 0, lens.width)
        start, stop, again = _split(start, stop, axis=0, size=lens.width)
        of = of[again]
        middle = (start + stop) / 2
        x = np.clip(np.floor(middle[:, 0]), 0, lens.width).astype(np.int64)
        y = np.clip(np.floor(middle[:, 1]), 0, lens.height - 1).astype(np.int64)
        rise = (stop[:, 1] - start[:, 1]) * weight[of]
        return cls(x, y, rise, np.clip(middle[:, 0] - x, 0, 1), owner[of])

    def part(self, rows: slice) -> _Pieces:
        """Some of them."""
        return _Pieces(
            self.x[rows], self.y[rows], self.rise[rows], self.inner[rows], self.owner[rows]
        )


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


def _partial(pieces: _Pieces, lens: Lens) -> Partial:
    left, right = int(pieces.x.min()), int(pieces.x.max()) + 1
    top, bottom = int(pieces.y.min()), int(pieces.y.max()) + 1
    width, height = right - left + 1, bottom - top
    cell = (pieces.y - top) * width + pieces.x - left
    before = pieces.rise * pieces.inner
    total = np.bincount(cell, pieces.rise - before, minlength=height * width)
    total += np.bincount(cell + 1, before, minlength=height * width)[: height * width]
    share = np.abs(np.cumsum(total.reshape(height, width), axis=1))
    y, x = np.nonzero((share > _CERTAIN) & (share < 1 - _CERTAIN))
    kept = x + left < lens.width
    y, x = y[kept], x[kept]
    return Partial((y + top) * lens.width + x + left, share[y, x].astype(np.float32))


def _split(
    start: FloatArray, stop: FloatArray, axis: int, size: int
) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """Cut segments where they cross whole numbers of one axis between 0 and `size`.

    What lies beyond either side stays in one piece. The third: which segment each is a piece of.
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
    t0, t1 = np.where(falling, 1 - t1, t0), np.where(falling, 1 - t0, t1)
    along = (stop - start)[segment]
    origin = start[segment]
    return origin + along * t0[:, None], origin + along * t1[:, None], segment
