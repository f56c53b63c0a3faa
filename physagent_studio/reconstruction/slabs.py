"""Tables, shelves and steps: the visible edges of a top surface make a slab."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import Slab
from physagent_studio.reconstruction.geometry import on_plane
from physagent_studio.reconstruction.lines import Segments
from physagent_studio.reconstruction.masks import BoolArray, grow

FloatArray = NDArray[np.float64]

SOLID = frozenset({"box", "crate", "block", "step", "stair", "pedestal", "podium", "platform"})
"""Supports that reach down to the floor as one body."""


@dataclass(frozen=True, eq=False, slots=True)
class _Edges:
    """Edges on the top's plane: middle (N, 2), direction (N,) radians, weight (N,)."""

    middle: FloatArray
    angle: FloatArray
    weight: FloatArray


def fit_slab(
    camera: Camera,
    top: float,
    region: BoolArray,
    found: Segments,
    standing: Sequence[tuple[float, float]],
    clicks: Sequence[tuple[float, float]],
    thickness: float,
) -> Slab | None:
    """The slab whose top at height `top` shows as `region` in the picture.

    found: edges of the picture. standing: pixels of the feet of what stands on it; these lie on
    the top. clicks: pixels that a person gave; four or more clicks are the corners of the top.
    None where nothing of the plane is in view.
    """
    if len(clicks) >= 4:
        corners = on_plane(camera, clicks, top)[:, :2]
        if np.isfinite(corners).all():
            return _around(corners, _longest_side(corners), top, thickness)
    seeds = on_plane(camera, list(standing) or list(clicks), top)[:, :2]
    seeds = seeds[np.isfinite(seeds).all(1)]
    area = _region_on_plane(camera, top, region, standing)
    if not len(seeds):
        seeds = np.median(area, axis=0, keepdims=True) if len(area) else seeds
    if not len(seeds):
        return None
    edges = _edges_on_plane(camera, top, region, found)
    yaw = _main_direction(edges)
    limits = _limits(camera, yaw, seeds, edges, area)
    return _slab(yaw, limits, top, thickness)


def _region_on_plane(
    camera: Camera, top: float, region: BoolArray, standing: Sequence[tuple[float, float]]
) -> FloatArray:
    """Places (N, 2) of a sample of the region's pixels on the plane."""
    rows, columns = np.nonzero(region)
    if len(rows) < 20:
        return np.zeros((0, 2))
    step = max(1, len(rows) // 3000)
    pixels = np.column_stack([columns[::step] + 0.5, rows[::step] + 0.5])
    places = on_plane(camera, pixels, top)[:, :2]
    places = places[np.isfinite(places).all(1)]
    far = 25 * max(camera.position[2] - top, 0.01)
    return places[np.hypot(places[:, 0], places[:, 1] - camera.position[1]) < far]


def _edges_on_plane(camera: Camera, top: float, region: BoolArray, found: Segments) -> _Edges:
    """Edges at the rim of the region, as lines on the plane of the top."""
    near = grow(region, max(4, round(0.012 * max(region.shape)))) if region.any() else ~region
    if not len(found.length):
        return _Edges(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    share = np.linspace(0.02, 0.98, 16)[None, :, None]
    along = found.ends[:, :1] * (1 - share) + found.ends[:, 1:] * share
    columns = np.clip(along[..., 0].astype(int), 0, region.shape[1] - 1)
    rows = np.clip(along[..., 1].astype(int), 0, region.shape[0] - 1)
    touching = near[rows, columns].mean(1) > 0.6
    touching &= found.ends[:, :, 1].min(1) > camera.horizon + 0.01 * region.shape[0]
    used = found.only(touching)
    first = on_plane(camera, used.ends[:, 0], top)[:, :2]
    second = on_plane(camera, used.ends[:, 1], top)[:, :2]
    fine = np.isfinite(first).all(1) & np.isfinite(second).all(1)
    delta = (second - first)[fine]
    weight = used.length[fine] * np.minimum(used.contrast[fine], 25) / 25
    return _Edges((first + second)[fine] / 2, np.arctan2(delta[:, 1], delta[:, 0]), weight)


def _main_direction(edges: _Edges) -> float:
    """The turn of a rectangle that most edges run along, −45° … 45°."""
    if not len(edges.weight):
        return 0.0
    grid = np.radians(np.arange(-45, 45, 0.5))
    off = (edges.angle[None] - grid[:, None] + math.pi / 4) % (math.pi / 2) - math.pi / 4
    votes = (np.exp(-0.5 * (off / math.radians(4)) ** 2) * edges.weight).sum(1)
    # Where nothing speaks against it, a table stands square to the picture.
    votes = votes + 0.04 * edges.weight.sum() * np.exp(-0.5 * (grid / math.radians(6)) ** 2)
    best = grid[int(votes.argmax())]
    off = (edges.angle - best + math.pi / 4) % (math.pi / 2) - math.pi / 4
    near = np.abs(off) < math.radians(5)
    if not near.any():
        return float(best)
    return float(best + np.average(off[near], weights=edges.weight[near]))


def _limits(
    camera: Camera, yaw: float, seeds: FloatArray, edges: _Edges, area: FloatArray
) -> FloatArray:
    """(4,) how far the top reaches along +x', +y', −x', −y' of the turned frame."""
    axes = [(math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))]
    directions = np.array([axes[0], axes[1], (-axes[0][0], -axes[0][1]), (-axes[1][0], -axes[1][1])])
    limits = np.zeros(4)
    over = max(camera.position[2], 0.1)
    for k, direction in enumerate(directions):
        inner = float((seeds @ direction).max())
        runs = edges.angle - math.atan2(direction[1], direction[0])
        across = np.abs(np.cos(runs)) < math.sin(math.radians(8))
        offset = edges.middle[across] @ direction
        weight = edges.weight[across]
        outward = offset > inner - 0.02 * over
        limits[k] = _nearest_strong(offset[outward], weight[outward], inner)
        if not math.isfinite(limits[k]):
            reach = float(np.percentile(area @ direction, 99)) if len(area) else inner
            limits[k] = max(reach, inner + 0.05 * over) + 0.25 * over
    return limits


def _nearest_strong(offset: FloatArray, weight: FloatArray, inner: float) -> float:
    """Offset of the first edge outward that is not much weaker than the strongest; inf: none."""
    if not len(offset) or weight.max() < 12:
        return math.inf
    spread = 0.02 * max(float(np.ptp(offset)), 0.2)
    pooled = np.array([(weight * (np.abs(offset - o) < spread)).sum() for o in offset])
    strong = np.flatnonzero(pooled > 0.35 * pooled.max())
    first = strong[int(offset[strong].argmin())]
    near = np.abs(offset - offset[first]) < spread
    return max(float(np.average(offset[near], weights=weight[near])), inner)


def _longest_side(corners: FloatArray) -> float:
    sides = np.roll(corners, -1, axis=0) - corners
    longest = sides[int(np.hypot(sides[:, 0], sides[:, 1]).argmax())]
    angle = math.atan2(longest[1], longest[0])
    return (angle + math.pi / 4) % (math.pi / 2) - math.pi / 4


def _around(corners: FloatArray, yaw: float, top: float, thickness: float) -> Slab:
    ahead = np.array([math.cos(yaw), math.sin(yaw)])
    side = np.array([-math.sin(yaw), math.cos(yaw)])
    limits = [(corners @ ahead).max(), (corners @ side).max()]
    limits += [-(corners @ ahead).min(), -(corners @ side).min()]
    return _slab(yaw, np.array(limits), top, thickness)


def _slab(yaw: float, limits: FloatArray, top: float, thickness: float) -> Slab:
    """limits: reach along +x', +y', −x', −y'."""
    size_x = max(float(limits[0] + limits[2]), 0.02)
    size_y = max(float(limits[1] + limits[3]), 0.02)
    along, across = float(limits[0] - limits[2]) / 2, float(limits[1] - limits[3]) / 2
    cos, sin = math.cos(yaw), math.sin(yaw)
    x, y = along * cos - across * sin, along * sin + across * cos
    return Slab(position=(x, y, top - thickness / 2), size=(size_x, size_y, thickness), yaw=yaw)
