"""Points on and in a shape, from which deformables, grains and pieces are made."""

import math

import numpy as np
from scipy.spatial import KDTree
from trimesh.remesh import subdivide_to_size

from physagent_studio.program.scene import forms
from physagent_studio.records import Mesh
from physagent_studio.simulation.bodies.vessel import rising
from physagent_studio.simulation.surfaces import FloatArray, Surface, hull, revolve

CORNERS = 140
"""Points at most on the skin of a soft body."""


def skin_points(shape: forms.Shape, mesh: Mesh | None, extent: FloatArray) -> FloatArray:
    """Points (N, 3), body frame, m, whose convex hull is the shape's, evenly spread."""
    match shape:
        case forms.Sphere(radius=r):
            return _ball(CORNERS) * r
        case forms.Ellipsoid(radii=radii):
            return _ball(CORNERS) * np.asarray(radii)
        case forms.Box(size=size):
            return _box(np.asarray(size), 5)
        case forms.Cylinder(radius=r, height=h):
            return revolve(np.array([[z, r] for z in np.linspace(-h / 2, h / 2, 5)]), 20)[0]
        case forms.Capsule(radius=r, height=h):
            return _capsule(r, h)
        case forms.Frustum(bottom_radius=low, top_radius=high, height=h):
            total = low * low + low * high + high * high
            centre = h / 4 * (low * low + 2 * low * high + 3 * high * high) / max(total, 1e-12)
            share = np.linspace(0, 1, 5)
            return revolve(np.column_stack([share * h - centre, low + share * (high - low)]), 20)[0]
        case forms.Torus(radius=r, tube=tube):
            turns = np.linspace(-math.pi / 2, math.pi / 2, 7)
            rim = np.column_stack([tube * np.sin(turns), r + tube * np.cos(turns)])
            return _thinned(revolve(rim, 20)[0])
        case forms.Revolved(profile=profile):
            return _thinned(revolve(rising(np.array(profile, float)), 20)[0])
        case _ if mesh is not None:
            return _thinned(hull(np.asarray(mesh.vertices, float), "mesh")[0])
        case _:
            return _ball(CORNERS) * extent / 2


def refined(surface: Surface) -> Surface:
    """The surface with its long edges divided, so that flat faces can bend and touch."""
    longest = float(np.ptp(surface[0], axis=0).max()) / 4
    divided = subdivide_to_size(surface[0], surface[1], longest, max_iter=20)
    vertices, faces = divided[0], divided[1]
    # Divided faces repeat the corners that they share.
    merged, index = np.unique(vertices.round(9), axis=0, return_inverse=True)
    return merged, index[faces].astype(np.int32)


def _ball(count: int) -> FloatArray:
    """Points on the unit sphere (Fibonacci lattice)."""
    index = np.arange(count) + 0.5
    polar = np.arccos(1 - 2 * index / count)
    turn = math.pi * (1 + 5**0.5) * index
    return np.column_stack(
        [np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)]
    )


def _box(size: FloatArray, count: int) -> FloatArray:
    axis = np.linspace(-0.5, 0.5, count)
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    return grid[np.abs(grid).max(1) > 0.499] * size


def _capsule(radius: float, height: float) -> FloatArray:
    shaft = max(height / 2 - radius, 0.0)
    angles = np.linspace(-math.pi / 2, math.pi / 2, 7)
    profile = np.column_stack([radius * np.sin(angles), radius * np.abs(np.cos(angles))])
    profile[:, 0] += np.where(angles < 0, -shaft, shaft)
    profile[[0, -1], 1] = 0
    return revolve(profile, 16)[0]


def _thinned(points: FloatArray) -> FloatArray:
    """At most CORNERS of the points, farthest first."""
    if len(points) <= CORNERS:
        return points
    chosen = [int(np.argmax(np.linalg.norm(points - points.mean(0), axis=1)))]
    away = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < CORNERS:
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return points[chosen]


def packed(outer: Surface, count: int) -> tuple[FloatArray, FloatArray]:
    """About `count` spheres in a convex surface: centres (N, 3) and radii (N,), m.

    Staggered layers of unequal spheres: equal ones in rows would stand like masonry.
    """
    low, high = outer[0].min(0), outer[0].max(0)
    spacing = float(np.prod(high - low) / count) ** (1 / 3)
    best = _within(outer, low, high, spacing)
    for _ in range(40):
        inside = _within(outer, low, high, spacing)
        if abs(len(inside) - count) < abs(len(best) - count):
            best = inside
        if abs(len(inside) - count) <= max(0.03 * count, 1):
            break
        spacing *= 0.5 + 0.5 * (max(len(inside), 1) / count) ** (1 / 3)
    gap = _least_gap(best, spacing)
    radii = np.random.default_rng(0).uniform(0.8, 0.98, len(best)) * gap / 2
    return best, radii


def _least_gap(points: FloatArray, spacing: float) -> float:
    """Smallest distance of two points, m."""
    if len(points) < 2:
        return spacing
    return float(KDTree(points).query(points, k=2)[0][:, 1].min())


def _within(outer: Surface, low: FloatArray, high: FloatArray, spacing: float) -> FloatArray:
    """Points of a staggered grid whose spheres lie inside the convex surface."""
    step = np.array([spacing, spacing, spacing * math.sqrt(0.5)])
    counts = np.maximum(np.floor((high - low) / step).astype(int), 1)
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1)
    cells = cells.reshape(-1, 3).astype(float)
    cells[:, :2] += 0.25 - 0.5 * (cells[:, 2:] % 2)
    grid = (low + high) / 2 + (cells - (counts - 1) / 2) * step
    vertices, faces = outer
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-15)
    depth = np.einsum("fi,fi->f", normal, a) - grid @ normal.T
    inside = grid[depth.min(1) >= 0.45 * spacing]
    return inside if len(inside) else (low + high)[None] / 2
