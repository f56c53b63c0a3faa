"""Colour words in names: which pixels may be called "red", and what a patch would be called.

Hue, saturation and value as OpenCV has them for floats (hue 0 … 360, the others 0 … 1). The
bounds are wide on purpose: light and shade move colours, and a word is only ever used to tell
what something certainly is not.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.reconstruction.masks import BoolArray
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
_SAME = {
    "gray": "grey", "silver": "grey", "violet": "purple", "lilac": "purple", "magenta": "pink",
    "teal": "cyan", "turquoise": "cyan", "golden": "yellow", "gold": "yellow", "scarlet": "red",
    "crimson": "red", "navy": "blue", "tan": "brown", "lime": "green",
}  # fmt: skip


def colour_of(name: str) -> str | None:
    """The one colour word of a name ("red_car" → "red"); None for none or for several."""
    words = re.findall(r"[a-z]+", name.lower())
    found = {_SAME.get(word, word) for word in words} & set(WORDS)
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
