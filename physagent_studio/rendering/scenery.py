"""`Scenery`: the picture behind the objects, with the shadows that they cast on it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.records.scene import Scene
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.contact import contact_light, deepening
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.grid import enlarged, reduced
from physagent_studio.rendering.raster import FloatArray, Lens
from physagent_studio.rendering.settled import Settled, apart_from
from physagent_studio.rendering.shadow import Ground, Shadows
from physagent_studio.rendering.sun import (
    CONTACT,
    DEFAULT,
    Sun,
    estimate_sun,
    shading_around,
    usual_light,
)

_VISIBLE = 1 / 300
_SHADED = 0.3
"""Share of the sun that an object keeps from ground which counts as its shadow."""
_RIM = 0.006
"""Width of an object's soft rim, as a share of the picture's longer side."""


@dataclass(frozen=True, eq=False, slots=True)
class Scenery:
    """The plate and what changes on it.

    plate: (H, W, 3) without objects and their shadows. settled: the photo around objects that
    stand still, None without a photo. lights: the sun and the sky, with their shadows. deep:
    (3, h, w) by how much shadows whose colour is not seen are deepened by that of the ground.
    apart: (h, w) 0 at the objects' places in the photo, 1 far from all of them.
    """

    plate: Picture
    settled: Settled | None
    sun: Sun
    lights: tuple[tuple[Sun, Shadows], ...]
    deep: NDArray[np.float32]
    apart: NDArray[np.float32]

    @classmethod
    def of(
        cls,
        scene: Scene,
        plate: Picture,
        batch: Batch,
        world: FloatArray,
        points: FloatArray,
        ground: Ground,
        lens: Lens,
        lit: bool = True,
    ) -> Self:
        """Prepare. world, points: (V, 3) vertices at the initial pose, world and camera frame.
        lit: whether the photo's light is looked for, which takes most of the time."""
        sun, sky, settled, photo = DEFAULT, CONTACT, None, scene.photo
        apart = np.ones(ground.shape, np.float32)
        if lit and photo is not None and photo.shape == plate.shape:
            masks = [scene.masks.get(item.name) for item in scene.state.objects]
            free = free_of(masks, photo.shape[:2])
            seen = shading_around(photo, plate, free, batch, world, ground)
            sun = estimate_sun(seen, batch, world, ground)
            if not sun.seen:
                sun = usual_light(photo, free, batch, world, ground)
            sky = contact_light(seen, sun, photo, free, batch, world, ground)
            cast = _cast(sun, batch, world, ground, plate.shape)
            settled = Settled.of(photo, plate, masks, cast, batch, points, lens)
            away = apart_from(masks, photo.shape[:2])
            apart = np.asarray(reduced(away, ground.step, ground.shape), np.float32)
        lights = tuple((one, Shadows.of(batch, ground, one.lamp)) for one in (sun, sky))
        deep = deepening(plate, ground.step, ground.shape)
        return cls(plate, settled, sun, lights, deep, apart)

    def standing(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(N,) how much each object is still where the photo shows it, and (N,) how much its
        shadow; 0 without a photo."""
        if self.settled is None:
            none = np.zeros(len(self.lights[0][1].batch.first) - 1)
            return none, none
        return self.settled.weights(points)

    def behind(
        self, world: FloatArray, standing: FloatArray, lingering: FloatArray, shadows: bool
    ) -> Picture:
        """The picture without objects: shadows of those that have left their place are new.

        lingering: (N,) how much of an object's shadow in the photo is left.
        """
        picture = self.plate
        if self.settled is not None:
            picture = self.settled.restore(picture, standing, lingering)
        if not shadows:
            return picture
        blocked = [cast.blocked(world, 1 - standing) for _, cast in self.lights]
        if (lingering > standing).any():
            # Away from the objects the photo's shadows give way more slowly.
            later = self.lights[0][1].blocked(world, 1 - lingering)
            blocked[0] += (later - blocked[0]) * self.apart
        window = _shaded(blocked)
        if window is None:
            return picture
        passing = np.ones((3, *blocked[0][window].shape), np.float32)
        seen = passing.copy()
        for (sun, _), dark in zip(self.lights, blocked, strict=True):
            # A sun whose shadows the photo shows has their colour already.
            light = seen if sun.seen else passing
            for channel, strength in enumerate(sun.strength.astype(np.float32)):
                light[channel] *= 1 - dark[window] * strength
        # Deepened by the ground.
        passing = np.exp(np.log(np.maximum(passing, np.float32(1e-3))) * self.deep[:, *window])
        light = passing * seen
        return lit(picture, light, self.lights[0][1].ground.step, window)


def _shaded(blocked: Sequence[NDArray[np.float32]]) -> tuple[slice, slice] | None:
    """The rows and columns of the coarse grid in which any light is blocked that can be seen."""
    some = np.logical_or.reduce([one > _VISIBLE for one in blocked])
    rows, columns = np.flatnonzero(some.any(1)), np.flatnonzero(some.any(0))
    if not len(rows):
        return None
    return (
        slice(max(rows[0] - 1, 0), rows[-1] + 2),
        slice(max(columns[0] - 1, 0), columns[-1] + 2),
    )


def _cast(
    sun: Sun, batch: Batch, world: FloatArray, ground: Ground, shape: tuple[int, ...]
) -> list[NDArray[np.bool_]]:
    """(H, W) per object where its shadow falls; nowhere if the photo shows no sun."""
    count = len(batch.first) - 1
    if not sun.seen:
        return [np.zeros(shape[:2], bool)] * count
    shadows = Shadows.of(batch, ground, sun.lamp)
    each = [shadows.blocked(world, np.eye(count)[index]) for index in range(count)]
    return [np.asarray(enlarged(one, ground.step, shape) > _SHADED) for one in each]


def free_of(masks: Iterable[NDArray[np.bool_] | None], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """(H, W) where the photo shows no object, nor the soft rim of one."""
    covered = np.zeros(shape, np.uint8)
    for mask in masks:
        if mask is not None and mask.shape == shape:
            covered |= mask.astype(np.uint8)
    side = 2 * max(3, round(_RIM * max(shape))) + 1
    return cv2.dilate(covered, np.ones((side, side), np.uint8)) == 0


def lit(
    picture: Picture, light: NDArray[np.float32], step: int, window: tuple[slice, slice]
) -> Picture:
    """A picture (H, W, 3) times a coarse map of light (3, h, w), which is that of a window of the

    grid; 1 on its rim.
    """
    # A little softer, or the grid's steps show where ground ends.
    coarse = cv2.GaussianBlur(cv2.merge(list(light)), (3, 3), 0.7)
    patch = np.asarray(cv2.resize(coarse, None, fx=step, fy=step, interpolation=cv2.INTER_LINEAR))
    y, x = step * window[0].start, step * window[1].start
    patch = patch[: picture.shape[0] - y, : picture.shape[1] - x]
    result = picture.copy()
    part = result[y : y + patch.shape[0], x : x + patch.shape[1]]
    part[:] = cv2.multiply(part, np.ascontiguousarray(patch), dtype=cv2.CV_8U)
    return result
