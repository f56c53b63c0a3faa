"""Soft shadows that objects cast on the floor and the supports.

Each object is seen from the light on a small square tile: whether it blocks the light there,
and how far along the light its lower surface lies. A point of the ground looks up its place on
the tile; the farther below the object it lies, the more blurred and the fainter the shadow, so
that it is dark and sharp at contact and fades as the object rises.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.raster import FloatArray, Lens, flat_facets, scan

_TILE = 64
_REACH = 2.0
"""A tile spans this many bounding radii to each side of its object."""
_BLUR = (0.8, 2.5, 6.0)
"""Standard deviations, in texels, of the three tiles between which softness is interpolated."""


@dataclass(frozen=True, eq=False, slots=True)
class Lamp:
    """A light that casts shadows. direction: (3,) unit, towards it, world.

    penumbra: blur per distance below the object, the tangent of half the angle that the light
    fills. reach: distance below the object, in its radii, over which its shadow fades to 1/e.
    """

    direction: FloatArray
    penumbra: float
    reach: float

    @property
    def axes(self) -> FloatArray:
        """(3, 3) rows: right, down and along the light, a right-handed frame."""
        along = -self.direction
        right = np.cross(along, (0.0, 1.0, 0.0))
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(along, right), along])


@dataclass(frozen=True, eq=False, slots=True)
class Ground:
    """The points that can receive a shadow, on a coarse grid of the picture.

    shape: (h, w) of the grid. step: pixels from one cell to the next. cells: (K,) flat cells
    that show the floor or a support. points: (K, 3) world, m.
    """

    shape: tuple[int, int]
    step: int
    cells: NDArray[np.int64]
    points: FloatArray

    def only(self, wanted: NDArray[np.bool_]) -> Ground:
        """Those cells that `wanted` (h, w) has."""
        keep = wanted.ravel()[self.cells]
        return Ground(self.shape, self.step, self.cells[keep], self.points[keep])


@dataclass(frozen=True, eq=False, slots=True)
class Shadows:
    """One lamp over one ground. places: (K, 3) the ground's points in the lamp's frame."""

    batch: Batch
    ground: Ground
    lamp: Lamp
    places: FloatArray = field(repr=False)

    @classmethod
    def of(cls, batch: Batch, ground: Ground, lamp: Lamp) -> Self:
        """Prepare a lamp."""
        return cls(batch, ground, lamp, ground.points @ lamp.axes.T)

    def blocked(self, world: FloatArray, weights: FloatArray) -> NDArray[np.float32]:
        """Share of the lamp's light (h, w) that objects keep from the ground, 0 … 1.

        world: (V, 3) vertices of all objects. weights: (N,) how much each object counts.
        """
        passing = np.ones(self.ground.shape[0] * self.ground.shape[1], np.float32)
        axes = self.lamp.axes
        for index in range(len(self.batch.first) - 1):
            points = world[self.batch.first[index] : self.batch.first[index + 1]]
            if len(points) and weights[index] > 0:
                cells, shade = self._shade(points @ axes.T, index)
                passing[cells] *= (1 - weights[index] * shade).astype(np.float32)
        return (1 - passing).reshape(self.ground.shape)

    def _shade(self, points: FloatArray, index: int) -> tuple[NDArray[np.int64], FloatArray]:
        """Cells near an object's shadow, and how much of the light it keeps from each."""
        low, high = points.min(0), points.max(0)
        centre = (low + high) / 2
        radius = float(max(high[0] - low[0], high[1] - low[1], 1e-6)) / 2
        texel = 2 * _REACH * radius / _TILE
        offset = self.places - centre
        near = np.flatnonzero(
            (np.abs(offset[:, 0]) < _REACH * radius)
            & (np.abs(offset[:, 1]) < _REACH * radius)
            & (offset[:, 2] > low[2] - centre[2])
        )
        if not len(near):
            return self.ground.cells[near], np.zeros(0)
        faces = self.batch.faces[self.batch.face_owner == index] - self.batch.first[index]
        layers, bottom = _tile((points - centre) / texel, faces)
        offset = offset[near] / texel
        at = offset[:, :2].astype(np.float32) + np.float32(_TILE / 2 - 0.5)
        gap = offset[:, 2] - _sample(bottom, at)
        shade = _soft(layers, at, np.maximum(gap, 0), self.lamp.penumbra)
        # Right at the surface that casts it, estimation noise must not switch the shadow off.
        shade *= np.clip(1 + gap / 3, 0, 1)
        shade *= np.exp(-np.maximum(gap, 0) * texel / (self.lamp.reach * radius))
        return self.ground.cells[near], shade


def _tile(points: FloatArray, faces: NDArray[np.int32]) -> tuple[list[NDArray], NDArray]:
    """Blurred masks and the depth of the lower surface, all (_TILE, _TILE), in texels."""
    lens = Lens(_TILE, _TILE, 1.0, _TILE / 2, _TILE / 2)
    prepared = flat_facets(points[:, :2], points[:, 2], faces, _TILE)
    pixel, _, depth = scan(prepared, lens)
    mask = np.zeros(_TILE * _TILE, np.float32)
    mask[pixel] = 1
    filled = np.zeros_like(mask)
    filled[pixel] = depth
    mask, filled = mask.reshape(_TILE, _TILE), filled.reshape(_TILE, _TILE)
    layers = [np.asarray(cv2.GaussianBlur(mask, (0, 0), sigma)) for sigma in _BLUR]
    wide = cv2.GaussianBlur(mask, (0, 0), 4.0)
    bottom = cv2.GaussianBlur(filled, (0, 0), 4.0) / np.maximum(wide, 1e-4)
    return layers, np.where(mask > 0, filled, bottom)


def _soft(
    layers: list[NDArray], at: NDArray[np.float32], gap: FloatArray, penumbra: float
) -> FloatArray:
    """Share of the light that is blocked (K,), blurred by the distance `gap` in texels."""
    sigma = _BLUR[0] + gap * penumbra
    place = np.interp(sigma, _BLUR, (0.0, 1.0, 2.0))
    values = np.stack([_sample(layer, at) for layer in layers])
    lower = np.minimum(place.astype(np.int64), 1)
    share = place - lower
    rows = np.arange(len(place))
    return values[lower, rows] * (1 - share) + values[lower + 1, rows] * share


def _sample(tile: NDArray, at: NDArray[np.float32]) -> FloatArray:
    x = np.clip(at[:, 0], 0, _TILE - 1.001)
    y = np.clip(at[:, 1], 0, _TILE - 1.001)
    x0, y0 = x.astype(np.int64), y.astype(np.int64)
    fx, fy = x - x0, y - y0
    flat = tile.ravel()
    corner = y0 * _TILE + x0
    top = flat[corner] * (1 - fx) + flat[corner + 1] * fx
    under = flat[corner + _TILE] * (1 - fx) + flat[corner + _TILE + 1] * fx
    return top * (1 - fy) + under * fy
