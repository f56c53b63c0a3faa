"""Mirror images on polished ground: where the plate is without the old one, a new one is drawn."""

from dataclasses import dataclass, replace
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Floor
from physagent_studio.records.scene import Scene
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.grid import enlarged, reduced
from physagent_studio.rendering.raster import FloatArray, Hits, between, rasterise
from physagent_studio.rendering.scenery import free_of
from physagent_studio.rendering.shadow import Ground
from physagent_studio.rendering.skin import Skin

_TAKEN, _ALIKE, _VARIES = 0.4, 0.6, 0.3
"""Share of a mirror image that the plate is without, and how well what is gone agrees with it as it
is and about its mean (correlations): at least."""
_APART, _NEAR = 0.44, 3.0
"""Least correlation of what is neither of the two's shade, and within how many cells of it shade
hardly changes."""
_TELLING = 0.25
"""How much of a mirror image no shade would do, at least: that of a black thing is like shade."""
_STRENGTH = (0.04, 0.5)
_LEAST, _SOFT = 25, 1.3
"""Cells, and standard deviation of the blur of a mirror image in cells."""


@dataclass(frozen=True, eq=False, slots=True)
class Mirror:
    """Level ground. height: world, m. strength: how much of a thing it shows at a foot, 0 … 1."""

    skin: Skin
    ground: Ground
    height: float
    strength: float = 1.0

    def drawn(
        self, picture: Picture, world: FloatArray, turned: FloatArray, bent: bool, each: FloatArray
    ) -> Picture:
        """A picture with mirror images of vertices (V, 3), each (N,) thing's as strong as said."""
        pixel, _, colors, share = self._image(world, turned, bent, each)
        if not share.any():
            return picture
        layer = np.zeros((*self.ground.shape, 4), np.float32)
        layer.reshape(-1, 4)[pixel] = np.hstack([colors * share, share])
        rows = np.flatnonzero(layer[..., 3].any(1))
        first, step = max(rows[0] - 5, 0), self.ground.step
        soft = cv2.GaussianBlur(layer[first : rows[-1] + 6], (0, 0), _SOFT)
        band = slice(step * first, min(step * (rows[-1] + 6), len(picture)))
        whole = picture[band]
        soft = enlarged(soft, step, whole.shape)
        result = picture.copy()
        result[band] = whole * (1 - soft[..., 3:]) + soft[..., :3] + 0.5
        return result

    @classmethod
    def of(cls, scene: Scene, skin: Skin, ground: Ground, world: FloatArray) -> Self | None:
        """The lowest floor as its photo shows it; None where it is not seen to mirror.

        world: (V, 3) initial pose.
        """
        floors = [s.shape.height for s in scene.state.supports if isinstance(s.shape, Floor)]
        photo, plate = scene.photo, scene.plate
        if not floors or photo is None or plate is None or photo.shape != plate.shape:
            return None
        whole = cls(skin, ground, min(floors))
        free = free_of(scene.masks.values(), photo.shape[:2])
        each = np.ones(len(skin.paints))
        pixel, owner, colors, share = whole._image(world, skin.rotations, False, each)
        flags = np.dstack([(photo != plate).any(-1), free]).astype(np.float32)
        step, shape = ground.step, ground.shape
        before, after, told = (
            reduced(one, step, shape).reshape(shape[0] * shape[1], -1)[pixel]
            for one in (photo, plate, flags)
        )
        gone, shown = before - after, (colors - after) * share
        found = []
        for index in range(len(each)):
            mine = (told[:, 1] > 0.99) & (owner == index) & (share[:, 0] > 0.5)
            both = mine & (told[:, 0] > 0.5)
            x, y = shown[both], gone[both]
            if both.sum() < max(_LEAST, _TAKEN * mine.sum()) or _alike(x, y) < _ALIKE:
                continue
            # Shade darkens all of it, but does not vary with the thing, in colour and in detail.
            if _alike(x - x.mean(0), y - y.mean(0)) <= _VARIES:
                continue
            own, theirs = (_unshaded(d, after[both], pixel[both], shape) for d in (x, y))
            telling = np.linalg.norm(own) > _TELLING * np.linalg.norm(x)
            if telling and _alike(own, theirs) > _APART:
                found.append(float((x * y).sum() / (x * x).sum()))
        strength = min(max(found, default=0.0), _STRENGTH[1])
        return replace(whole, strength=strength) if strength > _STRENGTH[0] else None

    def _image(
        self, world: FloatArray, turned: FloatArray, bent: bool, each: FloatArray
    ) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
        """Cells (K,), things (K,), colours (K, 3), how strong (K, 1): less the higher."""
        batch, ground = self.skin.batch, self.ground
        behind = world * (1, 1, -1) + (0, 0, 2 * self.height) - ground.origin
        mine = np.flatnonzero(each[batch.face_owner] > 0)
        both = np.zeros(len(mine), bool)
        found = rasterise(behind @ ground.matrix, batch.faces[mine], ground.lens, both)
        hits = Hits(found.pixel, mine[found.face].astype(np.int32), found.weights, found.depth)
        high = between(hits, world[:, 2:], batch.faces) - self.height
        level = np.abs(ground.points.reshape(-1, 3)[hits.pixel, 2:] - self.height) < 1e-4
        fades = np.exp(-np.maximum(high, 0) / max(float(np.ptp(world[:, 2])), 1e-6))
        owner = batch.face_owner[hits.face]
        share = self.strength * fades * (level & (high > 0)) * each[owner, None]
        colors = self.skin.colors(hits, turned, world if bent else None)
        return hits.pixel, owner, colors, share.astype(np.float32)


def _unshaded(
    change: NDArray, ground: NDArray, pixel: NDArray[np.int64], shape: tuple[int, int]
) -> NDArray:
    """(K, 6) what of a change (K, 3) of a ground's colours (K, 3) no shade would do: its colour
    and its detail, for shade keeps the ground's. pixel: (K,) cells of a picture of that shape."""
    dimmed = (change * ground).sum(1, keepdims=True) / np.maximum((ground**2).sum(1), 1)[:, None]
    layer = np.zeros((shape[0] * shape[1], 2), np.float32)
    layer[pixel] = np.hstack([dimmed, np.ones((len(pixel), 1))])
    soft = cv2.GaussianBlur(layer.reshape(*shape, 2), (0, 0), _NEAR).reshape(-1, 2)[pixel]
    return np.hstack([change - dimmed * ground, change - soft[:, :1] / soft[:, 1:] * ground])


def _alike(x: NDArray, y: NDArray) -> float:
    return float((x * y).sum() / max(np.linalg.norm(x) * np.linalg.norm(y), 1e-6))
