"""Volumes of shapes; of open vessels that of their walls."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.program.scene import forms
from physagent_studio.program.scene.boards import open_box

Profile = tuple[tuple[float, float], ...]


def volume_of(shape: forms.Shape) -> float:
    """Volume in m³; of an inflated mask or a mesh the estimate that its size allows."""
    match shape:
        case forms.Sphere():
            return 4 / 3 * math.pi * shape.radius**3
        case forms.Ellipsoid():
            return 4 / 3 * math.pi * math.prod(shape.radii)
        case forms.Box():
            if shape.wall is None:
                return math.prod(shape.size)
            return sum(math.prod(edges) for _, edges in open_box(shape.size, shape.wall))
        case forms.Cylinder():
            return math.pi * shape.radius**2 * shape.height
        case forms.Capsule():
            straight = max(shape.height - 2 * shape.radius, 0.0)
            return math.pi * shape.radius**2 * (straight + 4 / 3 * shape.radius)
        case forms.Torus():
            return 2 * math.pi**2 * shape.radius * shape.tube**2
        case forms.Frustum():
            ends = ((0.0, shape.bottom_radius), (shape.height, shape.top_radius))
            return _turned(ends, shape.wall)
        case forms.Revolved():
            return _turned(shape.profile, shape.wall)
        case forms.Inflated():
            return math.pi / 6 * math.prod(shape.size)
        case forms.Meshed():
            return 0.5 * math.prod(shape.size)


def _turned(profile: Profile, wall: float | None) -> float:
    """Of a solid of revolution (z, radius), without the hollow that walls leave."""
    z, radius = np.array(sorted(profile), float).T
    whole = _between(z, radius)
    if wall is None:
        return whole
    bottom = min(float(z[0]) + wall, float(z[-1]))
    heights = np.concatenate([[bottom], z[z > bottom]])
    return whole - _between(heights, np.maximum(np.interp(heights, z, radius) - wall, 0.0))


def _between(z: np.ndarray, radius: np.ndarray) -> float:
    """Frusta between the rows of a profile."""
    parts = np.diff(z) * (radius[1:] ** 2 + radius[1:] * radius[:-1] + radius[:-1] ** 2) / 3
    return abs(float(math.pi * parts.sum()))
