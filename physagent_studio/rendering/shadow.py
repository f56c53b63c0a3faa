"""Soft shadows that objects cast on the floor and the supports.

Each object is seen from the light on a small square tile: whether it blocks the light there,
and how far along the light its lower surface lies. A point of the ground looks up its place on
the tile; the farther below the object it lies, the more blurred and the fainter the shadow, so
that it is dark and sharp at contact and fades as the object rises.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.batch import Batch, Caster
from physagent_studio.rendering.raster import NEAR, FloatArray, Lens, flat_facets, scan

_TILE = 64
_FADED = 3.0
"""Shadows end at this many times the distance over which they fade to 1/e."""
_REACH = 2.0
"""A tile spans this many bounding radii to each side of its object."""
_NOWHERE = 1e9
"""Metres at which there is no ground any more."""
_BLUR = (0.8, 2.5, 6.0)
"""Standard deviations, in texels, of the three tiles between which softness is interpolated."""


@dataclass(frozen=True, eq=False, slots=True)
class Lamp:
    """A light that casts shadows. direction: (3,) unit, towards it, world.

    penumbra: blur per distance below the object, the tangent of half the angle that the light
    fills. reach: distance below the object, in its radii, over which its shadow fades to 1/e.
    beside: blur per height of the object, of half the shadow: so much of a light from all around
    does it keep from the ground beside it.
    """

    direction: FloatArray
    penumbra: float
    reach: float
    beside: float = 0.0

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

    points: (h, w, 3) world, m, inf where there is no ground. normals: (h, w, 3) unit, outward.
    step: pixels from cell to cell. lens, origin, matrix: the camera over this grid, its pixels
    the cells.
    """

    points: FloatArray
    normals: FloatArray
    step: int
    lens: Lens
    origin: FloatArray
    matrix: FloatArray

    @property
    def shape(self) -> tuple[int, int]:
        """(h, w)."""
        return self.points.shape[0], self.points.shape[1]

    def halved(self) -> Ground:
        """Every other row and column of it."""
        points, normals, lens = self.points[::2, ::2], self.normals[::2, ::2], self.lens
        height, width = points.shape[:2]
        half = Lens(width, height, lens.focal / 2, lens.cx / 2, lens.cy / 2)
        return replace(self, points=points, normals=normals, step=2 * self.step, lens=half)

    def window(self, corners: FloatArray) -> tuple[slice, slice]:
        """Rows and columns that world points (K, 3) span; all if one lies behind the camera."""
        local = (corners - self.origin) @ self.matrix
        if (local[:, 2] < NEAR).any():
            return slice(None), slice(None)
        pixels = self.lens.project(local)
        low = np.floor(pixels.min(0)).clip(0, (self.shape[1], self.shape[0])).astype(int)
        high = np.ceil(pixels.max(0)).clip(0, (self.shape[1], self.shape[0])).astype(int)
        return slice(int(low[1]), int(high[1])), slice(int(low[0]), int(high[0]))


@dataclass(frozen=True, eq=False, slots=True)
class Shadows:
    """One lamp over one ground. places: (3, h, w) float32, the ground in the lamp's frame.

    faced: (h, w) how much of the lamp falls there, 1 for as much as on level ground and more.
    """

    batch: Batch
    ground: Ground
    lamp: Lamp
    axes: FloatArray
    places: NDArray[np.float32]
    faced: NDArray[np.float32]

    @classmethod
    def of(cls, batch: Batch, ground: Ground, lamp: Lamp) -> Self:
        """Prepare a lamp."""
        axes = lamp.axes
        with np.errstate(invalid="ignore"):
            x, y, z = ground.points.reshape(-1, 3).T
            # Not as a product of matrices: the threads of that cost more than they bring.
            places = np.stack([a * x + b * y + c * z for a, b, c in axes]).astype(np.float32)
        far = _NOWHERE
        places = np.nan_to_num(places, copy=False, nan=far, posinf=far, neginf=far)
        level = max(float(lamp.direction[2]), 1e-3)
        facing = np.einsum("hwi,i->hw", ground.normals, lamp.direction) / level
        faced = np.clip(facing, 0, 1).astype(np.float32)
        return cls(batch, ground, lamp, axes, places.reshape(3, *ground.shape), faced)

    def blocked(self, world: FloatArray, weights: FloatArray) -> NDArray[np.float32]:
        """Share of the lamp's light (h, w) that objects keep from the ground, 0 … 1.

        world: (V, 3) vertices of all objects. weights: (N,) how much each object counts.
        """
        passing = np.ones(self.ground.shape, np.float32)
        casters = self.batch.casters
        active = [i for i in range(len(casters)) if weights[i] > 0 and len(casters[i].faces)]
        if not active:
            return 1 - passing
        clouds = [_Cloud.of(world[casters[i].rows] @ self.axes.T) for i in active]
        tiles = _tiles(clouds, [casters[i] for i in active])
        for place, (index, cloud) in enumerate(zip(active, clouds, strict=True)):
            self._shade(passing, cloud, tiles, place, float(weights[index]))
        return 1 - passing

    def _shade(
        self,
        passing: NDArray[np.float32],
        cloud: _Cloud,
        tiles: NDArray[np.float32],
        place: int,
        weight: float,
    ) -> None:
        """Darken the ground by one object, whose tile is number `place`."""
        centre, reach, texel = cloud.centre, cloud.reach, np.float32(cloud.texel)
        farthest = cloud.depth / 2 + _FADED * self.lamp.reach * cloud.radius
        window = self.ground.window(self._corners(centre, reach, -cloud.depth / 2, farthest))
        x, y, along = (self.places[axis][window] for axis in range(3))
        if not x.size:
            return
        middle, below = np.float32(_TILE / 2 - 0.5), along - np.float32(centre[2])
        column = np.clip((x - np.float32(centre[0])) / texel + middle, -2, _TILE + 1)
        row = np.clip((y - np.float32(centre[1])) / texel + middle, -2, _TILE + 1)
        tile = np.ascontiguousarray(tiles[:, place * _TILE : (place + 1) * _TILE])
        # Around the tile nothing is blocked, so that no place needs to be left out.
        seen = cv2.remap(tile, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        gap = below / texel - seen[..., 3]
        under = np.maximum(gap, 0)
        wide = under * np.float32(self.lamp.penumbra)
        shade = _soft(seen, wide)
        if self.lamp.beside:
            high = np.float32(self.lamp.beside * cloud.depth / cloud.texel)
            shade = (shade + _soft(seen, wide + high)) / 2
        # Right at the surface that casts it, estimation noise must not switch the shadow off.
        shade *= np.clip(1 + gap / 3, 0, 1)
        shade *= np.exp(under * np.float32(-texel / (self.lamp.reach * cloud.radius)))
        shade *= (below > -cloud.depth / 2) & (below < farthest)
        passing[window] *= 1 - np.float32(weight) * shade * self.faced[window]

    def _corners(self, centre: FloatArray, reach: float, near: float, far: float) -> FloatArray:
        """World corners (8, 3) of the space that an object at `centre` (lamp frame) can shade."""
        box = np.array(
            [(x, y, z) for x in (-reach, reach) for y in (-reach, reach) for z in (near, far)]
        )
        return (box + centre) @ self.axes


@dataclass(frozen=True, eq=False, slots=True)
class _Cloud:
    """An object's vertices (K, 3) in the lamp's frame; radius across it, depth along it, m."""

    points: FloatArray
    centre: FloatArray
    radius: float
    depth: float

    @classmethod
    def of(cls, points: FloatArray) -> Self:
        low, high = points.min(0), points.max(0)
        radius = float(max(high[0] - low[0], high[1] - low[1], 1e-6)) / 2
        return cls(points, (low + high) / 2, radius, float(high[2] - low[2]))

    @property
    def reach(self) -> float:
        return _REACH * self.radius

    @property
    def texel(self) -> float:
        return 2 * self.reach / _TILE


def _tiles(clouds: list[_Cloud], casters: list[Caster]) -> NDArray[np.float32]:
    """All objects in one scan, side by side, each in texels of its own.

    (tile, tile · objects, 4): the mask, blurred ever more, and the depth of the lower surface.
    """
    width = _TILE * len(clouds)
    lens = Lens(width, _TILE, 1.0, width / 2, _TILE / 2)
    points = [(cloud.points - cloud.centre) / cloud.texel for cloud in clouds]
    for place, mine in enumerate(points):
        mine[:, 0] += _TILE * (place + 0.5) - width / 2
    first = np.cumsum([0] + [len(mine) for mine in points[:-1]])
    joined = [own.faces + start for own, start in zip(casters, first, strict=True)]
    closed = np.repeat([own.closed for own in casters], [len(own.faces) for own in casters])
    together, faces = np.concatenate(points), np.concatenate(joined).astype(np.int32)
    prepared = flat_facets(together[:, :2], together[:, 2], faces, lens, closed)
    pixel, _, depth = scan(prepared, lens)
    mask = np.zeros((_TILE, width), np.float32)
    mask.ravel()[pixel] = 1
    filled = np.zeros_like(mask)
    filled.ravel()[pixel] = depth
    layers = [cv2.GaussianBlur(mask, (0, 0), sigma) for sigma in _BLUR]
    wide = np.asarray(cv2.GaussianBlur(mask, (0, 0), 4.0))
    bottom = np.asarray(cv2.GaussianBlur(filled, (0, 0), 4.0)) / np.maximum(wide, 1e-4)
    whole = cv2.merge([*layers, np.where(mask > 0, filled, bottom).astype(np.float32)])
    return np.asarray(whole, np.float32)


def _soft(seen: NDArray, wide: NDArray) -> NDArray:
    """Share of the light that is blocked (h, w), blurred by so many texels (h, w).

    seen: (h, w, 4) what the tile shows there.
    """
    sharp, middle, soft = seen[..., 0], seen[..., 1], seen[..., 2]
    first = np.clip(wide / np.float32(_BLUR[1] - _BLUR[0]), 0, 1)
    start, length = np.float32(_BLUR[1] - _BLUR[0]), np.float32(_BLUR[2] - _BLUR[1])
    second = np.clip((wide - start) / length, 0, 1)
    blocked = sharp + (middle - sharp) * first
    return blocked + (soft - blocked) * second
