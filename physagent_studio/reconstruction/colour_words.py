"""Colour words as soft regions of hue, saturation and value; usual colours of things."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import FloatArray
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class Region:
    """hue: middle and half width, degrees; None is any. low and high ends of saturation, value."""

    hue: tuple[float, float] | None
    saturation: tuple[float, float]
    value: tuple[float, float]


COLOURS: dict[str, Region] = {
    "red": Region((0, 18), (0.45, 1), (0.2, 1)),
    "orange": Region((26, 14), (0.5, 1), (0.45, 1)),
    "yellow": Region((52, 16), (0.4, 1), (0.5, 1)),
    "green": Region((120, 45), (0.25, 1), (0.12, 1)),
    "turquoise": Region((178, 18), (0.25, 1), (0.25, 1)),
    "cyan": Region((185, 15), (0.3, 1), (0.35, 1)),
    "blue": Region((218, 30), (0.3, 1), (0.15, 1)),
    "purple": Region((278, 28), (0.2, 1), (0.15, 1)),
    "violet": Region((278, 28), (0.2, 1), (0.15, 1)),
    "pink": Region((335, 28), (0.15, 0.7), (0.55, 1)),
    "magenta": Region((312, 20), (0.4, 1), (0.3, 1)),
    "brown": Region((24, 18), (0.25, 0.9), (0.12, 0.6)),
    "golden": Region((44, 14), (0.35, 0.95), (0.4, 1)),
    "gold": Region((44, 14), (0.35, 0.95), (0.4, 1)),
    "beige": Region((38, 16), (0.08, 0.4), (0.6, 1)),
    "white": Region(None, (0, 0.2), (0.72, 1)),
    "grey": Region(None, (0, 0.22), (0.22, 0.75)),
    "gray": Region(None, (0, 0.22), (0.22, 0.75)),
    "silver": Region(None, (0, 0.2), (0.45, 0.9)),
    "black": Region(None, (0, 0.8), (0, 0.24)),
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


def likeness(image: Image, words: Sequence[str]) -> FloatArray:
    """(H, W) 0 … 1: how well each pixel fits the best of the colour words."""
    hsv = cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_RGB2HSV)
    best = np.zeros(image.shape[:2], np.float32)
    for word in words:
        best = np.maximum(best, _region(hsv, COLOURS[word]))
    return best


def _region(hsv: NDArray, region: Region) -> FloatArray:
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
