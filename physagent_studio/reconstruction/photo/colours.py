"""Colour words: what they certainly are not, and how well pixels fit them.

The words are those of `colours.yaml`. Hue, saturation and value as OpenCV has them for floats (hue
0 … 360, the others 0 … 1).
"""

import re
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.knowledge import Colour, colour_bounds, colours
from physagent_studio.reconstruction.photo.regions import BoolArray, FloatArray
from physagent_studio.records.case import Image


def colour_of(name: str) -> str | None:
    """The one colour word of a name ("red_car" → "red"); None for none or for several."""
    words = re.findall(r"[a-z]+", name.lower())
    found = {colours()[word].kind for word in words if word in colours()} - {""}
    return found.pop() if len(found) == 1 else None


def pixels_like(image: Image, word: str) -> BoolArray:
    """(H, W) pixels that may be called by a kind of colour."""
    hsv = cv2.cvtColor(image.astype(np.float32) / 255.0, cv2.COLOR_RGB2HSV)
    bounds = colour_bounds()[word]
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
    shares = {word: float(pixels_like(image, word)[mask].mean()) for word in colour_bounds()}
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
        best = np.maximum(best, _region(hsv, colours()[word]))
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
