"""`Batch`: all meshes of a scene in one set of arrays, so that a frame is a few NumPy calls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.rotations import matrices_of
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.raster import FloatArray, IntArray

_CREASE = np.cos(np.radians(40))
_TORN, _CRACK = 3.0, 0.05
"""How many times its length a face may be drawn out, and the part of the thing's own size below
which no gap is seen."""
_CASTER_FACES = 500
_CASTER_CELLS = 12


@dataclass(frozen=True, eq=False, slots=True)
class Caster:
    """What an object's shadow is cast from: rows (K,) of the batch's vertices, faces over them.

    closed: whether it encloses a space, so that its far faces alone cast all of its shadow.
    """

    rows: IntArray
    faces: IntArray
    closed: bool


@dataclass(frozen=True, eq=False, slots=True)
class Edges:
    """The unique edges of all meshes, and which faces meet there, in the order of the objects.

    ends: (E, 2) vertex rows. face, sign: (E, M), M the most faces at one edge; sign is +1 where
    the face runs along the edge as stored, −1 against it, 0 for none. owner: (E,) object.
    """

    ends: IntArray
    face: IntArray
    sign: NDArray[np.int8]
    owner: IntArray


@dataclass(frozen=True, eq=False, slots=True)
class Batch:
    """Concatenated meshes.

    vertices: (V, 3) body frame, m. normals: (F, 3, 3) unit, of each face's corners, smooth but
    for creases. faces: (F, 3). uv: (V, 2) pixels of the object's texture. owner, face_owner:
    object of each vertex and face. first: (N + 1,) where each object's vertices start.
    one_sided: (F,) faces of closed meshes. welded: (F, 3) like faces, but with one row for all
    vertices of an object at the same place, which a texture's seam tells apart. casters: see
    `Caster`, per object.
    """

    vertices: FloatArray
    normals: FloatArray
    faces: IntArray
    uv: FloatArray
    owner: IntArray
    face_owner: IntArray
    first: IntArray
    one_sided: NDArray[np.bool_]
    edges: Edges
    welded: IntArray
    casters: tuple[Caster, ...]

    @classmethod
    def of(cls, meshes: Sequence[Mesh]) -> Batch:
        """Concatenate meshes in order."""
        counts = [len(mesh.vertices) for mesh in meshes]
        first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        faces = [
            np.asarray(m.faces, np.int32) + start for m, start in zip(meshes, first, strict=False)
        ]
        joined = _stack(faces, 3, np.int32)
        face_owner = np.repeat(np.arange(len(meshes)), [len(f) for f in faces]).astype(np.int32)
        vertices = _stack([np.asarray(mesh.vertices, float) for mesh in meshes], 3, float)
        owner = np.repeat(np.arange(len(meshes)), counts).astype(np.int32)
        welded = _welded(vertices, owner)[joined]
        edges = _edges(welded, face_owner)
        closed = _closed(edges, len(meshes))
        return cls(
            vertices=vertices,
            normals=corner_normals(vertices, joined, welded),
            faces=joined,
            uv=_stack([_uv(mesh) for mesh in meshes], 2, float),
            owner=owner,
            face_owner=face_owner,
            first=first,
            one_sided=closed[face_owner],
            edges=edges,
            welded=welded,
            casters=_casters(vertices, faces, first, closed),
        )

    def placed(
        self,
        positions: FloatArray,
        rotations: FloatArray,
        deformed: Mapping[int, FloatArray] | None = None,
    ) -> FloatArray:
        """Vertices (V, 3) in the world: positions (N, 3) m, rotations (N, 4) wxyz.

        deformed: by object index, (V_i, 3) world vertices that take the place of the mesh.
        """
        world = np.empty_like(self.vertices)
        for index, (matrix, place) in enumerate(
            zip(matrices_of(rotations), positions, strict=True)
        ):
            own = slice(self.first[index], self.first[index + 1])
            if deformed and index in deformed:
                world[own] = deformed[index]
            else:
                np.matmul(self.vertices[own], matrix.T, out=world[own])
                world[own] += place
        return world

    def torn(self, world: FloatArray) -> NDArray[np.bool_]:
        """(F,) the faces that bridge what has come apart: drawn out to many times their length.

        world: (V, 3) vertices now, m.
        """
        longest = _longest(world, self.faces)
        before = _longest(self.vertices, self.faces)
        return longest > np.maximum(_TORN * before, _CRACK * self.radii[self.face_owner])

    @property
    def radii(self) -> FloatArray:
        """(N,) how far each object reaches from its origin, m."""
        radii = np.zeros(len(self.first) - 1)
        np.maximum.at(radii, self.owner, np.linalg.norm(self.vertices, axis=1))
        return radii


def _longest(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """(F,) longest edge of each face, m."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    edges = [np.linalg.norm(v, axis=1) for v in (b - a, c - b, a - c)]
    return np.max(edges, axis=0) if len(faces) else np.zeros(0)


def corner_normals(vertices: FloatArray, faces: IntArray, welded: IntArray) -> FloatArray:
    """Unit normals (F, 3, 3) of each face's corners.

    The mean, weighted by area, over the faces around the vertex that bend away by less than
    `_CREASE`, so that a ball is smooth and a box has edges. welded: see `Batch`.
    """
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    flat = np.cross(b - a, c - a)
    unit = _unit(flat)
    corner = np.argsort(welded.ravel(), kind="stable")
    vertex = welded.ravel()[corner]
    face = corner // 3
    unit, flat = unit[face], flat[face]
    total = np.zeros((faces.size, 3))
    # Corners of one vertex lie side by side after sorting: compare each with the next, the one
    # after that, and so on, as often as the busiest vertex needs.
    here = np.arange(len(corner))
    for shift in range(int(np.bincount(vertex).max(initial=0))):
        here = here[: np.searchsorted(here, len(corner) - shift)]
        here = here[vertex[here] == vertex[here + shift]]
        one = here[np.einsum("ij,ij->i", unit[here], unit[here + shift]) > _CREASE]
        total[one] += flat[one + shift]
        if shift:
            total[one + shift] += flat[one]
    out = np.empty_like(total)
    out[corner] = total
    return _unit(out.reshape(-1, 3, 3))


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def _stack(parts: Sequence[NDArray], width: int, dtype: type) -> NDArray:
    if not parts:
        return np.zeros((0, width), dtype)
    return np.concatenate(parts).astype(dtype).reshape(-1, width)


def _welded(vertices: FloatArray, owner: IntArray) -> IntArray:
    """(V,) the first row at the same place of the same object."""
    rows = np.column_stack([owner, vertices])
    _, first, group = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first[group.reshape(-1)].astype(np.int32)


def _uv(mesh: Mesh) -> FloatArray:
    if mesh.uv is None:
        return np.zeros((len(mesh.vertices), 2))
    return np.asarray(mesh.uv, float)


def _edges(faces: IntArray, face_owner: IntArray) -> Edges:
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    low, high = directed.min(1).astype(np.int64), directed.max(1).astype(np.int64)
    keys, edge, uses = np.unique(low * 2**32 + high, return_inverse=True, return_counts=True)
    ends = np.stack([keys >> 32, keys & 0xFFFFFFFF], 1).astype(np.int32)
    order = np.argsort(edge, kind="stable")
    row = edge[order]
    slot = np.arange(len(row)) - (np.cumsum(uses) - uses)[row]
    face = np.zeros((len(keys), max(int(uses.max(initial=0)), 1)), np.int32)
    sign = np.zeros(face.shape, np.int8)
    face[row, slot] = order % max(len(faces), 1)
    sign[row, slot] = np.where(directed[order, 0] < directed[order, 1], 1, -1)
    return Edges(ends, face, sign, face_owner[face[:, 0]])


def _closed(edges: Edges, count: int) -> NDArray[np.bool_]:
    """Which objects have every edge between two faces that run along it in opposite ways."""
    uses = np.abs(edges.sign).sum(1)
    balance = edges.sign.sum(1)
    bad = np.bincount(edges.owner[(uses % 2 == 1) | (balance != 0)], minlength=count)
    has_faces = np.bincount(edges.owner, minlength=count) > 0
    return has_faces & (bad[:count] == 0)


def _casters(
    vertices: FloatArray, faces: list[IntArray], first: IntArray, closed: NDArray[np.bool_]
) -> tuple[Caster, ...]:
    """A coarse copy of each mesh: vertices in one cell of a grid become one of them."""
    found = []
    for index, mine in enumerate(faces):
        local = mine - first[index]
        own = vertices[first[index] : first[index + 1]]
        if len(local) > _CASTER_FACES:
            cell = np.ptp(own, axis=0).max() / _CASTER_CELLS
            grid = np.floor((own - own.min(0)) / max(cell, 1e-12)).astype(np.int64)
            _, kept, group = np.unique(grid, axis=0, return_index=True, return_inverse=True)
            local = kept[group.reshape(-1)][local]
            a, b, c = local.T
            local = np.unique(local[(a != b) & (b != c) & (c != a)], axis=0)
        used, compact = np.unique(local, return_inverse=True)
        rows = (used + first[index]).astype(np.int32)
        found.append(Caster(rows, compact.reshape(-1, 3).astype(np.int32), bool(closed[index])))
    return tuple(found)
