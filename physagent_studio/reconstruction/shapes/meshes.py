"""Triangle meshes of every shape, in the body frame (origin at the centre of mass), m.

Faces are counter-clockwise seen from outside and fine enough to carry a projected photograph.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.errors import InputError
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene.boards import Size3, open_box, rails_of
from physagent_studio.program.scene.shapes import frustum_centre
from physagent_studio.program.scene.stairs import treads_of
from physagent_studio.program.scene.state import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Floor,
    Frustum,
    Ramp,
    Revolved,
    Shape,
    Slab,
    Sphere,
    SupportShape,
    Torus,
    Vessel,
    Wall,
)
from physagent_studio.records.scene import Mesh

IntArray = NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class MeshingSettings:
    """How finely round bodies are divided."""

    around_count: int = 48  # 12..128: vertices about an axis: no corners are seen
    tube_count: int = 20  # 8..64: about the tube of a ring


MESHING = MeshingSettings()


def mesh_of(shape: Shape) -> Mesh:
    """The mesh of a shape that its numbers define alone.

    `Inflated` and `Meshed` need more than their numbers; see `inflation.inflated_mesh` and
    `Scene.meshes`. Raises InputError for these.
    """
    if isinstance(shape, Sphere):
        return _spheroid((shape.radius, shape.radius, shape.radius))
    if isinstance(shape, Ellipsoid):
        return _spheroid(shape.radii)
    if isinstance(shape, Box):
        return (
            box_mesh(shape.size)
            if shape.wall is None
            else _joined(open_box(shape.size, shape.wall))
        )
    if isinstance(shape, Cylinder):
        half = shape.height / 2
        return turned([(-half, shape.radius), (half, shape.radius)])
    if isinstance(shape, Capsule):
        return turned(capsule_profile(shape), smooth=True)
    if isinstance(shape, Torus):
        return _torus(shape)
    if isinstance(shape, Frustum):
        low = -frustum_centre(shape)
        ends = [(low, shape.bottom_radius), (low + shape.height, shape.top_radius)]
        return turned(_hollow(ends, shape.wall))
    if isinstance(shape, Revolved):
        return turned(_hollow(list(shape.profile), shape.wall))
    raise InputError(
        f"a shape of kind '{shape.kind}' has its mesh in the scene, not in its numbers"
    )


def _hollow(outline: list[tuple[float, float]], wall: float | None) -> list[tuple[float, float]]:
    """The outline (z, radius), for a vessel followed by its inside from the rim to its floor."""
    if wall is None:
        return outline
    if outline[-1][0] < outline[0][0]:
        outline = outline[::-1]
    z, radius = np.array(outline).T
    floor = float(z[0]) + min(wall, 0.9 * float(z[-1] - z[0]))
    heights = [floor, *(float(h) for h in z[z > floor + 1e-9])]
    inner = [(h, max(float(np.interp(h, z, radius)) - wall, 1e-4)) for h in heights]
    return [*outline, *reversed(inner)]


def _joined(boxes: Iterable[tuple[Size3, Size3]], pieces: int = 10) -> Mesh:
    """Boxes (centre, edge lengths) as one mesh."""
    boards = [(box_mesh(edges, pieces), np.array(place)) for place, edges in boxes]
    return Mesh(*one_surface([(board.vertices + place, board.faces) for board, place in boards]))


def one_surface(
    parts: Sequence[tuple[FloatArray, NDArray[np.integer]]],
) -> tuple[FloatArray, IntArray]:
    """Vertices and faces of parts as those of one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [own + start for (_, own), start in zip(parts, starts, strict=False)]
    return np.vstack([own for own, _ in parts]), np.vstack(faces).astype(np.int32)


def capsule_profile(shape: Capsule) -> list[tuple[float, float]]:
    """(z, radius) of a capsule from bottom to top, z from its middle."""
    straight = max(shape.height / 2 - shape.radius, 0.0)
    turns = np.linspace(-math.pi / 2, 0, 13)
    low = [(-straight + shape.radius * math.sin(t), shape.radius * math.cos(t)) for t in turns]
    return low + [(-z, r) for z, r in reversed(low)]


def profile_centre(profile: list[tuple[float, float]]) -> float:
    """z of the centre of mass of a solid of revolution made of frusta."""
    volume = moment = 0.0
    for (z0, a), (z1, b) in pairwise(profile):
        height = z1 - z0
        part = height * (a * a + a * b + b * b) / 3
        if abs(part) < 1e-18:
            continue
        centre = height / 4 * (a * a + 2 * a * b + 3 * b * b) / (a * a + a * b + b * b)
        volume += part
        moment += part * (z0 + centre)
    return moment / volume if volume > 0 else (profile[0][0] + profile[-1][0]) / 2


def _spheroid(radii: tuple[float, float, float]) -> Mesh:
    turns = np.linspace(-math.pi / 2, math.pi / 2, 33)
    unit = turned([(math.sin(t), max(math.cos(t), 0.0)) for t in turns], smooth=True)
    return Mesh(unit.vertices * np.array(radii), unit.faces)


def _torus(shape: Torus) -> Mesh:
    around = np.arange(MESHING.around_count) * 2 * math.pi / MESHING.around_count
    along = np.arange(MESHING.tube_count) * 2 * math.pi / MESHING.tube_count
    reach = shape.radius + min(shape.tube, shape.radius) * np.cos(along)
    rise = min(shape.tube, shape.radius) * np.sin(along)
    vertices = np.stack(
        [
            np.cos(around)[:, None] * reach,
            np.sin(around)[:, None] * reach,
            np.broadcast_to(rise, (MESHING.around_count, MESHING.tube_count)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    k = np.arange(MESHING.around_count * MESHING.tube_count).reshape(
        MESHING.around_count, MESHING.tube_count
    )
    a, b = k, np.roll(k, -1, axis=0)
    c, d = np.roll(b, -1, axis=1), np.roll(k, -1, axis=1)
    quads = [np.stack([a, b, c], -1), np.stack([a, c, d], -1)]
    return Mesh(vertices, np.concatenate(quads).reshape(-1, 3).astype(np.int32))


def turned(profile: list[tuple[float, float]], *, smooth: bool = False) -> Mesh:
    """A closed surface of revolution about z; `profile` is (z, radius) from bottom to top.

    Long straight parts and flat ends are divided, unless `smooth` says it is fine as it is.
    """
    rings = [(float(z), float(r)) for z, r in profile]
    if not smooth:
        rings = _divided(rings)
    scale = max(max(r for _, r in rings), 1e-9)
    inner = [(z, r) for z, r in rings if r > 1e-6 * scale]
    angle = np.arange(MESHING.around_count) * 2 * math.pi / MESHING.around_count
    circle = np.stack([np.cos(angle), np.sin(angle)], 1)
    parts = [np.column_stack([circle * r, np.full(MESHING.around_count, z)]) for z, r in inner]
    bottom, top = MESHING.around_count * len(inner), MESHING.around_count * len(inner) + 1
    poles = np.array([[0, 0, rings[0][0]], [0, 0, rings[-1][0]]])
    here = np.arange(MESHING.around_count)
    after = (here + 1) % MESHING.around_count
    faces = [np.stack([np.full(MESHING.around_count, bottom), after, here], 1)]
    for k in range(len(inner) - 1):
        low, high = k * MESHING.around_count, (k + 1) * MESHING.around_count
        faces.append(np.stack([low + here, low + after, high + after], 1))
        faces.append(np.stack([low + here, high + after, high + here], 1))
    last = (len(inner) - 1) * MESHING.around_count
    faces.append(np.stack([np.full(MESHING.around_count, top), last + here, last + after], 1))
    return Mesh(np.vstack([*parts, poles]), np.vstack(faces).astype(np.int32))


def _divided(rings: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """More rings on long straight parts, and on the flat discs at both ends."""
    low, high = rings[0], rings[-1]
    full = [(low[0], 0.0)] if low[1] > 0 else []
    full += rings
    full += [(high[0], 0.0)] if high[1] > 0 else []
    length = sum(math.dist(a, b) for a, b in pairwise(full))
    out: list[tuple[float, float]] = [full[0]]
    for a, b in pairwise(full):
        pieces = max(1, min(16, round(28 * math.dist(a, b) / max(length, 1e-12))))
        out += [
            (a[0] + (b[0] - a[0]) * k / pieces, a[1] + (b[1] - a[1]) * k / pieces)
            for k in range(1, pieces + 1)
        ]
    return out


def box_mesh(size: ArrayLike, pieces: int = 10) -> Mesh:
    """A box of the given edge lengths about the origin, each side cut into pieces²."""
    half = np.asarray(size, float) / 2
    steps = np.linspace(-1, 1, pieces + 1)
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    k = np.arange((pieces + 1) ** 2).reshape(pieces + 1, pieces + 1)
    a, b, c, d = (part.ravel() for part in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    quad = np.vstack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    vertices, faces = [], []
    for axis in range(3):
        for sign in (1.0, -1.0):
            side = np.zeros((len(u), 3))
            side[:, axis] = sign
            side[:, (axis + 1) % 3], side[:, (axis + 2) % 3] = u, v
            offset = len(u) * len(vertices)
            vertices.append(side * half)
            faces.append((quad if sign > 0 else quad[:, ::-1]) + offset)
    return Mesh(np.vstack(vertices), np.vstack(faces).astype(np.int32))


# --- supports, in the world frame ---------------------------------------------------------------


def support_mesh(shape: SupportShape, reach: float) -> Mesh:
    """A mesh to look at, world frame; half-spaces are drawn as squares of half-width `reach`."""
    makers: dict[type, Callable[..., Mesh]] = {Floor: _floor, Wall: _wall}
    if isinstance(shape, Slab):
        return _set_down(_joined(rails_of(shape), pieces=1), shape.yaw, shape.position)
    if isinstance(shape, Ramp):
        return _stairs(shape) if shape.steps else _wedge(shape)
    if isinstance(shape, Vessel):
        return _set_down(mesh_of(shape.body), shape.yaw, shape.position)
    return makers[type(shape)](shape, reach)


def _set_down(mesh: Mesh, yaw: float, place: Size3) -> Mesh:
    """A mesh at its place in the world, turned about +z."""
    return Mesh(mesh.vertices @ matrix_of(about_up(yaw)).T + np.array(place), mesh.faces)


def _floor(shape: Floor, reach: float) -> Mesh:
    z = shape.height
    corners = [[-reach, -reach, z], [reach, -reach, z], [reach, reach, z], [-reach, reach, z]]
    return Mesh(np.array(corners, float), np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def _wall(shape: Wall, reach: float) -> Mesh:
    along = np.array([-math.sin(shape.yaw), math.cos(shape.yaw), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    base = np.array([shape.point[0], shape.point[1], 0.0])
    corners = [base - reach * along, base + reach * along]
    corners += [corner + reach * up for corner in reversed(corners)]
    return Mesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def ramp_corners(shape: Ramp) -> FloatArray:
    """World corners (2, K, 3): both sides of the wedge's profile, from the toe along the base."""
    ahead = np.array([math.cos(shape.yaw), math.sin(shape.yaw), 0.0])
    side = np.array([-math.sin(shape.yaw), math.cos(shape.yaw), 0.0]) * shape.width / 2
    length = shape.run + shape.plateau
    profile = [(0.0, 0.0), (length, 0.0), (length, shape.rise)]
    if shape.plateau > 0:
        profile.append((shape.run, shape.rise))
    middle = [np.array(shape.toe) + a * ahead + np.array([0, 0, h]) for a, h in profile]
    return np.array([[point - side for point in middle], [point + side for point in middle]])


def _stairs(shape: Ramp) -> Mesh:
    blocks, below, treads = [], 0.0, treads_of(shape)
    for tread in treads:
        back = treads[-1].end
        size = (back - tread.start, shape.width, tread.top - below)
        blocks.append((((back + tread.start) / 2, 0.0, (tread.top + below) / 2), size))
        below = tread.top
    return _set_down(_joined(blocks, pieces=1), shape.yaw, shape.toe)


def _wedge(shape: Ramp) -> Mesh:
    corners = ramp_corners(shape)
    count = corners.shape[1]
    faces = [(0, k, k + 1) for k in range(1, count - 1)]
    faces += [(count, count + k + 1, count + k) for k in range(1, count - 1)]
    for k in range(count):
        a, b = k, (k + 1) % count
        faces += [(a, count + a, count + b), (a, count + b, b)]
    return Mesh(corners.reshape(-1, 3), np.array(faces, np.int32))


def volume_and_centre(vertices: FloatArray, faces: IntArray) -> tuple[float, FloatArray]:
    """Signed volume (m³) and centre of mass (3,) of a closed mesh."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    total = float(parts.sum())
    if abs(total) < 1e-15:
        return total, vertices.mean(0)
    return total, (parts[:, None] * (a + b + c) / 4).sum(0) / total
