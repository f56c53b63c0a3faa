"""The photo on what is round about an axis: cans, bottles, pumpkins, logs.

Near its outline such a body is seen at too flat an angle: a few pixels would be drawn out over
much of it, and two such smears would meet at a seam. What is seen well is led around instead, on
either side from there back to the middle, so that it goes on without a seam to the far side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.forms import Capsule, Cylinder, Frustum, Inflated, Revolved
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.switches import at_work


@dataclass(frozen=True, slots=True)
class RevolvedSettings:
    """What of a body round about an axis the photo shows well."""

    # 0.8..1.5: about the axis, from the view, within which it shows as it is
    shown_rad: float = math.radians(68.0)
    # cosine, 0.1..0.7: of surface and view: so it does on shoulders seen from above
    min_facing_cosine: float = math.cos(math.radians(70.0))
    # cosine, 0.1..0.7: of a normal and the way out; caps and bottoms are no sides
    min_outward_cosine: float = 0.3
    body_ratio: float = 1.08  # 1..1.3: over the radius: beyond that are handles and other parts
    min_depth_ratio: float = 0.6  # 0.3..1: over the width, of what may be taken for round
    min_end_cosine: float = 0.95  # cosine, 0.8..1: of a flat end and the axis
    # 0.01..0.2: over the height: beside an end, where its colour is looked for
    beside_ratio: float = 0.06
    # sine, 0.1..0.7: of axis and view; below, the view is along the axis
    min_axis_sine: float = math.sin(math.radians(20.0))


REVOLVED = RevolvedSettings()


def turned_sides(
    camera: Camera, item: SceneObject, vertices: FloatArray, faces: NDArray[np.int32]
) -> tuple[BoolArray, FloatArray] | None:
    """Which faces (F,) show what is seen nearer to the middle, and where (V, 3) that is (body).

    None for bodies without an axis, or seen along it.
    """
    profile = _profile(item, vertices)
    if profile is None or not at_work("turned sides"):
        return None
    eye = (np.asarray(camera.position) - np.asarray(item.position)) @ matrix_of(item.rotation)
    if math.hypot(*eye[:2]) < REVOLVED.min_axis_sine * float(np.linalg.norm(eye)):
        return None
    front = math.atan2(eye[1], eye[0])
    corners = vertices[faces]
    middle = corners.mean(1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    away = np.hypot(middle[:, 0], middle[:, 1])
    outward = (normal[:, :2] * middle[:, :2]).sum(1) / np.maximum(away, 1e-12)
    view = eye - middle
    facing = (normal * view).sum(1) / np.maximum(np.linalg.norm(view, axis=1), 1e-12)
    beyond = np.abs(_azimuth(middle, front)) > REVOLVED.shown_rad
    body = (away < REVOLVED.body_ratio * np.interp(middle[:, 2], *profile)) & (
        (middle[:, 2] >= profile[0][0]) & (middle[:, 2] <= profile[0][-1])
    )
    chosen = (
        body
        & (outward > REVOLVED.min_outward_cosine)
        & beyond
        & (facing < REVOLVED.min_facing_cosine)
    )
    return chosen, _led_around(vertices, front)


def hidden_caps(
    camera: Camera, item: SceneObject, vertices: FloatArray, faces: NDArray[np.int32]
) -> tuple[BoolArray, FloatArray] | None:
    """Which faces (F,) are flat ends that are not seen, and the place (V, 3) on the side beside
    them whose colour they have all over (body). None for bodies without an axis."""
    profile = _profile(item, vertices)
    if profile is None or isinstance(item.shape, Inflated) or not at_work("hidden caps"):
        return None
    eye = (np.asarray(camera.position) - np.asarray(item.position)) @ matrix_of(item.rotation)
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    away = ((corners.mean(1) - eye) * normal).sum(1) > 0
    heights, radii = profile
    low, high = float(heights[0]), float(heights[-1])
    side = np.sign(eye[2] - (low + high) / 2)
    # The end that the camera does not look upon.
    end = low if side > 0 else high
    level = end + side * REVOLVED.beside_ratio * (high - low)
    flat = (normal[:, 2] * -side > REVOLVED.min_end_cosine) & (
        np.abs(corners[..., 2] - end).max(1) < REVOLVED.beside_ratio * (high - low)
    )
    front = eye[:2] / max(float(np.hypot(*eye[:2])), 1e-9) * np.interp(level, heights, radii)
    shown = np.tile(np.array([*front, level]), (len(vertices), 1))
    return away & flat, shown


def _azimuth(points: FloatArray, front: float) -> FloatArray:
    """(N,) angle about the axis from the view, −π … π."""
    turn = np.arctan2(points[:, 1], points[:, 0]) - front
    return (turn + np.pi) % (2 * np.pi) - np.pi


def _led_around(vertices: FloatArray, front: float) -> FloatArray:
    """Points (V, 3) of the body turned to where the same height is seen well."""
    turn = _azimuth(vertices, front)
    back = REVOLVED.shown_rad * (np.pi - np.abs(turn)) / (np.pi - REVOLVED.shown_rad)
    led = front + np.where(np.abs(turn) > REVOLVED.shown_rad, np.sign(turn) * back, turn)
    away = np.hypot(vertices[:, 0], vertices[:, 1])
    return np.stack([away * np.cos(led), away * np.sin(led), vertices[:, 2]], 1)


def _profile(item: SceneObject, vertices: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Heights on the axis and radii (K,) there, body frame; None without an axis."""
    shape = item.shape
    if isinstance(shape, Cylinder | Capsule):
        half = shape.height / 2
        return np.array([-half, half]), np.full(2, shape.radius)
    if isinstance(shape, Frustum):
        half = shape.height / 2
        return np.array([-half, half]), np.array([shape.bottom_radius, shape.top_radius])
    if isinstance(shape, Revolved):
        heights, radii = np.array(shape.profile, float).T
        return heights, radii
    if (
        isinstance(shape, Inflated)
        and not shape.flat
        and min(shape.size[:2]) > REVOLVED.min_depth_ratio * max(shape.size[:2])
    ):
        away = np.hypot(vertices[:, 0], vertices[:, 1])
        return np.array([vertices[:, 2].min(), vertices[:, 2].max()]), np.full(2, away.max())
    return None
