"""Primitives as the camera sees them: points whose hull is the silhouette."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray

_TURN = np.linspace(0, 2 * math.pi, 40, endpoint=False)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], 1)


def sphere_rim(eye: FloatArray, centre: FloatArray, radii: FloatArray) -> FloatArray:
    """Points (40, 3) of an ellipsoid's contour as seen from `eye`."""
    view = (eye - centre) / radii
    far = float(np.linalg.norm(view))
    if far <= 1.001:
        return centre + np.zeros((1, 3))
    axis = view / far
    helper = np.array([0.0, 0, 1]) if abs(axis[2]) < 0.9 else np.array([1.0, 0, 0])
    u = np.cross(axis, helper)
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    ring = math.sqrt(1 - 1 / far**2) * (_CIRCLE[:, :1] * u + _CIRCLE[:, 1:] * v)
    return centre + radii * (axis / far + ring)


def outline(kind: str, q: FloatArray, eye: FloatArray) -> FloatArray:
    """Points whose hull is the silhouette. q: x, y, z of the foot, log sizes, yaw of a box."""
    foot = q[:3]
    size = np.exp(np.minimum(q[3:6], 8))
    if kind == "sphere":
        return sphere_rim(eye, foot + np.array([0, 0, size[0]]), np.full(3, size[0]))
    if kind == "ellipsoid":
        return sphere_rim(eye, foot + np.array([0, 0, size[1]]), size[[0, 0, 1]])
    if kind == "capsule":
        radius, straight = size[0], size[1]
        low = foot + np.array([0, 0, radius])
        high = low + np.array([0, 0, straight])
        ball = np.full(3, radius)
        return np.vstack([sphere_rim(eye, low, ball), sphere_rim(eye, high, ball)])
    if kind in ("cylinder", "frustum"):
        top = size[2] if kind == "frustum" else size[0]
        rings = [
            np.column_stack([_CIRCLE * size[0], np.zeros(40)]),
            np.column_stack([_CIRCLE * top, np.full(40, size[1])]),
        ]
        return foot + np.vstack(rings)
    if kind == "bowl":
        rings = [
            np.column_stack([_CIRCLE * radius, np.full(40, rise)])
            for rise, radius in bowl_profile(size, float(q[6]), 6)
        ]
        return foot + np.vstack(rings)
    return foot + box_corners(size, q[6])


def bowl_profile(size: FloatArray, belly: float, rings: int) -> list[tuple[float, float]]:
    """(height, radius) from the foot to the rim of a bowl: foot radius, height, rim radius.

    belly: 0 for straight sides, 1 for those of an upright quarter of an ellipse.
    """
    foot, height, rim = (float(edge) for edge in size)
    power = 1 + min(max(belly, 0.0), 1.3)
    rise = 1 - np.cos(np.linspace(0, math.pi / 2, rings))
    bulge = (1 - (1 - rise) ** power) ** (1 / power)
    return [
        (float(height * r), float(foot + (rim - foot) * b))
        for r, b in zip(rise, bulge, strict=True)
    ]


def box_corners(size: FloatArray, yaw: float) -> FloatArray:
    """(8, 3) corners of a box over its foot's middle, the lower four around, then the upper ones.

    size: width, height, depth, m. yaw: rad.
    """
    width, height, depth = size
    cos, sin = math.cos(yaw), math.sin(yaw)
    flat = np.array([[-width, -depth], [width, -depth], [width, depth], [-width, depth]]) / 2
    turned = flat @ np.array([[cos, sin], [-sin, cos]])
    lower = np.column_stack([turned, np.zeros(4)])
    return np.vstack([lower, lower + np.array([0, 0, height])])


def faces_seen(q: FloatArray, eye: FloatArray) -> NDArray[np.bool_]:
    """(5,) which faces of a box look to the eye: the sides by their first corner, and the top."""
    width, height, depth = np.exp(np.minimum(q[3:6], 8))
    cos, sin = math.cos(q[6]), math.sin(q[6])
    x, y, z = eye - q[:3]
    along, across = cos * x + sin * y, cos * y - sin * x
    sides = [-across > depth / 2, along > width / 2, across > depth / 2, -along > width / 2]
    return np.array([*sides, z > height])
