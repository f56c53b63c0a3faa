"""Rotations: quaternions (w, x, y, z), matrices and Euler angles, in NumPy."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from physagent_studio.arrays import FloatArray

Quat = tuple[float, float, float, float]


def matrix_of(quaternion: Sequence[float]) -> FloatArray:
    """Rotation matrix (3, 3) of a unit quaternion wxyz."""
    w, x, y, z = (float(part) for part in quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def matrices_of(quaternions: ArrayLike) -> FloatArray:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4) wxyz."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions, float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def rotated(quaternions: ArrayLike, vectors: ArrayLike) -> FloatArray:
    """Vectors (..., 3) turned by unit quaternions (..., 4) wxyz."""
    turns, vectors = np.asarray(quaternions, float), np.asarray(vectors, float)
    axis = turns[..., 1:]
    twice = 2 * cross(axis, vectors)
    return vectors + turns[..., :1] * twice + cross(axis, twice)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross product of vectors (..., 3): `np.cross` without its checks."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], -1)


def quaternion_of(matrix: ArrayLike) -> Quat:
    """Unit quaternion wxyz, w ≥ 0, of a rotation matrix (3, 3) (Shepperd's method)."""
    m = np.asarray(matrix, float)
    diagonal = np.array([np.trace(m), m[0, 0], m[1, 1], m[2, 2]])
    largest = int(np.argmax(diagonal))
    if largest == 0:
        parts = np.array([1 + diagonal[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        parts = np.zeros(4)
        parts[0] = m[k, j] - m[j, k]
        parts[1 + i] = 1 + m[i, i] - m[j, j] - m[k, k]
        parts[1 + j] = m[i, j] + m[j, i]
        parts[1 + k] = m[i, k] + m[k, i]
    parts = parts / np.linalg.norm(parts)
    w, x, y, z = (float(part) for part in (parts if parts[0] >= 0 else -parts))
    return (w, x, y, z)


def multiply(first: Sequence[float], second: Sequence[float]) -> Quat:
    """The quaternion product: rotate by `second`, then by `first`."""
    a, b, c, d = first
    e, f, g, h = second
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def about_axis(axis: Sequence[float], angle: float) -> Quat:
    """Quaternion of a turn by `angle` radians about `axis` (right-hand rule)."""
    unit = np.asarray(axis, float) / np.linalg.norm(axis)
    x, y, z = unit * math.sin(angle / 2)
    return (math.cos(angle / 2), float(x), float(y), float(z))


def about_up(angle: float) -> Quat:
    """Quaternion of a turn by `angle` radians about +z, counter-clockwise from above."""
    return (math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2))


def angle_between(first: ArrayLike, second: ArrayLike) -> FloatArray:
    """Angle in radians between rotations given as unit quaternions (..., 4)."""
    dot = np.abs(np.sum(np.asarray(first, float) * np.asarray(second, float), axis=-1))
    return 2 * np.arccos(np.clip(dot, 0, 1))
