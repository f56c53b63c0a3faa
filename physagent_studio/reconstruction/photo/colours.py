"""Colour words: what they certainly are not, how well pixels fit them, what things usually are.

One table, `COLOURS`, says what each word stands for on a screen, and as which of the `WORDS` it
counts where only a kind of colour matters. Hue, saturation and value as OpenCV has them for
floats (hue 0 … 360, the others 0 … 1). The bounds of `WORDS` are wide on purpose: light and shade
move colours, and they are only ever used to tell what something certainly is not.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import BoolArray, FloatArray
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class Range:
    """Bounds of a colour word. hues: from, to in degrees, around 360 where from > to."""

    hues: tuple[float, float] = (0.0, 360.0)
    saturation: tuple[float, float] = (0.0, 1.0)
    value: tuple[float, float] = (0.0, 1.0)


WORDS: dict[str, Range] = {
    "red": Range((335, 22), (0.3, 1.0), (0.12, 1.0)),
    "orange": Range((8, 46), (0.35, 1.0), (0.25, 1.0)),
    "yellow": Range((34, 72), (0.25, 1.0), (0.3, 1.0)),
    "green": Range((66, 178), (0.12, 1.0), (0.06, 1.0)),
    "cyan": Range((160, 205), (0.15, 1.0), (0.2, 1.0)),
    "blue": Range((185, 262), (0.15, 1.0), (0.08, 1.0)),
    "purple": Range((250, 325), (0.12, 1.0), (0.08, 1.0)),
    "pink": Range((300, 20), (0.1, 0.8), (0.4, 1.0)),
    "brown": Range((0, 50), (0.15, 1.0), (0.05, 0.75)),
    "white": Range(saturation=(0.0, 0.35), value=(0.4, 1.0)),
    "grey": Range(saturation=(0.0, 0.35), value=(0.08, 0.92)),
    "black": Range(saturation=(0.0, 1.0), value=(0.0, 0.38)),
}


@dataclass(frozen=True, slots=True)
class Colour:
    """What a word stands for. kind: the one of `WORDS` that it counts as.

    hue: middle and half width, degrees; None is any. low and high ends of saturation, value.
    """

    kind: str
    hue: tuple[float, float] | None
    saturation: tuple[float, float]
    value: tuple[float, float]


COLOURS: dict[str, Colour] = {
    "red": Colour("red", (0, 18), (0.45, 1), (0.2, 1)),
    "orange": Colour("orange", (26, 14), (0.5, 1), (0.45, 1)),
    "yellow": Colour("yellow", (52, 16), (0.4, 1), (0.5, 1)),
    "green": Colour("green", (120, 45), (0.25, 1), (0.12, 1)),
    "turquoise": Colour("cyan", (178, 18), (0.25, 1), (0.25, 1)),
    "cyan": Colour("cyan", (185, 15), (0.3, 1), (0.35, 1)),
    "blue": Colour("blue", (218, 30), (0.3, 1), (0.15, 1)),
    "purple": Colour("purple", (278, 28), (0.2, 1), (0.15, 1)),
    "violet": Colour("purple", (278, 28), (0.2, 1), (0.15, 1)),
    "pink": Colour("pink", (335, 28), (0.15, 0.7), (0.55, 1)),
    "magenta": Colour("pink", (312, 20), (0.4, 1), (0.3, 1)),
    "brown": Colour("brown", (24, 18), (0.25, 0.9), (0.12, 0.6)),
    "golden": Colour("yellow", (44, 14), (0.35, 0.95), (0.4, 1)),
    "gold": Colour("yellow", (44, 14), (0.35, 0.95), (0.4, 1)),
    "beige": Colour("", (38, 16), (0.08, 0.4), (0.6, 1)),
    "white": Colour("white", None, (0, 0.2), (0.72, 1)),
    "grey": Colour("grey", None, (0, 0.22), (0.22, 0.75)),
    "gray": Colour("grey", None, (0, 0.22), (0.22, 0.75)),
    "silver": Colour("grey", None, (0, 0.2), (0.45, 0.9)),
    "black": Colour("black", None, (0, 0.8), (0, 0.24)),
    "teal": Colour("cyan", (178, 18), (0.25, 1), (0.2, 0.9)),
    "lilac": Colour("purple", (285, 25), (0.1, 0.6), (0.5, 1)),
    "scarlet": Colour("red", (4, 14), (0.5, 1), (0.35, 1)),
    "crimson": Colour("red", (348, 16), (0.45, 1), (0.2, 0.95)),
    "navy": Colour("blue", (228, 22), (0.35, 1), (0.08, 0.55)),
    "tan": Colour("brown", (32, 14), (0.2, 0.6), (0.45, 0.9)),
    "lime": Colour("green", (85, 25), (0.35, 1), (0.4, 1)),
}
"""What English colour words stand for on a screen."""

USUAL: dict[str, tuple[str, ...]] = {
    "orange": ("orange",), "pumpkin": ("orange",), "persimmon": ("orange",), "carrot": ("orange",),
    "basketball": ("orange",), "tomato": ("red",), "strawberry": ("red",), "cherry": ("red",),
    "apple": ("red", "green"), "lemon": ("yellow",), "banana": ("yellow",), "lime": ("green",),
    "tree": ("green",), "plant": ("green",), "cactus": ("green",), "watermelon": ("green",),
    "pin": ("white",), "egg": ("white", "beige"), "snowman": ("white",), "puck": ("black",),
    "tire": ("black",), "tyre": ("black",), "log": ("brown",), "brick": ("brown", "red"),
    "barrel": ("brown",), "crate": ("brown",),
}  # fmt: skip
"""Colours that a thing's own name suggests."""

MATERIALS: dict[str, tuple[str, ...]] = {"wooden": ("brown", "beige", "golden")}


def colour_of(name: str) -> str | None:
    """The one colour word of a name ("red_car" → "red"); None for none or for several."""
    words = re.findall(r"[a-z]+", name.lower())
    found = {COLOURS[word].kind for word in words if word in COLOURS} & set(WORDS)
    return found.pop() if len(found) == 1 else None


def pixels_like(image: Image, word: str) -> BoolArray:
    """(H, W) pixels that may be called by a colour word of `WORDS`."""
    hsv = cv2.cvtColor(image.astype(np.float32) / 255.0, cv2.COLOR_RGB2HSV)
    bounds = WORDS[word]
    low, high = bounds.hues
    hue = hsv[..., 0]
    around = (hue >= low) & (hue <= high) if low <= high else (hue >= low) | (hue <= high)
    return np.asarray(
        around
        & (hsv[..., 1] >= bounds.saturation[0])
        & (hsv[..., 1] <= bounds.saturation[1])
        & (hsv[..., 2] >= bounds.value[0])
        & (hsv[..., 2] <= bounds.value[1])
    )


def said_of(image: Image, mask: BoolArray) -> str:
    """The colour word that most pixels of a mask may be called by; "" for an empty mask."""
    if not mask.any():
        return ""
    shares = {word: float(pixels_like(image, word)[mask].mean()) for word in WORDS}
    return max(shares, key=lambda word: shares[word])


def places_of(
    image: Image, word: str, taken: BoolArray, most: int = 3
) -> list[tuple[float, float]]:
    """Points (x, y) well inside the largest patches of a colour that nothing else has taken."""
    free = (pixels_like(image, word) & ~taken).astype(np.uint8)
    free = cv2.morphologyEx(free, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    by_depth: list[tuple[float, tuple[float, float]]] = []
    largest = sorted(range(1, count), key=lambda n: -int(stats[n, cv2.CC_STAT_AREA]))
    for number in largest[: 2 * most]:
        patch = np.pad((labels == number).astype(np.uint8), 1)
        depth = cv2.distanceTransform(patch, cv2.DIST_L2, 3)[1:-1, 1:-1]
        y, x = np.unravel_index(int(depth.argmax()), depth.shape)
        by_depth.append((float(depth[y, x]), (float(x) + 0.5, float(y) + 0.5)))
    by_depth.sort(key=lambda row: -row[0])
    return [place for _, place in by_depth[:most]]


def likeness(image: Image, words: Sequence[str]) -> FloatArray:
    """(H, W) 0 … 1: how well each pixel fits the best of the colour words."""
    hsv = cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_RGB2HSV)
    best = np.zeros(image.shape[:2], np.float32)
    for word in words:
        best = np.maximum(best, _region(hsv, COLOURS[word]))
    return best


def _region(hsv: NDArray, region: Colour) -> FloatArray:
    hue, saturation, value = hsv[..., 0], hsv[..., 1], hsv[..., 2]
    fit = _between(saturation, *region.saturation, 0.1) * _between(value, *region.value, 0.12)
    if region.hue is not None:
        middle, half = region.hue
        off = np.abs((hue - middle + 180) % 360 - 180)
        fit = fit * np.clip(1 - (off - half) / 12, 0, 1)
    return fit.astype(np.float32)


def _between(values: NDArray, low: float, high: float, soft: float) -> NDArray:
    """1 between `low` and `high`, falling to 0 within `soft` beyond either."""
    return np.clip(1 - np.maximum(low - values, values - high) / soft, 0, 1)
