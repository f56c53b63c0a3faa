"""How far apart things are at least, by spheres around objects and planes around supports.

Lower bounds only, from a structure that is compiled once: they tell for how long nothing new can
meet, see `calm`. Plain numbers rather than arrays: most scenes have a handful of things, and a
look at them costs less than the first array operation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.simulation.mj import Data, Model, mj
from physagent_studio.simulation.surfaces import FloatArray, IntArray

MANY_FACES = 60
"""Faces from which on the hull of a support counts as its bounding box."""

Plane = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Meeting:
    """An object and a solid that does not move, or two objects, that can meet.

    one, other: indices of objects; other is −1 for a solid, whose outward planes (unit normal and
    offset, world, m) are `planes`. pairs: the contact pairs between the two; geoms: their ends.
    """

    one: int
    other: int
    planes: tuple[Plane, ...]
    pairs: frozenset[int]
    geoms: tuple[tuple[int, int, int], ...]


@dataclass(frozen=True, slots=True)
class Reach:
    """All meetings, and the objects' addresses in `qpos` and `qvel` and their radii.

    radii: m, of a sphere about the body's origin that holds the object. between: the contact
    pairs of two objects.
    """

    objects: tuple[tuple[int, int, float], ...]
    meetings: tuple[Meeting, ...]
    between: frozenset[int]

    def speeds(self, rates: list[float]) -> list[float]:
        """m/s that no point of each object exceeds. rates: `qvel`."""
        found = []
        for _, at, radius in self.objects:
            x, y, z, a, b, c = rates[at : at + 6]
            found.append((x * x + y * y + z * z) ** 0.5 + radius * (a * a + b * b + c * c) ** 0.5)
        return found

    def gaps(self, places: list[float], engaged: frozenset[int]) -> Iterator[tuple[Meeting, float]]:
        """Every meeting that is not engaged, with a distance in m that is at least there.

        places: `qpos`. engaged: contact pairs that touch.
        """
        spheres = [(*places[at : at + 3], radius) for at, _, radius in self.objects]
        for meeting in self.meetings:
            if engaged and meeting.pairs <= engaged:
                continue
            x, y, z, radius = spheres[meeting.one]
            if meeting.other < 0:
                gap = -1e9
                for a, b, c, d in meeting.planes:
                    away = a * x + b * y + c * z - d
                    gap = away if away > gap else gap
            else:
                u, v, w, size = spheres[meeting.other]
                x, y, z = x - u, y - v, z - w
                gap = (x * x + y * y + z * z) ** 0.5 - size
            yield meeting, gap - radius


def reach_of(
    model: Model, data: Data, handles: Sequence[tuple[int, int]], geom_bodies: IntArray
) -> Reach:
    """handles: address in `qpos` and in `qvel` of each object, all rigid.

    geom_bodies: (ngeom,) index among objects-then-supports of each geom.
    """
    mj.mj_kinematics(model, data)
    count = len(handles)
    radii = [0.0] * count
    for geom, body in enumerate(geom_bodies.tolist()):
        if body < count:
            size = float(np.linalg.norm(model.geom_pos[geom]) + model.geom_rbound[geom])
            radii[body] = max(radii[body], size)
    found: dict[tuple[int, int], list[int]] = {}
    ends = np.stack([model.pair_geom1, model.pair_geom2], 1).tolist()
    for pair, geoms in enumerate(ends):
        first, second = sorted(geoms, key=lambda geom: geom_bodies[geom])
        other = int(geom_bodies[second])
        # A solid of a support stands for itself, objects are one sphere each.
        key = (int(geom_bodies[first]), other if other < count else count + second)
        found.setdefault(key, []).append(pair)
    meetings = []
    for (one, other), pairs in sorted(found.items()):
        planes = _planes(model, data, other - count) if other >= count else ()
        geoms = tuple((pair, *ends[pair]) for pair in pairs)
        other = other if other < count else -1
        meetings.append(Meeting(one, other, planes, frozenset(pairs), geoms))
    objects = [(*handle, radius) for handle, radius in zip(handles, radii, strict=True)]
    between = frozenset[int]().union(*(item.pairs for item in meetings if item.other >= 0))
    return Reach(tuple(objects), tuple(meetings), between)


def _planes(model: Model, data: Data, geom: int) -> tuple[Plane, ...]:
    """Outward planes, world, whose inside holds the geom."""
    turn, place = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
    if model.geom_type[geom] == mj.mjtGeom.mjGEOM_PLANE:
        normals, offsets = np.array([[0.0, 0.0, 1.0]]), np.zeros(1)
    else:
        mesh = int(model.geom_dataid[geom])
        few = mesh >= 0 and 0 < model.mesh_polynum[mesh] <= MANY_FACES
        normals, offsets = _faces(model, mesh) if few else _bounds(model, geom)
    normals = normals @ turn.T
    offsets = offsets + normals @ place
    return tuple((a, b, c, d) for a, b, c, d in np.column_stack([normals, offsets]).tolist())


def _faces(model: Model, mesh: int) -> tuple[FloatArray, FloatArray]:
    first, count = int(model.mesh_polyadr[mesh]), int(model.mesh_polynum[mesh])
    normals = np.array(model.mesh_polynormal[first : first + count], float).reshape(-1, 3)
    start, size = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    corners = np.array(model.mesh_vert[start : start + size], float)
    return normals, (corners @ normals.T).max(axis=0)


def _bounds(model: Model, geom: int) -> tuple[FloatArray, FloatArray]:
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    return normals, np.concatenate([centre + half, half - centre])
