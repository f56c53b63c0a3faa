"""Pixels to places: where the ray of a pixel meets a plane of the scene."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera


@dataclass(frozen=True, slots=True)
class RaySettings:
    """Where rays meet things."""

    # 1e-6..1e-3: things that touch stay so far apart: no engine sees them overlap
    clearance_m: float = 1e-5


RAY = RaySettings()


def on_plane(camera: Camera, pixels: ArrayLike, height: float) -> FloatArray:
    """World points (N, 3) where the rays of `pixels` (N, 2) meet the plane z = height.

    A ray that never meets it (at or above its vanishing line) gives NaN.
    """
    rays = camera.rays(np.asarray(pixels, float).reshape(-1, 2))
    drop = np.where(np.abs(rays[:, 2]) < 1e-9, np.nan, rays[:, 2])
    along = (height - camera.position[2]) / drop
    along = np.where(along > 0, along, np.nan)
    return np.asarray(camera.position) + rays * along[:, None]


def on_upright(camera: Camera, pixels: ArrayLike, y: float) -> FloatArray:
    """World points (N, 3) where the rays of `pixels` meet the upright plane at depth y."""
    rays = camera.rays(np.asarray(pixels, float).reshape(-1, 2))
    along = (y - camera.position[1]) / np.where(np.abs(rays[:, 1]) < 1e-9, np.nan, rays[:, 1])
    return np.asarray(camera.position) + rays * along[:, None]


def on_upright_through(
    camera: Camera, pixels: ArrayLike, point: ArrayLike, normal: ArrayLike
) -> FloatArray:
    """World points (N, 3) where the rays meet the plane through `point` with `normal`."""
    rays = camera.rays(np.asarray(pixels, float).reshape(-1, 2))
    n = np.asarray(normal, float)
    offset = float((np.asarray(point, float) - np.asarray(camera.position)) @ n)
    facing = rays @ n
    along = offset / np.where(np.abs(facing) < 1e-9, np.nan, facing)
    return np.asarray(camera.position) + rays * along[:, None]


def depth_of(camera: Camera, point: ArrayLike) -> float:
    """Depth of a world point along the optical axis, m."""
    return float(camera.project(np.atleast_2d(np.asarray(point, float)))[1][0])


def metres_per_pixel(camera: Camera, point: ArrayLike) -> float:
    """Size of a pixel at a world point, m."""
    return depth_of(camera, point) / camera.focal
