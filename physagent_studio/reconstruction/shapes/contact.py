"""Where things touch: heights of surfaces over a grid, and the gap between two bodies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray


def vertical_gap(
    upper: FloatArray,
    upper_faces: NDArray[np.int32],
    lower: FloatArray,
    lower_faces: NDArray[np.int32],
) -> float | None:
    """Smallest height (m) of the upper body over the lower one; negative where they overlap.

    World vertices (V, 3) and faces of two closed meshes. None where neither is over the other.
    """
    low = np.maximum(upper[:, :2].min(0), lower[:, :2].min(0))
    high = np.minimum(upper[:, :2].max(0), lower[:, :2].max(0))
    if np.any(high <= low):
        return None
    grid_count = 40  # 10..200: heights along each side of the area that two bodies share
    # Vertices of both in the shared area join the grid: corners and poles touch first.
    axes = [np.linspace(low[k], high[k], grid_count) for k in range(2)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)
    spots = [grid, *(_within(body, low, high) for body in (upper, lower))]
    places = np.vstack(spots)
    top = heights(lower, lower_faces, places, highest=True)
    bottom = heights(upper, upper_faces, places, highest=False)
    gap = bottom - top
    return float(np.nanmin(gap)) if np.isfinite(gap).any() else None


def _within(body: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    places = body[:, :2]
    inside = places[((places >= low) & (places <= high)).all(1)]
    step = max(1, len(inside) // 1500)
    return inside[::step]


def heights(
    vertices: FloatArray, faces: NDArray[np.int32], places: FloatArray, *, highest: bool
) -> FloatArray:
    """Highest (or lowest) surface over places (N, 2); NaN beside the body; (N,) m."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    low, high = places.min(0), places.max(0)
    left = np.minimum(np.minimum(a, b), c)[:, :2]
    right = np.maximum(np.maximum(a, b), c)[:, :2]
    # Upward faces make the top, downward faces the bottom.
    keep = (area > 1e-14) if highest else (area < -1e-14)
    keep &= ((right >= low) & (left <= high)).all(1)
    a, b, c, area = a[keep], b[keep], c[keep], area[keep]
    out = np.full(len(places), -np.inf if highest else np.inf)
    for start in range(0, len(a), 400):
        part = slice(start, start + 400)
        z = _over(a[part], b[part], c[part], area[part], places, -np.inf if highest else np.inf)
        out = np.maximum(out, z.max(0)) if highest else np.minimum(out, z.min(0))
    return np.where(np.isfinite(out), out, np.nan)


def _over(
    a: FloatArray, b: FloatArray, c: FloatArray, area: FloatArray, places: FloatArray, none: float
) -> FloatArray:
    """(F, N) height of each face over each place, `none` beside it."""
    dx = places[None, :, 0] - a[:, :1]
    dy = places[None, :, 1] - a[:, 1:2]
    v = (dx * (c[:, 1:2] - a[:, 1:2]) - dy * (c[:, :1] - a[:, :1])) / area[:, None]
    w = (dy * (b[:, :1] - a[:, :1]) - dx * (b[:, 1:2] - a[:, 1:2])) / area[:, None]
    z = a[:, 2:] + v * (b[:, 2:] - a[:, 2:]) + w * (c[:, 2:] - a[:, 2:])
    return np.where((v >= -1e-9) & (w >= -1e-9) & (v + w <= 1 + 1e-9), z, none)
