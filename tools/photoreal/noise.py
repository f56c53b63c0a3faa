"""Seeded smooth noise in two and three dimensions, NumPy only."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


def smooth(rng: np.random.Generator, shape: tuple[int, int], cell: tuple[float, float]) -> Array:
    """Unit-variance noise (rows, columns) whose features are about `cell` pixels large."""
    coarse = tuple(max(2, int(np.ceil(n / c)) + 3) for n, c in zip(shape, cell, strict=True))
    grid = rng.standard_normal(coarse).astype(np.float32)
    # Cut a window out of the enlarged grid, so that no lattice line lies on the border.
    full = cv2.resize(
        grid,
        (int(coarse[1] * max(cell[1], 1)), int(coarse[0] * max(cell[0], 1))),
        interpolation=cv2.INTER_CUBIC,
    )
    top, left = (int(max(c, 1)) for c in cell)
    field = full[top : top + shape[0], left : left + shape[1]]
    return (field / max(float(field.std()), 1e-6)).astype(np.float32)


def layered(
    rng: np.random.Generator,
    shape: tuple[int, int],
    cell: tuple[float, float],
    octaves: int = 4,
    gain: float = 0.5,
) -> Array:
    """Fractal noise: every octave halves the feature and weighs `gain` of the one before."""
    total = np.zeros(shape, np.float32)
    for octave in range(octaves):
        size = (cell[0] / 2**octave, cell[1] / 2**octave)
        total += gain**octave * smooth(rng, shape, size)
    return total / max(float(total.std()), 1e-6)


def _hash(x: NDArray[np.int64], y: NDArray[np.int64], z: NDArray[np.int64], seed: int) -> Array:
    """A value in [-1, 1) for every lattice point, the same on every machine."""
    h = (x * 374761393 + y * 668265263 + z * 2147483647 + seed * 1274126177) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    h = ((h ^ (h >> 16)) * 2246822519) & 0xFFFFFFFF
    return (((h ^ (h >> 15)) & 0xFFFF) / 32768.0 - 1.0).astype(np.float32)


def solid(points: NDArray[np.floating], seed: int) -> Array:
    """Smooth value noise in about [-1, 1] at points (..., 3), lattice spacing 1."""
    base = np.floor(points)
    t = (points - base).astype(np.float32)
    t = t * t * t * (t * (t * 6 - 15) + 10)
    x, y, z = np.moveaxis(base.astype(np.int64), -1, 0)
    total = np.zeros(points.shape[:-1], np.float32)
    for corner in range(8):
        bits = ((corner >> 2) & 1, (corner >> 1) & 1, corner & 1)
        weight = np.ones_like(total)
        for axis, bit in enumerate(bits):
            weight *= t[..., axis] if bit else 1 - t[..., axis]
        total += weight * _hash(x + bits[0], y + bits[1], z + bits[2], seed)
    return total


def solid_layered(points: NDArray[np.floating], seed: int, octaves: int = 3) -> Array:
    """Fractal version of `solid`, gain one half."""
    return sum(
        (0.5**o * solid(points * 2.0**o, seed + o) for o in range(octaves)),
        start=np.zeros(points.shape[:-1], np.float32),
    )
