"""The photo on what is round about an axis: cans, bottles, pumpkins, logs.

Near its outline such a body is seen at too flat an angle: a few pixels would be drawn out over
much of it, and two such smears would meet at a seam. What is seen well is led around instead, on
either side from there back to the middle, so that it goes on without a seam to the far side.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.forms import Capsule, Cylinder, Frustum, Inflated, Revolved
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.switches import at_work

FloatArray = NDArray[np.float64]
SHOWN = math.radians(68.0)
"""Angle about the axis, from the view, within which the photo is shown as it is."""
WELL = math.cos(math.radians(70.0))
"""Cosine between surface and view from which it is so beyond that: on shoulders seen from above."""
SIDE = 0.3
"""How much of a normal points away from the axis on a side; caps and bottoms are no sides."""
BODY = 1.08
"""How far from the axis the body itself reaches at most, in its radii; beyond that are parts."""
DEEP = 0.6
"""How deep for its width what has no form of its own is, at least, to be taken for round."""
EVEN, BESIDE = 0.95, 0.06
"""Cosine between a flat end and the axis, at least, and how far beside the end its colour is looked
for, in the body's height."""
STEEP = math.sin(math.radians(20.0))
"""Sine of the angle between axis and view below which the view is along it."""


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
    if math.hypot(*eye[:2]) < STEEP * float(np.linalg.norm(eye)):
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
    beyond = np.abs(_azimuth(middle, front)) > SHOWN
    body = (away < BODY * np.interp(middle[:, 2], *profile)) & (
        (middle[:, 2] >= profile[0][0]) & (middle[:, 2] <= profile[0][-1])
    )
    chosen = body & (outward > SIDE) & beyond & (facing < WELL)
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
    level = end + side * BESIDE * (high - low)
    flat = (normal[:, 2] * -side > EVEN) & (
        np.abs(corners[..., 2] - end).max(1) < BESIDE * (high - low)
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
    back = SHOWN * (np.pi - np.abs(turn)) / (np.pi - SHOWN)
    led = front + np.where(np.abs(turn) > SHOWN, np.sign(turn) * back, turn)
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
        and min(shape.size[:2]) > DEEP * max(shape.size[:2])
    ):
        away = np.hypot(vertices[:, 0], vertices[:, 1])
        return np.array([vertices[:, 2].min(), vertices[:, 2].max()]), np.full(2, away.max())
    return None
