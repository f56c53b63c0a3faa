"""Smooth outlines: partly covered pixels mix an object with what lies behind it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.coverage import Partial
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.raster import FloatArray

PhotoShare = Callable[[NDArray[np.int64], NDArray[np.int32]], NDArray[np.float32]]
"""Flat pixels and objects (K,) → share (K,) of the photo there, which needs no mixing."""

_AROUND = np.array([(0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1)])


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
    shown = np.bincount(ids.ravel()[ids.ravel() >= 0], minlength=len(partial)) > 0
    parts = [(i, part) for i, part in enumerate(partial) if shown[i] and len(part.pixel)]
    if not parts:
        return
    pixel = np.concatenate([part.pixel for _, part in parts])
    owner = np.concatenate([np.full(len(part.pixel), i, np.int32) for i, part in parts])
    share = np.concatenate([part.share for _, part in parts])[:, None]
    around = _Around.of(canvas, ids, depth, pixel)
    mine = around.ids == owner[:, None]
    here = ids.ravel()[pixel] == owner
    now = canvas.reshape(-1, 3)[pixel].astype(np.float32)
    # Inside: let what is behind shine through. Outside: let the object reach into the pixel.
    own, own_count = _mean(around.colors, mine)
    plate = backdrop.reshape(-1, 3)[pixel].astype(np.float32)
    under = _under(around, mine, plate, depth.ravel()[pixel], now)
    own_depth = np.where(mine, around.depth, np.inf).min(1)
    before = (own_depth < depth.ravel()[pixel]) & (own_depth < barrier[pixel]) & (own_count > 0)
    outer = np.where(before[:, None], share * own + (1 - share) * now, now)
    mixed = np.where(here[:, None], share * now + (1 - share) * under, outer)
    mixed += (now - mixed) * photographed(pixel, owner)[:, None]
    # Where two outlines share a pixel the nearer object has the last word.
    order = np.argsort(-np.where(here, depth.ravel()[pixel], own_depth), kind="stable")
    result = np.clip(mixed + 0.5, 0, 255).astype(np.uint8)
    changed = order[here[order] | before[order]]
    canvas.reshape(-1, 3)[pixel[changed]] = result[changed]


def blend_hidden(
    canvas: Picture,
    backdrop: Picture,
    ids: NDArray[np.int16],
    hidden: NDArray[np.int64],
    owner: NDArray[np.int32],
    share: NDArray[np.float32],
) -> None:
    """Smooth the line along which a support hides an object, in place.

    hidden, owner: (K,) flat pixels where a support hides an object, and which. share: (H·W,)
    how much of each pixel supports cover.
    """
    if not len(hidden):
        return
    height, width = ids.shape
    mask = np.full(ids.size, -1, np.int16)
    mask[hidden] = owner
    mask = mask.reshape(ids.shape)
    hard = canvas.copy()
    for first, second in ((ids, mask), (mask, ids)):
        # Pixels of the first kind that touch the second kind of the same object.
        touching = np.zeros(ids.shape, bool)
        for dy, dx in _AROUND[:4]:
            here = (slice(max(0, -dy), height - max(0, dy)), slice(max(0, -dx), width - max(0, dx)))
            there = (slice(max(0, dy), height + min(0, dy)), slice(max(0, dx), width + min(0, dx)))
            touching[here] |= (first[here] >= 0) & (first[here] == second[there])
        pixel = np.flatnonzero(touching)
        pixel = pixel[(share[pixel] > 0) & (share[pixel] < 1)]
        if not len(pixel):
            continue
        around = _Around.of(hard, ids, np.zeros(ids.shape, np.float32), pixel)
        mean, count = _mean(around.colors, around.ids == first.ravel()[pixel, None])
        shown = ids.ravel()[pixel] >= 0
        color = np.where(shown[:, None], hard.reshape(-1, 3)[pixel], mean)
        part = np.where((count > 0) | shown, share[pixel], 1)[:, None]
        mixed = backdrop.reshape(-1, 3)[pixel] * part + color * (1 - part)
        canvas.reshape(-1, 3)[pixel] = np.clip(mixed + 0.5, 0, 255).astype(np.uint8)


@dataclass(frozen=True, eq=False, slots=True)
class _Around:
    """The eight pixels around each of K: ids and depth (K, 8), colors (K, 8, 3)."""

    ids: NDArray[np.int16]
    depth: NDArray[np.float32]
    colors: NDArray[np.uint8]

    @classmethod
    def of(
        cls,
        canvas: Picture,
        ids: NDArray[np.int16],
        depth: NDArray[np.float32],
        pixel: NDArray[np.int64],
    ) -> Self:
        height, width = ids.shape
        y, x = np.divmod(pixel, width)
        ny = np.clip(y[:, None] + _AROUND[:, 0], 0, height - 1)
        nx = np.clip(x[:, None] + _AROUND[:, 1], 0, width - 1)
        flat = ny * width + nx
        return cls(ids.ravel()[flat], depth.ravel()[flat], canvas.reshape(-1, 3)[flat])


def _mean(colors: NDArray, chosen: NDArray[np.bool_]) -> tuple[NDArray, NDArray]:
    """Mean (K, 3) of the chosen of eight colours, and how many there are."""
    count = chosen.sum(1)
    total = np.einsum("ke,kec->kc", chosen.astype(np.float32), colors.astype(np.float32))
    return total / np.maximum(count, 1)[:, None], count


def _under(
    around: _Around, mine: NDArray[np.bool_], plate: NDArray, depth: NDArray, now: NDArray
) -> NDArray:
    """What lies behind an object at its outline (K, 3): the plate, or objects farther away."""
    empty = around.ids < 0
    behind = ~mine & ~empty & (around.depth > depth[:, None])
    others, count = _mean(around.colors, behind)
    free = empty.sum(1)
    total = (others * count[:, None] + plate * free[:, None]) / np.maximum(count + free, 1)[:, None]
    return np.where((count + free > 0)[:, None], total, now)
