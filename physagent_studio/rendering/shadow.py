"""Soft shadows that objects cast on the floor and the supports.

Each object is seen from the light on a small square tile: whether it blocks the light there,
and how far along the light its lower surface lies. A point of the ground looks up its place on
the tile; the farther below the object it lies, the more blurred and the fainter the shadow, so
that it is dark and sharp at contact and fades as the object rises.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.light import LIGHT
from physagent_studio.rendering.raster import FloatArray, Lens, flat_facets, scan

_TILE = 64
_REACH = 2.0
"""A tile spans this many bounding radii to each side of its object."""
_BLUR = (0.8, 2.5, 6.0)
"""Standard deviations, in texels, of the three tiles between which softness is interpolated."""
_STRENGTH = 0.55
_PENUMBRA = 0.35
"""Blur per distance below the object: the tangent of half the angle that the light fills."""


def light_axes() -> FloatArray:
    """(3, 3) rows: right, down and along the light, a right-handed frame."""
    along = -LIGHT
    right = np.cross(along, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(along, right), along])


@dataclass(frozen=True, eq=False, slots=True)
class Ground:
    """The points that can receive a shadow, on a coarse grid of the picture.

    shape: (h, w) of the grid. cells: (K,) flat cells that show the floor or a support.
    places: (K, 3) light frame, m.
    """

    shape: tuple[int, int]
    cells: NDArray[np.int64]
    places: FloatArray


def transmitted(
    batch: Batch, world: FloatArray, ground: Ground, weights: FloatArray
) -> NDArray[np.float32]:
    """Share of the light (h, w) float32 that reaches the ground, 1 where no shadow falls.

    world: (V, 3) vertices of all objects. weights: (N,) how much of each object's shadow counts.
    """
    light = np.ones(ground.shape[0] * ground.shape[1], np.float32)
    axes = light_axes()
    for index in range(len(batch.first) - 1):
        points = world[batch.first[index] : batch.first[index + 1]] @ axes.T
        if len(points) and weights[index] > 0:
            _darken(light, points, batch, index, ground, float(weights[index]))
    return light.reshape(ground.shape)


def _darken(
    light: NDArray[np.float32],
    points: FloatArray,
    batch: Batch,
    index: int,
    ground: Ground,
    weight: float,
) -> None:
    low, high = points.min(0), points.max(0)
    centre = (low + high) / 2
    radius = float(max(high[0] - low[0], high[1] - low[1], 1e-6)) / 2
    texel = 2 * _REACH * radius / _TILE
    offset = ground.places - centre
    near = np.flatnonzero(
        (np.abs(offset[:, 0]) < _REACH * radius)
        & (np.abs(offset[:, 1]) < _REACH * radius)
        & (offset[:, 2] > low[2] - centre[2])
    )
    if not len(near):
        return
    faces = batch.faces[batch.face_owner == index] - batch.first[index]
    layers, bottom = _tile((points - centre) / texel, faces)
    offset = offset[near] / texel
    at = offset[:, :2].astype(np.float32) + np.float32(_TILE / 2 - 0.5)
    gap = offset[:, 2] - _sample(bottom, at)
    shade = _soft(layers, at, np.maximum(gap, 0))
    # Right at the surface that casts it, estimation noise must not switch the shadow off.
    shade *= np.clip(1 + gap / 3, 0, 1)
    shade *= np.exp(-np.maximum(gap, 0) * texel / (2.5 * radius))
    light[ground.cells[near]] *= (1 - weight * _STRENGTH * shade).astype(np.float32)


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
    layers = [cv2.GaussianBlur(mask, (0, 0), sigma) for sigma in _BLUR]
    wide = cv2.GaussianBlur(mask, (0, 0), 4.0)
    bottom = cv2.GaussianBlur(filled, (0, 0), 4.0) / np.maximum(wide, 1e-4)
    return layers, np.where(mask > 0, filled, bottom)


def _soft(layers: list[NDArray], at: NDArray[np.float32], gap: FloatArray) -> FloatArray:
    """Share of the light that is blocked (K,), blurred by the distance `gap` in texels."""
    sigma = _BLUR[0] + gap * _PENUMBRA
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
