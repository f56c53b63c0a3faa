"""From linear light to an 8-bit photograph: lens, sensor, tone curve."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


def without_fireflies(image: Array, factor: float = 2.5) -> Array:
    """Clamp lone pixels brighter than `factor` times the second brightest in their 3 × 3."""
    height, width = image.shape[:2]
    luma = image @ np.array([0.2126, 0.7152, 0.0722], np.float32)
    padded = np.pad(luma, 1, mode="edge")
    around = np.stack(
        [
            padded[i : i + height, j : j + width]
            for i in range(3)
            for j in range(3)
            if i != 1 or j != 1
        ]
    )
    limit = np.sort(around, axis=0)[-2] * factor + 1e-4
    return (image * np.minimum(1, limit / np.maximum(luma, 1e-6))[..., None]).astype(np.float32)


def _filmic(x: Array) -> Array:
    """Linear up to a knee, then a soft shoulder that never clips hard."""
    knee = 0.55
    over = np.maximum(x - knee, 0) / (1 - knee)
    return np.where(x < knee, x, knee + (1 - knee) * over / (1 + 0.55 * over) * 1.0).astype(
        np.float32
    )


def _srgb(x: Array) -> Array:
    x = np.clip(x, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055).astype(np.float32)


def develop(
    image: Array,
    *,
    exposure: float,
    balance: tuple[float, float, float] = (1.0, 1.0, 1.0),
    seed: int,
    full_well: float = 9000.0,
    read_noise: float = 7.0,
    blur: float = 0.38,
    vignette: float = 0.10,
    contrast: float = 0.5,
) -> NDArray[np.uint8]:
    """An sRGB photograph (H, W, 3) uint8 of linear radiance.

    full_well, read_noise: the sensor in electrons, which set the grain. blur: standard
    deviation of the lens and demosaicing in pixels. vignette: loss of light in the corners.
    contrast: strength of the S-curve.
    """
    rng = np.random.default_rng(seed)
    height, width = image.shape[:2]
    light = without_fireflies(image) * exposure * np.asarray(balance, np.float32)
    bloom = cv2.GaussianBlur(np.minimum(light, 4), (0, 0), width / 60)
    light = 0.985 * light + 0.015 * bloom
    y, x = np.mgrid[:height, :width].astype(np.float32)
    radius = np.hypot(x - width / 2, y - height / 2) / np.hypot(width / 2, height / 2)
    light *= (1 - vignette * radius**2.4)[..., None]
    light = cv2.GaussianBlur(light, (0, 0), blur)
    electrons = np.maximum(light, 0) * full_well
    electrons += rng.standard_normal(light.shape) * np.sqrt(electrons + read_noise**2)
    light = (electrons / full_well).astype(np.float32)
    # Demosaicing spreads the grain over neighbours.
    light = cv2.GaussianBlur(light, (0, 0), 0.42)
    tone = _srgb(_filmic(np.maximum(light, 0)))
    tone = tone + contrast * (tone - 0.5) * tone * (1 - tone) * 4 * 0.5
    return np.clip(tone * 255 + rng.uniform(-0.5, 0.5, tone.shape), 0, 255).round().astype(np.uint8)
