"""Meshes of declared shapes, for programs that have no photo to take them from."""

from dataclasses import replace

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program import SceneObject, Support
from physagent_studio.program.scene import state as scene
from physagent_studio.reconstruction.shapes.meshes import mesh_of, support_mesh
from physagent_studio.records import Mesh

COLORS = (
    (79, 140, 201), (232, 138, 70), (98, 173, 106),
    (192, 102, 148), (140, 118, 196), (204, 170, 66),
)  # fmt: skip


def color_of(name: str) -> tuple[int, int, int]:
    """A colour that a name always has."""
    return COLORS[sum(name.encode()) % len(COLORS)]


def mesh_of_object(item: SceneObject) -> Mesh | None:
    """The mesh of an object's shape in the body frame, m; None where there is no shape."""
    shape = item.shape
    if isinstance(shape, scene.Inflated | scene.Meshed):
        shape = scene.Box(size=shape.size)
    return None if shape is None else replace(mesh_of(shape), color=color_of(item.name))


def mesh_of_support(item: Support) -> Mesh | None:
    """The mesh of a support in the world frame, m; None for floors, walls and open shapes."""
    shape = item.shape
    if isinstance(shape, scene.Vessel):
        # Its outline is that of the solid.
        solid = shape.body.model_copy(update={"wall": None})
        shape = shape.model_copy(update={"body": solid})
    if not isinstance(shape, scene.Slab | scene.Ramp | scene.Vessel):
        return None
    return replace(support_mesh(shape, 0.0), color=(150, 150, 150))


def edges_of(mesh: Mesh, angle: float = 25.0) -> FloatArray:
    """(E, 2, 3) segments where two faces meet at more than `angle` degrees, or only one is."""
    corners = np.unique(mesh.vertices.round(9), axis=0, return_inverse=True)
    points, index = corners[0], corners[1].reshape(-1)
    faces = index[mesh.faces]
    a, b, c = (points[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
    found: dict[tuple[int, int], list[int]] = {}
    for face, (i, j, k) in enumerate(faces):
        for edge in ((i, j), (j, k), (k, i)):
            found.setdefault((min(edge), max(edge)), []).append(face)
    limit = np.cos(np.radians(angle))
    sharp = [
        edge
        for edge, sides in found.items()
        if len(sides) != 2 or normals[sides[0]] @ normals[sides[1]] < limit
    ]
    if not sharp:
        return np.zeros((0, 2, 3))
    return points[np.array(sharp)]
