"""Sides of what is cut straight through: the rim of its front goes on back to its far side.

A side that is seen at a grazing angle shows a few pixels drawn out over all its depth; the rim of
the front, carried straight back, has the thing's own colours there.
"""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Inflated, SceneObject
from physagent_studio.reconstruction.shapes.inflation import standing_plane
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.scene import Mesh


def carried_back(
    camera: Camera, item: SceneObject, mask: BoolArray, mesh: Mesh
) -> tuple[BoolArray, BoolArray, FloatArray] | None:
    """Which faces (F,) are sides and which the far side, and where (V, 3) what they show is (body).

    That is what is in front of them. None for what is not cut straight through an upright outline.
    """
    shape = item.shape
    if not at_work("straight sides"):
        return None
    if not isinstance(shape, Inflated) or shape.flat or not shape.straight:
        return None
    normal, behind = standing_plane(mask, camera, shape.facing)
    depth = mesh.vertices @ normal / (normal @ behind)
    shown = mesh.vertices + (depth.min() - depth)[:, None] * behind
    eye = (np.asarray(camera.position) - np.asarray(item.position)) @ matrix_of(item.rotation)
    corners = mesh.vertices[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    view = eye - corners.mean(1)
    # sine, 0.05..0.5: of face and view, below which the photo tells little of it
    min_facing_sine = math.sin(math.radians(12.0))
    little = (across * view).sum(1) < min_facing_sine * np.linalg.norm(view, axis=1)
    # cosine, 0.2..0.9: of a face and the way back: from here it is the far side
    min_back_cosine = 0.5
    back = across @ normal > min_back_cosine
    return little & ~back, little & back, shown
