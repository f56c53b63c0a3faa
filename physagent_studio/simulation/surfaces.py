"""Closed triangle surfaces of shapes, and exact mass properties of any closed surface.

A surface is a pair (vertices (V, 3) float64 m, faces (F, 3) int32, counter-clockwise seen from
outside), in the body frame.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from physagent_studio.arrays import FloatArray
from physagent_studio.errors import SimulationError

IntArray = NDArray[np.int32]
Surface = tuple[FloatArray, IntArray]

SEGMENTS = 40
"""Corners of a circle where a round thing has to be a mesh."""


@dataclass(frozen=True, eq=False, slots=True)
class MassProperties:
    """volume: m³. centre: (3,) m, body frame. inertia: (3, 3) m⁵, about the centre, density 1."""

    volume: float
    centre: FloatArray
    inertia: FloatArray


def mass_properties(surface: Surface) -> MassProperties:
    """Volume, centroid and inertia of the solid inside a closed surface.

    Exact for polyhedra: sums signed tetrahedra from the origin (Tonon 2004).
    """
    vertices, faces = surface
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    volume = float(volumes.sum())
    if volume < 1e-15:
        return MassProperties(volume, np.zeros(3), np.zeros((3, 3)))
    centre = (volumes[:, None] * (a + b + c)).sum(0) / 4 / volume
    total = a + b + c
    # Second moments of a tetrahedron with one corner at the origin.
    second = sum(np.einsum("i,ij,ik->jk", volumes, p, p) for p in (a, b, c, total)) / 20
    central = second - volume * np.outer(centre, centre)
    return MassProperties(volume, centre, np.trace(central) * np.eye(3) - central)


def together(parts: Sequence[MassProperties]) -> MassProperties:
    """Several bodies as one (parallel axes)."""
    volume = sum(part.volume for part in parts)
    centre = np.sum([part.volume * part.centre for part in parts], axis=0) / volume
    inertia = np.zeros((3, 3))
    for part in parts:
        away = part.centre - centre
        inertia += part.inertia
        inertia += part.volume * (away @ away * np.eye(3) - np.outer(away, away))
    return MassProperties(volume, centre, inertia)


def is_closed(surface: Surface) -> bool:
    """Whether every edge is used by exactly one face in each direction."""
    faces = surface[1].astype(np.int64)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    count = int(faces.max()) + 1
    forth = np.sort(edges[:, 0] * count + edges[:, 1])
    back = np.sort(edges[:, 1] * count + edges[:, 0])
    return bool(np.array_equal(forth, back) and (np.diff(forth) > 0).all())


def welded(surface: Surface) -> Surface:
    """The surface with vertices at the same place made one, as before it was cut for a texture."""
    vertices, faces = surface
    places, index = np.unique(vertices, axis=0, return_inverse=True)
    joined = index.reshape(-1)[faces].astype(np.int32)
    a, b, c = joined.T
    return places, np.ascontiguousarray(joined[(a != b) & (b != c) & (c != a)])


def hull(points: FloatArray, what: str) -> Surface:
    """The convex hull of points (N, 3), with faces turned outwards.

    Raises SimulationError that names `what` where the points span no volume.
    """
    try:
        result = ConvexHull(points)
    except (QhullError, ValueError) as error:
        raise SimulationError(f"{what}: its mesh encloses no volume") from error
    used = result.vertices
    index = np.full(len(points), -1, np.int32)
    index[used] = np.arange(len(used), dtype=np.int32)
    vertices = np.ascontiguousarray(points[used], float)
    faces = index[result.simplices]
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), result.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return vertices, faces


def prism(outline: FloatArray, width: float) -> FloatArray:
    """Corners (2N, 3) of an outline (N, 2) in (x, z), extruded by `width` along y about y = 0."""
    front = np.column_stack([outline[:, 0], np.full(len(outline), -width / 2), outline[:, 1]])
    return np.concatenate([front, front + np.array([0.0, width, 0.0])])


def revolve(profile: FloatArray, segments: int = SEGMENTS) -> Surface:
    """The closed surface that a profile (N, 2) of (z, radius) sweeps about z.

    The profile runs so that the solid lies on its left in the (radius, z) plane: from the
    bottom up the outside and, for a hollow vessel, down the inside. Ends off the axis are capped
    by discs.
    """
    rows = [(float(z), max(float(r), 0.0)) for z, r in profile]
    if rows[0][1] > 0:
        rows.insert(0, (rows[0][0], 0.0))
    if rows[-1][1] > 0:
        rows.append((rows[-1][0], 0.0))
    angles = np.arange(segments) * (2 * math.pi / segments)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    blocks: list[FloatArray] = []
    rings: list[IntArray] = []
    count = 0
    for z, radius in rows:
        size = segments if radius > 1e-9 else 1
        xy = circle * radius if size > 1 else np.zeros((1, 2))
        blocks.append(np.column_stack([xy, np.full(size, z)]))
        rings.append(np.resize(np.arange(count, count + size, dtype=np.int32), segments))
        count += size
    faces = [_band(low, high) for low, high in pairwise(rings)]
    return np.concatenate(blocks), np.concatenate(faces)


def _band(low: IntArray, high: IntArray) -> IntArray:
    """Faces between two rings of equal length; a ring at the axis repeats one index."""
    after_low, after_high = np.roll(low, -1), np.roll(high, -1)
    faces = np.concatenate(
        [
            np.column_stack([low, after_low, after_high]),
            np.column_stack([low, after_high, high]),
        ]
    ).astype(np.int32)
    distinct = (
        (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2])
    )
    return faces[distinct]


def box_surface(size: tuple[float, float, float]) -> Surface:
    """A box about the origin with full edge lengths `size`."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    return hull(corners * np.asarray(size) / 2, "box")


def ellipsoid_surface(radii: tuple[float, float, float], segments: int = 24) -> Surface:
    """An ellipsoid about the origin with half-axes `radii`."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, segments // 2 + 1)
    profile = np.column_stack([np.sin(angles), np.abs(np.cos(angles))])
    profile[[0, -1], 1] = 0
    vertices, faces = revolve(profile, segments)
    return vertices * np.asarray(radii), faces
