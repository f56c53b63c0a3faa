"""How dark the ground is where a thing keeps the sky from it, and of which colour.

Light still gets there off the ground itself, so that its colour deepens: on a wooden floor blue is
lost first. How dark it is, is read off the photo around the feet that are seen.
"""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.grid import reduced
from physagent_studio.rendering.raster import FloatArray
from physagent_studio.rendering.shadow import Ground, Shadows
from physagent_studio.rendering.sun import (
    CONTACT,
    Shading,
    Sun,
    free_around,
    shown_on_even_ground,
)

_NEAR = 0.2
"""Share of the sky from which ground counts as close to a foot."""
_LEAST_CELLS = 12
_STRENGTH = (0.1, 0.8)
"""Weakest and strongest that it is drawn."""
_DEEPEST = 2.2
"""Most that the log of a shadow is multiplied for the colour of the ground."""
_SMOOTH = 2.0
"""Standard deviation of the blur in which the ground's colour is taken, cells."""


def contact_light(
    seen: Shading | None,
    sun: Sun,
    photo: Picture,
    free: NDArray[np.bool_],
    batch: Batch,
    world: FloatArray,
    ground: Ground,
) -> Sun:
    """The sky's part of the light, as strong as the photo shows it around the feet.

    seen: the photo's shading, None without. sun: its main lamp. photo, free: (H, W, 3) and (H, W)
    where no thing is. world: (V, 3) initial pose.
    """
    everyone = np.ones(len(batch.first) - 1)
    blocked = Shadows.of(batch, ground, CONTACT.lamp).blocked(world, everyone)
    near = blocked > _NEAR
    if seen is None or np.count_nonzero(seen.usable & near) < _LEAST_CELLS:
        around = free_around(free, batch, world, ground)
        shown = shown_on_even_ground(photo, around, blocked, _NEAR, ground)
        if shown is None:
            return CONTACT
        return replace(CONTACT, strength=np.full(3, np.clip(shown, *_STRENGTH)))
    close = seen.usable & near
    dark = -seen.darkness[close].max(-1)
    if sun.seen:
        cast = Shadows.of(batch, ground, sun.lamp).blocked(world, everyone)[close]
        dark = dark + np.log(1 - np.minimum(cast * sun.strength.min(), 0.95))
    strength = float(np.median((1 - np.exp(-dark)) / blocked[close]))
    return replace(CONTACT, strength=np.full(3, np.clip(strength, *_STRENGTH)))


def deepening(plate: Picture, step: int, shape: tuple[int, int]) -> NDArray[np.float32]:
    """(3, h, w) by how much the log of a shadow is multiplied on ground of each place's colour."""
    small = cv2.GaussianBlur(reduced(plate, step, shape), (0, 0), _SMOOTH) + 2.0
    short = np.log(small.max(-1, keepdims=True) / small)
    return np.ascontiguousarray(np.moveaxis(np.minimum(1 + short, _DEEPEST), -1, 0), np.float32)
