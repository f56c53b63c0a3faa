"""Smooth outlines: partly covered pixels mix an object with what lies behind it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.coverage import Partial
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.raster import FloatArray

PhotoShare = Callable[[NDArray[np.int64], int], NDArray[np.float32]]
"""Flat pixels (K,), object → share (K,) of the photo itself there, which needs no mixing."""

_AROUND = ((0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))


def blend_outlines(
    canvas: Picture,
    backdrop: Picture,
    ids: NDArray[np.int16],
    depth: NDArray[np.float32],
    barrier: FloatArray,
    partial: Sequence[Partial],
    photographed: PhotoShare,
) -> None:
    """Mix the outlines of objects into `canvas` (H, W, 3), in place.

    canvas: hard picture. backdrop: without objects. ids, depth: (H, W) of the hard picture.
    barrier: (H·W,) depth of static solids, inf for none. partial: covered share per object.
    photographed: see `PhotoShare`.
    """
    hard = canvas.copy()
    reach = [_mean_depth(ids, depth, i) for i in range(len(partial))]
    for index in sorted(range(len(partial)), key=lambda i: -reach[i]):
        if np.isfinite(reach[index]) and len(partial[index].pixel):
            _blend(canvas, hard, backdrop, ids, depth, barrier, partial[index], photographed, index)


def _mean_depth(ids: NDArray[np.int16], depth: NDArray[np.float32], index: int) -> float:
    mine = depth[ids == index]
    return float(mine.mean()) if len(mine) else np.inf


def _blend(
    canvas: Picture,
    hard: Picture,
    backdrop: Picture,
    ids: NDArray[np.int16],
    depth: NDArray[np.float32],
    barrier: FloatArray,
    partial: Partial,
    photographed: PhotoShare,
    index: int,
) -> None:
    height, width = ids.shape
    y, x = np.divmod(partial.pixel, width)
    share = partial.share[:, None]
    here = ids[y, x] == index
    own, own_weight, own_depth = _gather(hard, ids, depth, y, x, index, width, height)
    under, under_weight = _others(hard, backdrop, ids, depth, y, x, index, width, height)
    now = canvas[y, x].astype(np.float32)
    # Inside: let what is behind shine through. Outside: let the object reach into the pixel.
    behind = np.where(under_weight > 0, under, now)
    inner = share * now + (1 - share) * behind
    outer = share * own + (1 - share) * now
    before = (own_depth < depth[y, x]) & (own_depth < barrier[partial.pixel])
    mixed = np.where(here[:, None], inner, np.where((own_weight > 0) & before[:, None], outer, now))
    mixed += (now - mixed) * photographed(partial.pixel, index)[:, None]
    canvas[y, x] = np.clip(mixed + 0.5, 0, 255).astype(np.uint8)


def _gather(
    hard: Picture,
    ids: NDArray[np.int16],
    depth: NDArray[np.float32],
    y: NDArray,
    x: NDArray,
    index: int,
    width: int,
    height: int,
) -> tuple[NDArray, NDArray, NDArray]:
    """Mean colour and depth of the object in the pixels around, with how many there are."""
    total = np.zeros((len(y), 3), np.float32)
    weight = np.zeros((len(y), 1), np.float32)
    distance = np.zeros(len(y), np.float32)
    for dy, dx in _AROUND:
        ny, nx = np.clip(y + dy, 0, height - 1), np.clip(x + dx, 0, width - 1)
        mine = ids[ny, nx] == index
        total += np.where(mine[:, None], hard[ny, nx], 0)
        distance += np.where(mine, depth[ny, nx], 0)
        weight += mine[:, None]
    safe = np.maximum(weight, 1)
    return total / safe, weight, distance / safe[:, 0]


def _others(
    hard: Picture,
    backdrop: Picture,
    ids: NDArray[np.int16],
    depth: NDArray[np.float32],
    y: NDArray,
    x: NDArray,
    index: int,
    width: int,
    height: int,
) -> tuple[NDArray, NDArray]:
    """Mean colour of what is behind the object around each pixel, with how many there are."""
    total = np.zeros((len(y), 3), np.float32)
    weight = np.zeros((len(y), 1), np.float32)
    plate = backdrop[y, x].astype(np.float32)
    mine_depth = depth[y, x]
    for dy, dx in _AROUND:
        ny, nx = np.clip(y + dy, 0, height - 1), np.clip(x + dx, 0, width - 1)
        other = ids[ny, nx]
        empty = (other < 0)[:, None]
        behind = ((other >= 0) & (other != index) & (depth[ny, nx] > mine_depth))[:, None]
        total += np.where(empty, plate, np.where(behind, hard[ny, nx], 0))
        weight += empty | behind
    return total / np.maximum(weight, 1), weight
