"""Pieces of a picture put together in a hole of it, at full size and without seams."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray, FloatImage
from physagent_studio.reconstruction.background.harmonic_fill import from_steps, reduced
from physagent_studio.reconstruction.background.shift_map import rescaled
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """A picture (H, W, 3) at some size, what is missing and barred (H, W) in it, and its ratio."""

    image: FloatImage
    missing: BoolArray
    barred: BoolArray
    ratio: FloatArray

    @classmethod
    def of(cls, part: FloatImage, missing: BoolArray, barred: BoolArray, side: float) -> Self:
        """With this longer side at most."""
        factor = min(1.0, side / max(missing.shape))
        if factor == 1.0:
            return cls(part, missing, barred, np.ones(2))
        size = (max(8, round(missing.shape[1] * factor)), max(8, round(missing.shape[0] * factor)))
        image, closed = reduced(part, barred, size)
        hole = cv2.resize(missing.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0.01
        ratio = np.array([size[0] / missing.shape[1], size[1] / missing.shape[0]])
        return cls(image, np.asarray(hole), closed | hole, ratio)


def sources(
    copy: FloatArray, x: NDArray[np.int64], y: NDArray[np.int64]
) -> tuple[FloatImage, FloatImage, FloatImage]:
    """Where pixels are copied from, x and y, and how much finer the picture is there.

    Far outside of every picture, and not fine at all, beyond the horizon.
    """
    m = copy.astype(np.float32)
    u, v = x.astype(np.float32) + np.float32(0.5), y.astype(np.float32) + np.float32(0.5)
    depth = m[2, 0] * u + m[2, 1] * v + m[2, 2]
    ahead = depth > 1e-6
    depth = np.where(ahead, depth, 1).astype(np.float32)
    across = (m[0, 0] * u + m[0, 1] * v + m[0, 2]) / depth - np.float32(0.5)
    down = (m[1, 0] * u + m[1, 1] * v + m[1, 2]) / depth - np.float32(0.5)
    finer = np.float32(abs(np.linalg.det(copy))) / depth**3
    outside = np.float32(-1e4)
    across = np.where(ahead, across, outside).clip(-1e4, 1e4)
    down = np.where(ahead, down, outside).clip(-1e4, 1e4)
    return across, down, np.where(ahead, finer, 0).astype(np.float32)


def blocked(barred: BoolArray, x: FloatImage, y: FloatImage) -> BoolArray:
    """Which places (N,) are barred or beyond the picture."""
    return np.asarray(taken(barred.astype(np.float32), x, y, beyond=1.0) > 0.02)


def taken(
    image: FloatImage,
    x: FloatImage,
    y: FloatImage,
    how: int = cv2.INTER_LINEAR,
    beyond: float | None = None,
) -> FloatImage:
    """Colours (N, C) or values (N,) of an image at places (N,); outside `beyond`, else its rim."""
    fold = 512  # remap takes no side longer than 32767.
    lacking = -len(x) % fold
    border = cv2.BORDER_REPLICATE if beyond is None else cv2.BORDER_CONSTANT
    across, down = (np.pad(v, (0, lacking), mode="edge").reshape(-1, fold) for v in (x, y))
    value = cv2.remap(image, across, down, how, borderMode=border, borderValue=beyond or 0.0)
    return value.reshape(-1, *image.shape[2:])[: len(x)].astype(np.float32)


def joined(
    part: FloatImage,
    missing: BoolArray,
    barred: BoolArray,
    label: NDArray[np.int64],
    copies: Sequence[FloatArray | None],
    smooth: FloatImage,
) -> FloatImage:
    """The pieces at full size, shifted in colour so that they meet the photo and one another.

    smooth: (H, W, 3) what a copy that is None shows.
    """
    joining_px = 300  # 150..600: longer side of the picture in which pieces are joined
    view = View.of(part, missing, barred, joining_px)
    hole = view.missing
    even = np.asarray(cv2.resize(smooth, hole.shape[::-1], interpolation=cv2.INTER_AREA), "f4")
    small = [copy if copy is None else rescaled(copy, *view.ratio) for copy in copies]
    laid = _outlined(hole, view.barred, label, small)
    rough = _pasted(view.image, hole, laid, small, even)
    joined = _levelled(view.image, hole, laid, small, rough, even)
    change = np.where(hole[..., None], joined - rough, 0).astype(np.float32)
    whole = _outlined(missing, barred, label, copies)
    out = _pasted(part, missing, whole, copies, smooth)
    for k in range(len(copies)):
        mine = missing & (whole == k)
        if mine.any():
            window = _window(mine, 0)
            shift = _spread(change, hole & (laid == k), missing.shape, window)
            out[window][mine[window]] += shift[mine[window]]
    return out


def _window(mine: BoolArray, margin: int) -> tuple[slice, slice]:
    """The part of the picture where something is."""
    x0, y0, x1, y1 = bounds(mine)
    rows = slice(max(0, y0 - margin), min(mine.shape[0], y1 + margin))
    return rows, slice(max(0, x0 - margin), min(mine.shape[1], x1 + margin))


def _spread(
    change: FloatImage, known: BoolArray, shape: tuple[int, int], window: tuple[slice, slice]
) -> FloatImage:
    """A change (h, w, 3) known in some places, smoothly at full size, in a window of it."""
    weight = cv2.GaussianBlur(known.astype(np.float32), (0, 0), 1.0)
    total = cv2.GaussianBlur(np.where(known[..., None], change, 0).astype(np.float32), (0, 0), 1.0)
    y, x = np.mgrid[window].astype(np.float32)
    x = (x + np.float32(0.5)) * np.float32(known.shape[1] / shape[1]) - np.float32(0.5)
    y = (y + np.float32(0.5)) * np.float32(known.shape[0] / shape[0]) - np.float32(0.5)
    wide = cv2.remap(total, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    share = cv2.remap(weight, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(wide / np.maximum(share, 1e-3)[..., None], np.float32)


def _outlined(
    hole: BoolArray,
    barred: BoolArray,
    label: NDArray[np.int64],
    copies: Sequence[FloatArray | None],
) -> NDArray[np.int64]:
    """Which piece (H, W) lies where at this size; one that is not in the hole itself if any is."""
    best = np.full(hole.shape, -3.0, np.float32)
    laid = np.zeros(hole.shape, np.int64)
    for k, copy in enumerate(copies):
        share = cv2.resize((label == k).astype(np.float32), hole.shape[::-1])
        rows, columns = np.nonzero(hole & ((share > 0) | (best < 0)))
        if not len(rows):
            continue
        value = share[rows, columns]
        if copy is not None:
            x, y, _ = sources(copy, columns, rows)
            value = value - 2 * blocked(barred, x, y)
        better = value > best[rows, columns]
        at = rows[better], columns[better]
        laid[at], best[at] = k, value[better]
    return laid


def _pasted(
    image: FloatImage,
    hole: BoolArray,
    laid: NDArray[np.int64],
    copies: Sequence[FloatArray | None],
    smooth: FloatImage,
) -> FloatImage:
    """The picture with what the pieces show in its hole."""
    out = image.copy()
    for k, copy in enumerate(copies):
        rows, columns = np.nonzero(hole & (laid == k))
        if copy is None:
            out[rows, columns] = smooth[rows, columns]
        elif len(rows):
            x, y, _ = sources(copy, columns, rows)
            out[rows, columns] = taken(image, x, y, cv2.INTER_CUBIC)
    return out


def _seen(
    image: FloatImage, copy: FloatArray | None, window: tuple[slice, slice], smooth: FloatImage
) -> FloatImage:
    """What a copy shows in a window of the picture."""
    if copy is None:
        return smooth[window]
    y, x = np.mgrid[window]
    sx, sy, _ = sources(copy, x, y)
    shown = cv2.remap(image, sx, sy, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(shown, np.float32)


def _levelled(
    image: FloatImage,
    hole: BoolArray,
    laid: NDArray[np.int64],
    copies: Sequence[FloatArray | None],
    rough: FloatImage,
    smooth: FloatImage,
) -> FloatImage:
    """The composed hole with the steps of its pieces, no steps of brightness between them."""
    totals = [np.zeros(image.shape, np.float32) for _ in range(2)]
    counts = [np.zeros(hole.shape, np.float32) for _ in range(2)]
    for k, copy in enumerate(copies):
        mine = hole & (laid == k)
        if not mine.any():
            continue
        window = _window(mine, 2)
        picture = _seen(image, copy, window, smooth)
        for axis, total, count in zip((1, 0), totals, counts, strict=True):
            # The step as seen from its first pixel's piece, then from its second pixel's.
            share = mine[window].astype(np.float32)
            share[: -1 if axis == 0 else None, : -1 if axis == 1 else None] += mine[window][
                1 if axis == 0 else 0 :, 1 if axis == 1 else 0 :
            ]
            total[window] += share[..., None] * (np.roll(picture, -1, axis) - picture)
            count[window] += share
    steps = [
        np.asarray(t / np.maximum(c, 1)[..., None], np.float32)
        for t, c in zip(totals, counts, strict=True)
    ]
    weights = []
    even = np.isin(laid, [k for k, copy in enumerate(copies) if copy is None])
    stray_levels = 14.0  # 5..40: between two pieces at a seam, from which it is an edge
    for axis, step in zip((1, 0), steps, strict=True):
        miss = np.abs(np.roll(rough, -1, axis) - rough - step).mean(-1)
        weight = 1 / (1 + (miss / stray_levels) ** 4)
        # The smooth fill has no edges: where it meets a copy there is none either.
        weight = np.where(hole & (even != np.roll(even, -1, axis)), 1.0, weight)
        weights.append(weight.astype(np.float32))
    anchor_weight = 4e-4  # weight, 1e-5..1e-2: of the copied colours beside the steps between them
    return from_steps(rough, hole, (steps[0], steps[1]), (weights[0], weights[1]), anchor_weight)
