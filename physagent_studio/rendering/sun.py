"""Where the photo's light comes from, read off the shadows that lie around the objects.

The ground around the objects is compared with the plate, which is without their shade. Lamps all
around the sky are tried; the one whose computed shadow agrees best with what is darker is taken,
if it agrees well enough, and new shadows fall the same way.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

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
_AGREES = 0.45
"""Least correlation between the darkness found and the shadow computed."""
_LEAST_TAKEN = 60
"""Cells."""
_AROUND = 3.2
"""How far around an object the ground is looked at, in heights of its top over that ground."""
_DARKEST = 0.85
_HUE_STRAYS = 1.2
"""How far a shadow's colour may be from that of the ground, as a ratio of logs."""
_FAINTEST = 0.12
_EVEN, _VISIBLE = 0.06, 0.03
"""Median stray of the log tone of ground that is even, and least shadow that is seen."""
_DEEP, _LEAST_DEEP = 0.3, 5
"""In how many of every fourth cell so much of it is blocked, at least: slivers have no colour."""
_SLIGHT = 0.1
"""Share of the light that is blocked, at least, where its shadow is looked for."""
_LEAST_CELLS = 200


@dataclass(frozen=True, eq=False, slots=True)
class Sun:
    """The main lamp and how much it darkens: strength (3,) RGB, 0 … 1. seen: read off the photo."""

    lamp: Lamp
    strength: FloatArray
    seen: bool


DEFAULT = Sun(Lamp(LIGHT, 0.35, 2.5), np.full(3, 0.48), False)
"""A large soft light from above, where the photo does not tell."""

CONTACT = Sun(Lamp(np.array([0.0, 0.0, 1.0]), 0.5, 1.1, 0.25), np.full(3, 0.65), False)
"""The sky that an object keeps from the ground it touches."""


@dataclass(frozen=True, eq=False, slots=True)
class Shading:
    """The ground around the objects as the photo shades it.

    darkness: (h, w, 3) log of the photo over the plate, ≤ 0 in shadow, 0 elsewhere. usable: (h, w)
    where the two differ. around: (h, w) ground near the objects, without what they cover. hue:
    (3,) by how much the log of a shadow is multiplied on ground of its colour, as light gets into
    it off the ground.
    """

    darkness: NDArray[np.float32]
    usable: NDArray[np.bool_]
    around: NDArray[np.bool_]
    hue: FloatArray


def shading_around(
    photo: Picture,
    plate: Picture,
    free: NDArray[np.bool_],
    batch: Batch,
    world: FloatArray,
    ground: Ground,
) -> Shading | None:
    """How a photo (H, W, 3) shades the ground around the objects; None where the plate is without
    hardly any shade, or little ground is in view.

    free: (H, W) where no object is. world: (V, 3) vertices at the initial pose.
    """
    around = free_around(free, batch, world, ground)
    differs = (photo != plate).any(-1).astype(np.float32)
    usable = around & (reduced(differs, ground.step, ground.shape) > 0.5)
    if around.sum() < _LEAST_CELLS or usable.sum() < _LEAST_TAKEN:
        return None
    tone = _tone(plate, ground)
    ratio = np.minimum(_tone(photo, ground) - tone, 0)
    own = np.median(tone[usable], axis=0)
    darkness = np.where(usable[..., None], ratio, 0).astype(np.float32)
    return Shading(darkness, usable, around, 1 + own.max() - own)


def estimate_sun(shading: Shading | None, batch: Batch, world: FloatArray, ground: Ground) -> Sun:
    """The photo's sun, or the usual light where it is unclear. world: (V, 3) initial pose."""
    if shading is None:
        return DEFAULT
    # Every fourth cell: enough to compare lamps by.
    ground = ground.halved()
    looked_at = shading.around[::2, ::2]
    everyone = np.ones(len(batch.first) - 1)
    places = _around(batch, world, ground)[:, looked_at]
    darkness, own = shading.darkness[::2, ::2][looked_at], shading.usable[::2, ::2][looked_at]
    grey = -darkness.mean(-1)

    def blocked_by(lamp: Lamp) -> NDArray:
        return Shadows.of(batch, ground, lamp).blocked(world, everyone)[looked_at]

    def agreement(lamp: Lamp) -> float:
        return _agreement(blocked_by(lamp), grey, places)

    best = max(((agreement(lamp), -k, lamp) for k, lamp in enumerate(_sky())), key=lambda x: x[:2])
    if best[0] <= _AGREES:
        return DEFAULT
    lamp = _refined(best[2], best[0], agreement)
    blocked = blocked_by(lamp)[own]
    strength = _strength(blocked, darkness[own], shading.hue)
    if strength.max() < _FAINTEST or np.count_nonzero(blocked > _DEEP) < _LEAST_DEEP:
        return DEFAULT
    return Sun(lamp, strength, True)


def usual_light(
    photo: Picture, free: NDArray[np.bool_], batch: Batch, world: FloatArray, ground: Ground
) -> Sun:
    """The usual light, as weak as even ground shows it where its shadows would be.

    free, world: see `shading_around`.
    """
    around = free_around(free, batch, world, ground)
    everyone = np.ones(len(batch.first) - 1)
    blocked = Shadows.of(batch, ground, DEFAULT.lamp).blocked(world, everyone)
    shown = shown_on_even_ground(photo, around, blocked, _DEEP, ground)
    if shown is None:
        return DEFAULT
    strength = float(np.clip(shown, _FAINTEST, DEFAULT.strength[0]))
    return replace(DEFAULT, strength=np.full(3, strength))


def shown_on_even_ground(
    photo: Picture, around: NDArray[np.bool_], blocked: NDArray, deep: float, ground: Ground
) -> float | None:
    """How much darker than the ground beside it a photo (H, W, 3) is where a light is blocked, over
    how much of it is blocked; None where the ground is not even, or little of it is seen.

    around, blocked: (h, w) ground near the things, and the share of the light that they keep from
    it. deep: from which share on it is looked at. Ground may be brighter here than there, as it is
    towards a window or the middle of a lens: a surface of second degree is fitted to its tone.
    """
    lit, shaded = around & (blocked < _VISIBLE), around & (blocked > _SLIGHT)
    if lit.sum() < _LEAST_CELLS or shaded.sum() < _LEAST_TAKEN:
        return None
    # What lies keeps little light from the ground: then where it keeps most.
    dark = shaded & (blocked >= min(deep, float(np.sort(blocked[shaded])[-_LEAST_TAKEN])))
    tone = _tone(photo, ground).mean(-1)
    rows, columns = np.mgrid[-1 : 1 : tone.shape[0] * 1j, -1 : 1 : tone.shape[1] * 1j]
    terms = np.stack([np.ones_like(rows), rows, columns, rows**2, columns**2, rows * columns], -1)
    kept, off = lit, tone
    for _ in range(2):
        weights = np.linalg.lstsq(terms[kept], tone[kept], rcond=None)[0]
        off = tone - terms @ weights
        # Marks and other things are no ground.
        kept = lit & (np.abs(off) < 3 * max(float(np.median(np.abs(off[kept]))), 0.01))
    if float(np.median(np.abs(off[lit]))) > _EVEN:
        return None
    return float(np.median((1 - np.exp(np.minimum(off[dark], 0))) / blocked[dark]))


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


def free_around(
    free: NDArray[np.bool_], batch: Batch, world: FloatArray, ground: Ground
) -> NDArray[np.bool_]:
    """(h, w) the same of all objects, where none of them is seen; free: (H, W)."""
    whole = reduced(free.astype(np.float32), ground.step, ground.shape) > 0.99
    return np.asarray(_around(batch, world, ground).any(0)) & whole


def _tone(picture: Picture, ground: Ground) -> FloatArray:
    """(h, w, 3) log of a picture's colours."""
    small = reduced(picture, ground.step, ground.shape)
    return np.log(np.maximum(cv2.GaussianBlur(small, (0, 0), 0.8), 4.0))


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


def _strength(blocked: NDArray, darkness: NDArray, hue: FloatArray) -> FloatArray:
    """(3,) how much full shadow darkens, from the log darkness (K, 3) where there is shadow.

    Of a hue (3,) near that of the ground: what else is seen there comes from the thing's colours.
    """
    total = float(blocked @ blocked)
    slope = np.maximum(-(blocked @ darkness) / max(total, 1e-9), 0) / hue
    usual = float(np.median(slope))
    slope = np.clip(slope, usual / _HUE_STRAYS, usual * _HUE_STRAYS) * hue
    return np.minimum(1 - np.exp(-slope), _DARKEST)
