"""Flat outlines: what lies inside a polygon, and how deep."""

from __future__ import annotations

import numpy as np

from physagent_studio.arrays import FloatArray


def in_order(outline: FloatArray) -> FloatArray:
    """A quadrilateral's corners in order round it, however they were clicked."""
    if len(outline) != 4:
        return outline
    off = outline - outline.mean(axis=0)
    return outline[np.argsort(np.arctan2(off[:, 1], off[:, 0]))]


def inside_depth(points: FloatArray, outline: FloatArray) -> FloatArray:
    """(T,) signed distance of points (T, 2) to a simple polygon (K, 2), positive inside, m."""
    start, end = outline, np.roll(outline, -1, axis=0)
    along = end - start
    to_point = points[:, None] - start
    square = np.maximum(np.sum(along**2, -1), 1e-12)
    share = np.clip(np.sum(to_point * along, -1) / square, 0, 1)
    distance = np.linalg.norm(to_point - share[..., None] * along, axis=-1).min(axis=1)
    y = points[:, 1:2]
    spans = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(np.abs(along[:, 1]) < 1e-12, 1e-12, along[:, 1])
    crossing = start[:, 0] + (y - start[:, 1]) / rise * along[:, 0]
    inside = (spans & (points[:, :1] < crossing)).sum(axis=1) % 2 == 1
    return np.where(inside, distance, -distance)
