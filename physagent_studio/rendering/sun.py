"""Where the photo's light comes from, read off the shadows that lie around the objects.

The ground around the objects is compared with a smooth surface fitted to it: what is darker may
be shadow. Lamps all around the sky are tried; the one whose computed shadow agrees best with
what is dark is taken, if it agrees well enough, and new shadows fall the same way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.grid import reduced
from physagent_studio.rendering.light import LIGHT
from physagent_studio.rendering.raster import FloatArray
from physagent_studio.rendering.shadow import Ground, Lamp, Shadows

_AZIMUTHS = 16
_ELEVATIONS = (20, 32, 46, 62)
_PENUMBRA = 0.12
_REACH = 6.0
_TURN = np.pi / 16
"""First step by which the best lamp of the sky is turned, rad."""
_LOW_HIGH = (0.2, 1.4)
"""Lowest and highest that it stands, rad."""
_AGREES = 0.6
"""Least correlation between the darkness found and the shadow computed."""
_AGREE = 0.75
"""The same, its sum with that of the shade that the plate is without."""
_LEAST_TAKEN = 60
"""Cells."""
_AROUND = 3.2
"""How far around an object the ground is looked at, in heights of its top over that ground."""
_DARKEST = 0.85
_FAINTEST = 0.04
_LEAST_CELLS = 200


@dataclass(frozen=True, eq=False, slots=True)
class Sun:
    """The main lamp and how much it darkens: strength (3,) RGB, 0 … 1. seen: read off the photo."""

    lamp: Lamp
    strength: FloatArray
    seen: bool


DEFAULT = Sun(Lamp(LIGHT, 0.35, 2.5), np.full(3, 0.34), False)
"""A large soft light from above, where the photo does not tell."""

CONTACT = Sun(Lamp(np.array([0.0, 0.0, 1.0]), 0.5, 1.1, 0.25), np.full(3, 0.5), False)
"""The sky that an object keeps from the ground it touches."""


@dataclass(frozen=True, eq=False, slots=True)
class Shading:
    """The ground around the objects as the photo shades it.

    darkness: (h, w, 3) log of the picture over a smooth surface fitted to the ground, ≤ 0 in
    shadow, 0 elsewhere. usable: (h, w) where it means something.
    """

    darkness: NDArray[np.float32]
    usable: NDArray[np.bool_]


def shading_around(
    picture: Picture, known: NDArray[np.bool_], batch: Batch, world: FloatArray, ground: Ground
) -> Shading | None:
    """How a picture (H, W, 3) shades the ground around the objects; None where little is in view.

    known: (H, W) where it is the photo itself. world: (V, 3) vertices at the initial pose.
    """
    around = _around(batch, world, ground)
    return _shading(picture, known, ground, np.asarray(around.any(0)))


def taken_out(
    seen: Shading | None, photo: Picture, plate: Picture, ground: Ground
) -> Shading | None:
    """The shade that the plate is without: darkness of the photo over the plate where they differ,
    0 elsewhere; usable where they differ. None where that is nearly nowhere.
    """
    if seen is None:
        return None
    differs = (photo != plate).any(-1).astype(np.float32)
    usable = seen.usable & (reduced(differs, ground.step, ground.shape) > 0.5)
    if usable.sum() < _LEAST_TAKEN:
        return None
    ratio = _tone(photo, ground) - _tone(plate, ground)
    return Shading(np.where(usable[..., None], np.minimum(ratio, 0), 0).astype(np.float32), usable)


def estimate_sun(
    seen: Shading | None,
    batch: Batch,
    world: FloatArray,
    ground: Ground,
    taken: Shading | None = None,
) -> Sun:
    """The photo's sun, or the usual light where it is unclear.

    seen: of the photo where no object is in it; taken: what the plate is without, see `taken_out`.
    world: (V, 3) initial pose.
    """
    if seen is None:
        return DEFAULT
    # Every fourth cell: enough to compare lamps by.
    ground = ground.halved()
    looked_at = seen.usable[::2, ::2]
    everyone = np.ones(len(batch.first) - 1)
    places = _around(batch, world, ground)[:, looked_at]
    grounds = [seen] if taken is None else [seen, taken]
    darks = [one.darkness[::2, ::2][looked_at] for one in grounds]

    def blocked_by(lamp: Lamp) -> NDArray:
        return Shadows.of(batch, ground, lamp).blocked(world, everyone)[looked_at]

    def agreements(lamp: Lamp) -> list[float]:
        blocked = blocked_by(lamp)
        return [_agreement(blocked, -dark.mean(-1), places) for dark in darks]

    def agreement(lamp: Lamp) -> float:
        return sum(agreements(lamp))

    best = max(((agreement(lamp), -k, lamp) for k, lamp in enumerate(_sky())), key=lambda x: x[:2])
    each = agreements(best[2])
    if each[0] <= _AGREES and (taken is None or best[0] <= _AGREE):
        return DEFAULT
    lamp = _refined(best[2], best[0], agreement)
    leads = int(np.argmax(each))
    own = grounds[leads].usable[::2, ::2][looked_at]
    strength = _strength(blocked_by(lamp)[own], darks[leads][own])
    if strength.max() < _FAINTEST:
        return DEFAULT
    return Sun(lamp, strength, True)


def _sky() -> list[Lamp]:
    return [
        _lamp(azimuth, elevation)
        for elevation in np.radians(_ELEVATIONS)
        for azimuth in np.arange(_AZIMUTHS) * (2 * np.pi / _AZIMUTHS)
    ]


def _lamp(azimuth: float, elevation: float) -> Lamp:
    flat = np.cos(elevation)
    direction = (flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation))
    return Lamp(np.array(direction), _PENUMBRA, _REACH)


def _refined(lamp: Lamp, value: float, agreement: Callable[[Lamp], float]) -> Lamp:
    """The lamp near this one, turned a little, that agrees best with the photo.

    value: how well this one agrees.
    """
    x, y, z = lamp.direction.tolist()
    best = (float(np.arctan2(y, x)), float(np.arcsin(z)))
    for finer in (1.0, 0.5, 0.25):
        turns = [
            (best[0] + a * finer, float(np.clip(best[1] + b * finer, *_LOW_HIGH)))
            for a in (-_TURN, 0, _TURN)
            for b in (-_TURN / 2, 0, _TURN / 2)
        ]
        for tried in turns:
            if (found := agreement(_lamp(*tried))) > value:
                value, best = found, tried
    return _lamp(*best)


def _around(batch: Batch, world: FloatArray, ground: Ground) -> NDArray[np.bool_]:
    """(N, h, w) ground below each object, near enough for the shadow of a low sun."""
    near = np.zeros((len(batch.first) - 1, *ground.shape), bool)
    x, y, z = np.moveaxis(ground.points, -1, 0)
    for index in range(len(batch.first) - 1):
        mine = world[batch.first[index] : batch.first[index + 1]]
        if not len(mine):
            continue
        low, high = mine.min(0), mine.max(0)
        middle = (low + high) / 2
        away = np.hypot(x - middle[0], y - middle[1])
        reach = _AROUND * (high[2] - z) + np.hypot(*(high - low)[:2]) / 2
        near[index] = np.isfinite(z) & (z < low[2] + 0.5 * (high[2] - low[2])) & (away < reach)
    return near


def _shading(
    plate: Picture, known: NDArray[np.bool_], ground: Ground, around: NDArray[np.bool_]
) -> Shading | None:
    whole = reduced(known.astype(np.float32), ground.step, ground.shape) > 0.99
    usable = around & whole
    if usable.sum() < _LEAST_CELLS:
        return None
    tone = _tone(plate, ground)
    y, x = np.mgrid[0 : ground.shape[0], 0 : ground.shape[1]] / max(ground.shape)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], -1)
    weight = _weights(terms[usable], tone[usable].mean(-1))
    smooth = np.zeros((*ground.shape, 3))
    for channel in range(3):
        smooth[..., channel] = terms @ _fitted(terms[usable], tone[usable][:, channel], weight)
    smooth = np.clip(smooth, 0, np.log(255))
    darkness = np.where(around[..., None], tone - smooth, 0).astype(np.float32)
    return Shading(darkness, usable)


def _tone(picture: Picture, ground: Ground) -> FloatArray:
    """(h, w, 3) log of a picture's colours."""
    small = reduced(picture, ground.step, ground.shape)
    return np.log(np.maximum(cv2.GaussianBlur(small, (0, 0), 0.8), 4.0))


def _fitted(terms: FloatArray, values: FloatArray, weight: FloatArray) -> FloatArray:
    root = np.sqrt(weight)
    return np.asarray(np.linalg.lstsq(terms * root[:, None], values * root, rcond=None)[0], float)


def _weights(terms: FloatArray, values: FloatArray) -> FloatArray:
    """Weights of a fit that follows the lit ground: what is darker than it counts ever less."""
    weight = np.ones(len(values))
    for _ in range(8):
        rest = values - terms @ _fitted(terms, values, weight)
        spread = max(1.5 * float(np.median(np.abs(rest))), 0.02)
        weight = 1 / (1 + (rest / np.where(rest < 0, spread, 2 * spread)) ** 2)
    return weight


def _agreement(blocked: NDArray, dark: NDArray, places: NDArray[np.bool_]) -> float:
    """Mean over the objects of how well shadow and darkness (K,) agree around each (N, K).

    Every object has a say, so that one dark patch beside one of them is no sun.
    """
    each = [_correlation(blocked[own], dark[own]) for own in places if own.sum() > 20]
    return float(np.mean(each)) if each else 0.0


def _correlation(first: NDArray, second: NDArray) -> float:
    a, b = first - first.mean(), np.clip(second, -0.5, 1.5)
    b = b - b.mean()
    length = np.linalg.norm(a) * np.linalg.norm(b)
    return float(a @ b / length) if length > 1e-9 else 0.0


def _strength(blocked: NDArray, darkness: NDArray) -> FloatArray:
    """(3,) how much full shadow darkens, from the log darkness (K, 3) where there is shadow."""
    total = float(blocked @ blocked)
    slope = np.maximum(-(blocked @ darkness) / max(total, 1e-9), 0)
    return np.minimum(1 - np.exp(-slope), _DARKEST)
