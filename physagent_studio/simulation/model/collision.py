"""What the engine collides: the outline of every geom, to be shown beside what is seen."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import matrix_of
from physagent_studio.records import Mesh
from physagent_studio.simulation.mj import Model, mj
from physagent_studio.simulation.model.model import Compiled, Handle
from physagent_studio.simulation.surfaces import FloatArray

ROUND, RINGS = 24, 7
"""Corners of a circle, and rings from pole to pole, of the outline of a round geom."""


def outlines(program: PhysicalProgram, compiled: Compiled) -> dict[str, tuple[Mesh, ...]]:
    """Convex outlines by name: of rigid objects in the body frame, of supports in the world, m.

    Planes have none, being endless; what deforms collides as it is drawn.
    """
    scene, model = program.scene, compiled.model
    names = [item.name for item in (*scene.objects, *scene.supports)]
    found: dict[str, list[Mesh]] = {}
    for geom in range(model.ngeom):
        index = int(compiled.geom_bodies[geom])
        rigid = index >= len(scene.objects) or isinstance(compiled.handles[index], Handle)
        points = _points(model, geom) if rigid and index < len(names) else None
        if points is None:
            continue
        points = points @ matrix_of(model.geom_quat[geom].tolist()).T + model.geom_pos[geom]
        if index >= len(scene.objects):
            body = model.geom_bodyid[geom]
            points = points @ matrix_of(model.body_quat[body].tolist()).T + model.body_pos[body]
        found.setdefault(names[index], []).append(_hull(points))
    return {name: tuple(meshes) for name, meshes in found.items()}


def _points(model: Model, geom: int) -> FloatArray | None:
    """(P, 3) m, geom frame: points whose convex hull is the geom; None for what has none."""
    kinds, size = mj.mjtGeom, np.asarray(model.geom_size[geom], float)
    kind = model.geom_type[geom]
    if kind == kinds.mjGEOM_BOX:
        return np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
    if kind == kinds.mjGEOM_SPHERE:
        return _ball() * size[0]
    if kind == kinds.mjGEOM_ELLIPSOID:
        return _ball() * size
    if kind == kinds.mjGEOM_CAPSULE:
        ball, shift = _ball() * size[0], np.array([0, 0, size[1]])
        return np.concatenate([ball[ball[:, 2] >= 0] + shift, ball[ball[:, 2] <= 0] - shift])
    if kind == kinds.mjGEOM_CYLINDER:
        ring, shift = _ring() * size[0], np.array([0, 0, size[1]])
        return np.concatenate([ring + shift, ring - shift])
    if kind == kinds.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        return np.asarray(model.mesh_vert[first : first + count], float)
    return None


def _ring() -> FloatArray:
    angle = np.arange(ROUND) * 2 * np.pi / ROUND
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(ROUND)], axis=1)


def _ball() -> FloatArray:
    heights = np.cos(np.linspace(0, np.pi, RINGS + 2)[1:-1])
    rings = [_ring() * [np.sqrt(1 - z * z), np.sqrt(1 - z * z), 1] + [0, 0, z] for z in heights]
    return np.concatenate([*rings, np.array([[0, 0, 1.0], [0, 0, -1.0]])])


def _hull(points: FloatArray) -> Mesh:
    hull = ConvexHull(points)
    used, faces = np.unique(hull.simplices, return_inverse=True)
    return Mesh(points[used], faces.reshape(-1, 3).astype(np.int32))
