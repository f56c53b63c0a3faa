"""All conversions between frames of other programs and ours, in one place.

Ours: world x right, y away, z up; camera (OpenCV) x right, y down, z forward; quaternions wxyz;
column vectors. SAM 3D Objects: PyTorch3D camera, x left, y up, z forward, row vectors; its GLB
is y-up while its pose applies to the z-up local frame.
"""

import numpy as np
from numpy.typing import ArrayLike

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera

_CV_FROM_P3D = np.diag([-1.0, -1.0, 1.0])
_ZUP_FROM_YUP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
"""(x, y, z) of a y-up file → (x, −z, y)."""


def camera_from_sam3d(
    vertices: ArrayLike, rotation: ArrayLike, translation: ArrayLike, scale: ArrayLike
) -> FloatArray:
    """Vertices (V, 3) of a SAM 3D GLB → our camera frame.

    rotation: its quaternion wxyz, for row vectors, so that a column needs the transpose.
    translation: (3,). scale: a number or (3,), applied in the z-up local frame.
    """
    local = np.asarray(vertices, float) @ _ZUP_FROM_YUP.T * np.asarray(scale, float)
    turn = matrix_of(_unit(rotation)).T
    return (local @ turn.T + np.asarray(translation, float)) @ _CV_FROM_P3D.T


def world_from_camera(points: ArrayLike, camera: Camera) -> FloatArray:
    """Points (N, 3) of the camera frame in the world."""
    return np.asarray(points, float) @ camera.matrix.T + np.asarray(camera.position)


def zup_from_yup(points: ArrayLike) -> FloatArray:
    """Points (N, 3) of a y-up file (glTF) in a z-up frame: its front (+z) looks at −y."""
    return np.asarray(points, float) @ _ZUP_FROM_YUP.T


def _unit(quaternion: ArrayLike) -> tuple[float, float, float, float]:
    q = np.asarray(quaternion, float)
    w, x, y, z = (float(v) for v in q / np.linalg.norm(q))
    return (w, x, y, z)
