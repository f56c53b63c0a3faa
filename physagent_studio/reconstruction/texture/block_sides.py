"""Sides of a block that the photo does not show: each wears what its opposite side shows.

A cover is on both sides of a book, and a die's far sides look like its near ones; a mirror image
of the whole block would lay several sides over one another.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, SceneObject
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.scene import Mesh


def opposite_sides(
    camera: Camera, item: SceneObject, mesh: Mesh
) -> tuple[BoolArray, FloatArray] | None:
    """Which faces (F,) lie on sides that are not seen, and where (V, 3) what they show is (body).

    mesh: drawn of the item, its block's vertices first. None for others than solid blocks.
    """
    shape = item.shape
    if not isinstance(shape, Box) or shape.wall is not None or not at_work("opposite sides"):
        return None
    block = mesh_of(shape)
    places = block.vertices / (np.asarray(shape.size) / 2)
    # Which side a vertex belongs to is told by its faces: at an edge two sides meet.
    corners = places[block.faces]
    whole = np.abs(corners.mean(1)).argmax(1)
    sign = np.sign(corners.mean(1)[np.arange(len(whole)), whole])
    side = np.zeros((len(places), 2))
    side[block.faces.ravel()] = np.repeat(np.stack([whole, sign], 1), 3, axis=0)
    eye = (np.asarray(camera.position) - np.asarray(item.position)) @ matrix_of(item.rotation)
    # (3,) of each axis the sign of the side that looks at the eye, 0 for neither.
    facing = np.where(np.abs(eye) > np.asarray(shape.size) / 2, np.sign(eye), 0.0)
    chosen = np.zeros(len(mesh.faces), bool)
    shown = mesh.vertices.copy()
    # 0..0.2: of a side at its rim that is not copied: its neighbour shines through
    border_share = 0.06
    far_border_share = 0.2  # 0..0.5: the same, copied to other sides than the opposite one
    for axis in range(3):
        for way in (-1.0, 1.0):
            if facing[axis] == way:
                continue
            # Its own other side stands for one that is not seen, else the best seen one.
            source = axis if facing[axis] else int(np.abs(eye * facing).argmax())
            own = (side == (axis, way)).all(1)
            other = np.flatnonzero((side == (source, facing[source])).all(1))
            sought = places[own]
            sought[:, [axis, source]] = sought[:, [source, axis]]
            sought[:, source] = facing[source]
            if way * facing[source] * (1 if source == axis else -1) < 0:
                # What is written there reads as it does here, as turned around, not mirrored.
                sought[:, 1 if source == 0 else 0] *= -1
            near = KDTree(places[other]).query(sought)[1]
            drawn, border = (
                mesh.vertices[other],
                border_share if source == axis else far_border_share,
            )
            shown[np.flatnonzero(own)] = drawn[near] + border * (drawn.mean(0) - drawn[near])
            chosen[: len(block.faces)] |= (whole == axis) & (sign == way)
    return chosen, shown
