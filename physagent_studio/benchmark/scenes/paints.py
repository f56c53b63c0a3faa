"""Colours of things, and the patterns that they are painted with."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray

ROLES = {
    "any": ((0, 180), (20, 235), (50, 245)),
    "bright": ((0, 180), (130, 245), (110, 245)),
    "warm": ((6, 24), (90, 210), (120, 225)),
    "pale": ((10, 40), (5, 70), (185, 250)),
    "dark": ((0, 180), (10, 90), (18, 75)),
    "wood": ((8, 18), (70, 170), (70, 195)),
    "metal": ((90, 120), (5, 40), (110, 215)),
    "animal": ((6, 17), (50, 170), (45, 190)),
    "glass": ((95, 115), (20, 80), (35, 120)),
}
"""Hue (0 … 180), saturation and value (0 … 255) between which a colour of each role lies."""
WAVES = 20
"""Plane waves that add up to a smooth random field."""


@dataclass(frozen=True, eq=False, slots=True)
class Paint:
    """How a part is coloured: RGB 0 … 255 of ground and figure, which pattern, how often.

    gloss: strength of its highlight, 0 … 1. seed: of the pattern's chance.
    """

    colour: FloatArray
    other: FloatArray
    pattern: str
    repeats: float
    gloss: float
    seed: int


def drawn_colour(rng: np.random.Generator, role: str | Sequence[float]) -> FloatArray:
    """A colour (3,) of a role; one that is given as RGB is itself."""
    if not isinstance(role, str):
        return np.asarray(role, np.float64)
    hsv = [rng.uniform(*span) for span in ROLES[role]]
    pixel = np.array([[hsv]], np.float32).round().astype(np.uint8)
    return cv2.cvtColor(pixel, cv2.COLOR_HSV2RGB)[0, 0].astype(np.float64)


def painted(paint: Paint, local: FloatArray) -> FloatArray:
    """(N, 3) the colour at places (N, 3) of a part, −1 … 1 in its bounds."""
    rng = np.random.default_rng(paint.seed)
    share = PATTERNS[paint.pattern](local, paint.repeats, rng)[:, None]
    out = paint.colour * (1 - share) + paint.other * share
    grain = 0.16 if paint.pattern == "fur" else 0.025
    uneven = 1 + 0.05 * field(local, 1.5, rng) + grain * field(local, 26.0, rng)
    return out * uneven[:, None]


def field(places: FloatArray, fineness: float, rng: np.random.Generator) -> FloatArray:
    """(N,) a smooth random field of mean 0 and spread 1, that many times up and down."""
    waves = rng.normal(0, fineness, (WAVES, places.shape[1])).astype(np.float32)
    phase = rng.uniform(0, 2 * np.pi, WAVES).astype(np.float32)
    total = np.cos(places.astype(np.float32) @ waves.T + phase).sum(1)
    return np.asarray(total * np.sqrt(2 / WAVES), np.float64)


def _plain(at: FloatArray, repeats: float, rng: np.random.Generator) -> FloatArray:
    return np.zeros(len(at))


def _stripes(at: FloatArray, repeats: float, rng: np.random.Generator) -> FloatArray:
    way = rng.normal(0, (1.0, 0.3, 0.6))
    axis = at @ (way / np.linalg.norm(way))
    return (np.sin(axis * np.pi * repeats) > 0.1).astype(float)


def _rings(at: FloatArray, repeats: float, rng: np.random.Generator) -> FloatArray:
    return (np.sin(at[:, 2] * np.pi * repeats + 0.6) > 0.2).astype(float)


def _check(at: FloatArray, repeats: float, rng: np.random.Generator) -> FloatArray:
    signs = np.sin(at * np.pi * repeats) > 0
    return np.asarray(signs[:, 0] ^ signs[:, 1] ^ signs[:, 2], float)


def _wedges(at: FloatArray, repeats: float, rng: np.random.Generator) -> FloatArray:
    return (np.sin(np.arctan2(at[:, 1], at[:, 0]) * repeats) > 0).astype(float)


def _blotches(at: FloatArray, repeats: float, rng: np.random.Generator) -> FloatArray:
    return (field(at, repeats, rng) > 0.45).astype(float)


PATTERNS: dict[str, Callable[[FloatArray, float, np.random.Generator], FloatArray]] = {
    "plain": _plain,
    "fur": _plain,
    "stripes": _stripes,
    "rings": _rings,
    "check": _check,
    "wedges": _wedges,
    "blotches": _blotches,
}
"""Share of the other colour (N,) at local places (N, 3)."""
