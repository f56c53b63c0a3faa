"""What a heap of grains looks like: its skin, which comes apart into crumbs where it is strained.

A skin that follows the grains is drawn out like cloth when they spread. So each of its faces has
corners of its own, and one that is strained keeps its size and goes where its grains went: sand
that runs is seen as many small pieces of sand, not as a sheet.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrices_of
from physagent_studio.records.scene import Mesh

STRAINED = 1.3
"""How many times longer or shorter than it was an edge is when its face comes loose."""
LONGEST, HALVINGS = 0.05, 16
"""Longest edge of a crumb, in the thing's own longest sides, and how often faces are halved."""
GROWN = 2.2
"""How many times its size a loose face may have, so that the heap does not show through it."""
TUMBLED = 0.35
"""Spread of the angle by which a loose face is tilted, rad: crumbs lie every way."""


@dataclass(frozen=True, eq=False, slots=True)
class Crumbs:
    """The crumbs of a skin of `count` vertices: pieces of its faces, none longer than `LONGEST`.

    corners: (F, 3) vertices of the face that each is a piece of. weights: (F, 3, 3) its corners
    in barycentric coordinates there. rest: (F, 3, 3) them at rest, m. tilts: (F, 3, 3) how each
    lies once it is loose, in its own frame.
    """

    corners: NDArray[np.int32]
    weights: FloatArray
    rest: FloatArray
    count: int
    tilts: FloatArray

    @classmethod
    def of(cls, mesh: Mesh) -> Self:
        """Prepared from the skin at rest."""
        vertices = np.asarray(mesh.vertices, float)
        corners = np.asarray(mesh.faces, np.int32)
        weights = np.tile(np.eye(3), (len(corners), 1, 1))
        longest = LONGEST * float(np.ptp(vertices, axis=0).max())
        for _ in range(HALVINGS):
            edges = _edges(weights @ vertices[corners])
            long = edges.max(1) > longest
            if not long.any():
                break
            halves = _halved(weights[long], edges[long].argmax(1))
            weights = np.concatenate([weights[~long], halves])
            corners = np.concatenate([corners[~long], corners[long], corners[long]])
        angles = np.random.default_rng(len(corners)).normal(0, TUMBLED, (len(corners), 2))
        half = np.column_stack([np.ones(len(corners)), angles / 2, np.zeros(len(corners))])
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        rest = weights @ vertices[corners]
        return cls(corners, weights, rest, len(vertices), matrices_of(half))

    def split(self, mesh: Mesh) -> Mesh:
        """The mesh of the crumbs at rest, each with corners of its own: 3 F vertices."""
        uv = mesh.uv
        if uv is not None:
            uv = (self.weights @ np.asarray(uv, float)[self.corners]).reshape(-1, 2)
        faces = np.arange(3 * len(self.corners), dtype=np.int32).reshape(-1, 3)
        return replace(mesh, vertices=self.rest.reshape(-1, 3), faces=faces, uv=uv)

    def loose(self, vertices: FloatArray) -> NDArray[np.bool_]:
        """(F,) which crumbs have come loose where the skin's vertices (V, 3) are now."""
        return self._loose(self._ratio(self.weights @ vertices[self.corners]))

    def placed(self, vertices: FloatArray) -> FloatArray:
        """(3 F, 3) the corners where the skin's vertices (V, 3) are now, any frame, m."""
        now = self.weights @ vertices[self.corners]
        ratio = self._ratio(now)
        loose = self._loose(ratio)
        if loose.any():
            own = self.rest[loose] - self.rest[loose].mean(1, keepdims=True)
            own *= np.clip(ratio[loose].max(1), 1.0, GROWN)[:, None, None]
            back = _frames(self.rest[loose]).transpose(0, 2, 1)
            turn = _frames(now[loose]) @ self.tilts[loose] @ back
            now[loose] = now[loose].mean(1, keepdims=True) + own @ turn.transpose(0, 2, 1)
        return now.reshape(-1, 3)

    def _ratio(self, now: FloatArray) -> FloatArray:
        return _edges(now) / np.maximum(_edges(self.rest), 1e-12)

    @staticmethod
    def _loose(ratio: FloatArray) -> NDArray[np.bool_]:
        longest, least = ratio.max(axis=1), ratio.min(axis=1)
        return (longest > STRAINED) | (least < 1 / STRAINED)


def _halved(weights: FloatArray, edge: NDArray[np.int64]) -> FloatArray:
    """(2 K, 3, 3) the halves of faces (K, 3, 3), cut from the middle of one edge (K,) each."""
    rows = np.arange(len(weights))
    a, b, c = (weights[rows, (edge + k) % 3] for k in range(3))
    middle = (a + b) / 2
    return np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])


def _edges(corners: FloatArray) -> FloatArray:
    """(F, 3) lengths of the edges of faces (F, 3, 3)."""
    return np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2)


def _frames(corners: FloatArray) -> FloatArray:
    """(F, 3, 3) an orthonormal frame in each face, as columns: along an edge, across, outwards."""
    along = _unit(corners[:, 1] - corners[:, 0], (1.0, 0.0, 0.0))
    outward = np.cross(along, corners[:, 2] - corners[:, 0])
    side = np.cross(np.eye(3)[np.abs(along).argmin(1)], along)
    flat = np.linalg.norm(outward, axis=1) < 1e-12
    outward = _unit(np.where(flat[:, None], side, outward), (0.0, 0.0, 1.0))
    return np.stack([along, np.cross(outward, along), outward], axis=2)


def _unit(vectors: FloatArray, otherwise: tuple[float, float, float]) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), otherwise)
