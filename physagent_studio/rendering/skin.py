"""The colours of objects: texture or flat colour, under the light of now."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.rotations import matrices_of
from physagent_studio.records.scene import Mesh, Shading
from physagent_studio.rendering.batch import Batch, corner_normals
from physagent_studio.rendering.light import lambert, relative
from physagent_studio.rendering.lit import Paint, lit
from physagent_studio.rendering.raster import FloatArray, Hits, Lens, between

_SAME = 1e-12
GRAIN, ROUGHEST = 8.0, 25.0
"""How many times coarser a texture is from which its grain is told, and the most that the grain
brightens or darkens, grey levels: more is a picture, a window's frame."""
_CELLS = 6
_NOISE = np.random.default_rng(0).normal(size=99991).astype(np.float32)
"""Noise for each of the cells along a face's edges; a crumb goes along with its own."""


@dataclass(frozen=True, eq=False, slots=True)
class Skin:
    """What objects look like. textured: (N,) which carry the photo.

    light: (3,) unit, towards the light. rotations: (N, 4) initial. cosine: (F, 3) between the
    light and each corner's normal at the initial pose. detail: (N,) texture pixels per screen
    pixel and metre of depth. shadings: (N,) the light that textures are without.
    """

    batch: Batch
    paints: tuple[Paint, ...]
    textured: NDArray[np.bool_]
    light: FloatArray
    rotations: FloatArray
    cosine: FloatArray
    detail: FloatArray
    shadings: tuple[Shading | None, ...]

    @classmethod
    def of(
        cls,
        batch: Batch,
        meshes: Sequence[Mesh],
        light: FloatArray,
        rotations: FloatArray,
        points: FloatArray,
        lens: Lens,
    ) -> Self:
        """Prepare. points: (V, 3) camera frame, initial pose."""
        paints = tuple(Paint.of(mesh) for mesh in meshes)
        textured = np.array([bool(paint.levels) for paint in paints], bool)
        cosine = _cosines(batch, rotations, light)
        detail = _detail(batch, points, lens)
        shadings = tuple(
            mesh.shading if paint.levels else None
            for mesh, paint in zip(meshes, paints, strict=True)
        )
        return cls(batch, paints, textured, light, rotations, cosine, detail, shadings)

    def colors(
        self, hits: Hits, rotations: FloatArray, bent: FloatArray | None
    ) -> NDArray[np.float32]:
        """Colours (K, 3) of what the pixels see, 0 … 255.

        bent: (V, 3) world vertices where something has deformed.
        """
        colors = self._lit(self._painted(hits), hits, rotations, bent)
        same = np.abs(rotations - self.rotations).max(initial=0) < _SAME
        if bent is None and same and self.textured.all():
            return colors
        bright = self._brightness(rotations, bent)
        shade = np.einsum("ki,ki->k", hits.weights, bright[hits.face])
        return np.clip(colors * shade[:, None], 0, 255).astype(np.float32)

    def grain(self, hits: Hits) -> NDArray[np.float32]:
        """Grey levels (K,) of the fine grain of the textures, and of noise as rough where a side
        that the photo does not show has none."""
        fine, coarse = self._painted(hits), self._painted(hits, GRAIN)
        own = np.clip((fine - coarse).mean(1), -ROUGHEST, ROUGHEST)
        seen = np.abs(own[own != 0])
        usual = float(np.median(seen)) if len(seen) else 0.0
        cell = (hits.weights[:, :2] * _CELLS).astype(np.int64) @ (1, _CELLS)
        return own + usual * _NOISE[(hits.face * _CELLS**2 + cell) % len(_NOISE)]

    def _painted(self, hits: Hits, coarser: float = 1.0) -> NDArray[np.float32]:
        colors = np.empty((len(hits.pixel), 3), np.float32)
        uv = between(hits, self.batch.uv, self.batch.faces)
        owner = self.batch.face_owner.astype(np.int16)[hits.face]
        order = np.argsort(owner, kind="stable")
        start = np.searchsorted(owner[order], np.arange(len(self.paints) + 1))
        for index, paint in enumerate(self.paints):
            mine = order[start[index] : start[index + 1]]
            if len(mine):
                shrink = self.detail[index] * float(hits.depth[mine].mean())
                colors[mine] = paint.sample(uv[mine], max(shrink, 1.0) * coarser)
        return colors

    def _lit(
        self,
        colors: NDArray[np.float32],
        hits: Hits,
        rotations: FloatArray,
        bent: FloatArray | None,
    ) -> NDArray[np.float32]:
        """The colours (K, 3), the photo's light put back on what is without it."""
        if not any(self.shadings):
            return colors
        owner = self.batch.face_owner[hits.face]
        batch, turned = self.batch, matrices_of(rotations)
        if bent is None:
            corners = batch.normals
        else:
            corners = corner_normals(bent, batch.faces, batch.welded)
            turned = np.tile(np.eye(3), (len(turned), 1, 1))
        for index, shading in enumerate(self.shadings):
            mine = np.flatnonzero(owner == index)
            if shading is None or not len(mine):
                continue
            normals = np.einsum("ki,kij->kj", hits.weights[mine], corners[hits.face[mine]])
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
            colors[mine] = lit(shading, colors[mine], normals @ turned[index].T)
        return colors

    def _brightness(self, rotations: FloatArray, bent: FloatArray | None) -> FloatArray:
        """Brightness (F, 3): the change since the photo, or all of it on flat colours."""
        if bent is None:
            cosine = _cosines(self.batch, rotations, self.light)
        else:
            normals = corner_normals(bent, self.batch.faces, self.batch.welded)
            cosine = normals @ self.light
        change = relative(cosine, self.cosine)
        full = np.minimum(lambert(cosine, 0.35) * 1.12, 1.15)
        known = np.array([shading is not None for shading in self.shadings], bool)
        change = np.where(known[self.batch.face_owner, None], 1.0, change)
        return np.where(self.textured[self.batch.face_owner, None], change, full)


def _cosines(batch: Batch, rotations: FloatArray, light: FloatArray) -> FloatArray:
    """(F, 3) cosine between each corner's normal and the light."""
    towards = np.einsum("nij,i->nj", matrices_of(rotations), light)
    return np.einsum("fcj,fj->fc", batch.normals, towards[batch.face_owner])


def _detail(batch: Batch, points: FloatArray, lens: Lens) -> FloatArray:
    count = len(batch.first) - 1
    result = np.zeros(count)
    if not len(batch.faces):
        return result
    z = np.maximum(points[:, 2], 1e-6)
    pixels = lens.focal * points[:, :2] / z[:, None]
    ratio = np.sqrt(_area(batch.uv, batch.faces) / np.maximum(_area(pixels, batch.faces), 1e-9))
    ratio /= z[batch.faces].mean(1)
    for index in range(count):
        mine = ratio[batch.face_owner == index]
        if len(mine):
            # Faces that look at the camera squarely; slanted ones would ask for too much blur.
            result[index] = np.percentile(mine, 25)
    return result


def _area(places: FloatArray, faces: NDArray[np.int32]) -> FloatArray:
    a, b, c = (places[faces[:, i]] for i in range(3))
    first, second = b - a, c - a
    return np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
