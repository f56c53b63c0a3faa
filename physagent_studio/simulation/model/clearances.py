"""How far apart things are at least, by spheres around objects and planes around supports.

Lower bounds only, from a structure that is compiled once: they tell for how long nothing new can
meet, see `calm`. Plain numbers rather than arrays: most scenes have a handful of things, and a
look at them costs less than the first array operation.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.program.rotations import matrix_of
from physagent_studio.simulation.mj import Data, Model, mj
from physagent_studio.simulation.surfaces import FloatArray, IntArray

MANY_FACES = 60
"""Faces from which on the hull of a support counts as its bounding box."""

Plane = tuple[float, float, float, float]
Sphere = tuple[float, float, float, float, float]
"""About an object: its middle and radius, m, and a speed that no point of it exceeds, m/s."""


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
    """All meetings, and the objects: addresses in `qpos` and `qvel`, radius and lever.

    radius: m, of a sphere about the body's origin that holds the object. lever: m, how far to the
    side of the origin the object's utmost point in any direction can be: 0 for a sphere. between:
    the contact pairs of two objects.
    """

    objects: tuple[tuple[int, int, float, float], ...]
    meetings: tuple[Meeting, ...]
    between: frozenset[int]

    def spheres(self, places: list[float], rates: list[float]) -> list[Sphere]:
        """Of each object. places: `qpos`. rates: `qvel`."""
        found = []
        for at, to, radius, _ in self.objects:
            x, y, z, a, b, c = rates[to : to + 6]
            speed = math.sqrt(x * x + y * y + z * z) + radius * math.sqrt(a * a + b * b + c * c)
            x, y, z = places[at : at + 3]
            found.append((x, y, z, radius, speed))
        return found

    def rocks(self, engaged: frozenset[int], rates: list[float], limit: float) -> bool:
        """Whether a point of something that touches could come back faster than `limit`, m/s.

        A can may hop and land within a hundredth of a second, a ball cannot. rates: `qvel`.
        """
        spins = []
        for _, at, _, lever in self.objects:
            a, b, c = rates[at + 3 : at + 6]
            spins.append(lever * (a * a + b * b + c * c) ** 0.5)
        if not engaged or 2 * max(spins) <= limit:
            return False
        return any(
            spins[item.one] + (spins[item.other] if item.other >= 0 else 0.0) > limit
            for item in self.meetings
            if not item.pairs.isdisjoint(engaged)
        )

    def approach(self, meeting: Meeting, rates: list[float], ends: list[float]) -> float:
        """m/s at which a plane between two bodies can be used up from both sides, not negative.

        rates: `qvel`. ends: the nearest points of the two, world, m: the plane stands across them.
        """
        x, y, z = ends[3] - ends[0], ends[4] - ends[1], ends[5] - ends[2]
        length = math.sqrt(x * x + y * y + z * z)
        if length < 1e-9:
            return math.inf
        _, at, _, lever = self.objects[meeting.one]
        u, v, w, a, b, c = rates[at : at + 6]
        turning = lever * math.sqrt(a * a + b * b + c * c)
        if meeting.other >= 0:
            _, at, _, lever = self.objects[meeting.other]
            i, j, k, a, b, c = rates[at : at + 6]
            u, v, w = u - i, v - j, w - k
            turning += lever * math.sqrt(a * a + b * b + c * c)
        # Which of the two ends is whose does not matter: they may come closer, or part.
        return abs(u * x + v * y + w * z) / length + turning


def reach_of(
    model: Model, data: Data, handles: Sequence[tuple[int, int]], geom_bodies: IntArray
) -> Reach:
    """handles: address in `qpos` and in `qvel` of each object, all rigid.

    geom_bodies: (ngeom,) index among objects-then-supports of each geom.
    """
    mj.mj_kinematics(model, data)
    count = len(handles)
    radii, inside = [0.0] * count, [0.0] * count
    bodies = geom_bodies.tolist()
    for geom, body in enumerate(bodies):
        if body < count:
            offset = float(np.linalg.norm(model.geom_pos[geom]))
            # About the origin, with room for rounding; of several geoms any one will do.
            radii[body] = max(radii[body], 1.001 * _outer(model, geom))
            inside[body] = max(inside[body], 0.999 * (_inner(model, geom) - offset))
    found: dict[tuple[int, int], list[int]] = {}
    ends = np.stack([model.pair_geom1, model.pair_geom2], 1).tolist()
    for pair, geoms in enumerate(ends):
        first, second = sorted(geoms, key=bodies.__getitem__)
        other = bodies[second]
        # A solid of a support stands for itself, objects are one sphere each.
        key = (bodies[first], other if other < count else count + second)
        found.setdefault(key, []).append(pair)
    meetings = []
    for (one, other), pairs in sorted(found.items()):
        planes = _planes(model, data, other - count) if other >= count else ()
        geoms = tuple((pair, *ends[pair]) for pair in pairs)
        other = other if other < count else -1
        meetings.append(Meeting(one, other, planes, frozenset(pairs), geoms))
    objects = [
        (*handle, radius, math.sqrt(max(radius * radius - inner * inner, 0.0)))
        for handle, radius, inner in zip(handles, radii, inside, strict=True)
    ]
    between = frozenset[int]().union(*(item.pairs for item in meetings if item.other >= 0))
    return Reach(tuple(objects), tuple(meetings), between)


def _outer(model: Model, geom: int) -> float:
    """m: radius of a sphere about the body's origin that holds the geom."""
    bound = float(np.linalg.norm(model.geom_pos[geom]) + model.geom_rbound[geom])
    if model.geom_type[geom] != mj.mjtGeom.mjGEOM_MESH:
        return bound
    # The engine's own bound is half the diagonal of a box.
    mesh = int(model.geom_dataid[geom])
    start, size = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    corners = np.array(model.mesh_vert[start : start + size], float)
    corners = corners @ matrix_of(model.geom_quat[geom].tolist()).T + model.geom_pos[geom]
    return min(bound, float(np.linalg.norm(corners, axis=1).max()))


def _inner(model: Model, geom: int) -> float:
    """m: radius of a sphere about the geom's middle that lies within it."""
    kind, size = model.geom_type[geom], model.geom_size[geom]
    shapes = mj.mjtGeom
    if kind == shapes.mjGEOM_MESH:
        return max(float(_faces(model, int(model.geom_dataid[geom]))[1].min()), 0.0)
    if kind in (shapes.mjGEOM_SPHERE, shapes.mjGEOM_CAPSULE):
        return float(size[0])
    return float(size[:2].min() if kind == shapes.mjGEOM_CYLINDER else size.min())


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
