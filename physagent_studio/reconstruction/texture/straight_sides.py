"""Sides of what is cut straight through: the rim of its front goes on back to its far side.

A side that is seen at a grazing angle shows a few pixels drawn out over all its depth; the rim of
the front, carried straight back, has the thing's own colours there. Upright sides show the front
folded around its edges instead, which draws nothing out to stripes.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from physagent_studio.arrays import BoolArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Inflated, SceneObject
from physagent_studio.reconstruction.shapes.inflation import standing_plane
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.reconstruction.texture.turned_prisms import Shown, folded_in
from physagent_studio.records.scene import Mesh


def cut_halfway(mask: BoolArray, camera: Camera, item: SceneObject, mesh: Mesh) -> Mesh:
    """The mesh with its sides cut halfway back, where what is folded around them meets."""
    if not _is_straight(item):
        return mesh
    assert isinstance(item.shape, Inflated)
    normal, _ = standing_plane(mask, camera, item.shape.facing)
    deep = mesh.vertices @ normal
    deep = deep - (deep.min() + deep.max()) / 2
    behind = deep[mesh.faces] > 0
    crossed = behind.any(1) & ~behind.all(1)
    # Beginning with the corner that is alone on its side.
    lone = np.where(behind.sum(1) == 1, behind.argmax(1), behind.argmin(1))[crossed]
    own = np.take_along_axis(mesh.faces[crossed], (lone[:, None] + np.arange(3)) % 3, 1)
    edges = np.sort(np.concatenate([own[:, [0, 1]], own[:, [0, 2]]]), axis=1)
    edges, place = np.unique(edges, axis=0, return_inverse=True)
    one, other = edges.T
    share = (deep[one] / (deep[one] - deep[other]))[:, None]
    added = mesh.vertices[one] + share * (mesh.vertices[other] - mesh.vertices[one])
    first, second = place.reshape(2, -1) + len(mesh.vertices)
    alone, left, right = own.T
    cut = [(alone, first, second), (first, left, right), (first, right, second)]
    faces = [mesh.faces[~crossed], *(np.stack(corners, 1) for corners in cut)]
    return replace(
        mesh,
        vertices=np.vstack([mesh.vertices, added]),
        faces=np.concatenate(faces).astype(np.int32),
    )


def _is_straight(item: SceneObject) -> bool:
    shape = item.shape
    return (
        at_work("straight sides")
        and isinstance(shape, Inflated)
        and not shape.flat
        and shape.straight
        and shape.turn is None
    )


def carried_back(
    camera: Camera, item: SceneObject, mask: BoolArray, mesh: Mesh
) -> tuple[Shown, Shown, Shown] | None:
    """Which faces are sides, which the far side and which upright sides, and what they show.

    That is what is in front of them, and for the last what is beside that. None for what is not cut
    straight through an upright outline.
    """
    if not _is_straight(item):
        return None
    assert isinstance(item.shape, Inflated)
    normal, behind = standing_plane(mask, camera, item.shape.facing)
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
    up = matrix_of(item.rotation)[2]
    beside = np.cross(up, normal)
    upright = little & ~back & (np.abs(across @ beside) > np.abs(across @ up))
    folded = shown + folded_in(mesh.vertices @ beside, depth - depth.min())[:, None] * beside
    return (little & ~back & ~upright, shown), (little & back, shown), (upright, folded)
