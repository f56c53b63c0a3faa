"""Meshes of declared shapes, for programs that have no photo to take them from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from trimesh.creation import box, capsule, cylinder, icosphere, revolve, torus

from physagent_studio.arrays import FloatArray
from physagent_studio.program import SceneObject, Support
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene import state as scene
from physagent_studio.program.scene.boards import Size3, rails_of
from physagent_studio.program.scene.stairs import treads_of
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
    made = _shape(item.shape)
    return None if made is None else _mesh(made, color_of(item.name))


def mesh_of_support(item: Support) -> Mesh | None:
    """The mesh of a support in the world frame, m; None for floors, walls and open shapes."""
    shape = item.shape
    if isinstance(shape, scene.Slab):
        made = _joined(rails_of(shape))
        turn, place = about_up(shape.yaw), np.array(shape.position)
    elif isinstance(shape, scene.Ramp):
        made = _wedge(shape)
        turn, place = about_up(shape.yaw), np.array(shape.toe)
    elif isinstance(shape, scene.Vessel):
        made = _shape(shape.body)
        turn, place = about_up(shape.yaw), np.array(shape.position)
    else:
        return None
    if made is None:
        return None
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = matrix_of(turn), place
    return _mesh(made.apply_transform(matrix), (150, 150, 150))


def _shape(shape: scene.Shape | None) -> trimesh.Trimesh | None:
    if isinstance(shape, scene.Sphere):
        return icosphere(subdivisions=3, radius=shape.radius)
    if isinstance(shape, scene.Ellipsoid):
        return icosphere(subdivisions=3, radius=1.0).apply_scale(shape.radii)
    if isinstance(shape, scene.Box | scene.Inflated | scene.Meshed):
        return box(extents=shape.size)
    if isinstance(shape, scene.Cylinder):
        return cylinder(radius=shape.radius, height=shape.height, sections=48)
    if isinstance(shape, scene.Capsule):
        middle = max(shape.height - 2 * shape.radius, 1e-6)
        made = capsule(radius=shape.radius, height=middle)
        return made.apply_translation(-made.bounds.mean(axis=0))
    if isinstance(shape, scene.Torus):
        return torus(shape.radius, min(shape.tube, shape.radius), 48, 20)
    if isinstance(shape, scene.Frustum):
        half = shape.height / 2
        return _turned(
            [(0, -half), (shape.bottom_radius, -half), (shape.top_radius, half), (0, half)]
        )
    if isinstance(shape, scene.Revolved):
        return _turned([(radius, z) for z, radius in shape.profile])
    return None


def _turned(profile: list[tuple[float, float]]) -> trimesh.Trimesh:
    return revolve(np.array(profile), sections=48)


def _wedge(shape: scene.Ramp) -> trimesh.Trimesh:
    if shape.steps:
        return _stairs(shape)
    half, run, rise, end = shape.width / 2, shape.run, shape.rise, shape.run + shape.plateau
    outline = [(0.0, 0.0), (run, rise), (end, rise), (end, 0.0)]
    if shape.plateau == 0:
        outline = [(0.0, 0.0), (run, rise), (run, 0.0)]
    points = [(x, side * half, z) for side in (-1, 1) for x, z in outline]
    return trimesh.Trimesh(np.array(points)).convex_hull


def _stairs(shape: scene.Ramp) -> trimesh.Trimesh:
    treads = treads_of(shape)
    back = treads[-1].end
    return _joined(
        [
            (
                ((back + tread.start) / 2, 0.0, tread.top / 2),
                (back - tread.start, shape.width, tread.top),
            )
            for tread in treads
        ]
    )


def _joined(boxes: Sequence[tuple[Size3, Size3]]) -> trimesh.Trimesh:
    """Boxes (centre, edge lengths) as one mesh."""
    parts = [box(extents=size).apply_translation(place) for place, size in boxes]
    vertices = np.concatenate([part.vertices for part in parts])
    counts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, counts, strict=False)]
    return trimesh.Trimesh(vertices, np.concatenate(faces), process=False)


def _mesh(made: trimesh.Trimesh, color: tuple[int, int, int]) -> Mesh:
    return Mesh(
        vertices=np.asarray(made.vertices, float),
        faces=np.asarray(made.faces, np.int32),
        color=color,
    )


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
