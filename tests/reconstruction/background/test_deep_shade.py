"""Shade of the sun on grass is so dark that it looks like ground of another colour: it leaves."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.reconstruction.background.plate import taken_out
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image

SIZE = (300, 400)
SUNLESS = np.array([0.22, 0.23, 0.26])
"""Of the light of red, green and blue, what the sky alone gives."""


def lawn(seed: int) -> tuple[Image, np.ndarray, np.ndarray]:
    """Sunny grass (H, W, 3), and rows and columns of it."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(SIZE)
    grass = np.array([150.0, 175, 40]) * rng.uniform(0.9, 1.1)
    stroke = cv2.GaussianBlur(rng.normal(0, 60, SIZE), (0, 0), 1.5)
    noise = np.repeat(stroke[..., None], 3, axis=-1)
    return np.clip(grass + noise, 0, 255).astype(np.uint8), y, x


def shaded_ball(seed: int) -> tuple[Image, BoolArray, BoolArray]:
    """A yellow ball on a lawn with its shadow beside it, and a shaded bench farther off; its mask
    and the shadow (H, W) where the ball does not cover it."""
    photo, y, x = lawn(seed)
    ball = (x - 170) ** 2 + (y - 170) ** 2 < 40**2
    shadow = ((x - 225) / 52) ** 2 + ((y - 196) / 17) ** 2 < 1
    bench = (np.abs(x - 90) < 70) & (np.abs(y - 248) < 22)
    light = np.where((shadow | bench)[..., None], SUNLESS, 1.0)
    seen = photo * cv2.GaussianBlur(light, (0, 0), 0.8)
    seen[ball] = (225, 200, 40)
    return np.clip(seen, 0, 255).astype(np.uint8), ball, shadow & ~ball


@pytest.mark.parametrize("seed", range(3))
def test_shade_of_the_sun_leaves_with_its_thing(seed: int) -> None:
    photo, ball, shadow = shaded_ball(seed)
    hole, _ = taken_out(photo, [ball])
    assert hole[shadow].mean() > 0.9
    # The shade of the bench is its own.
    assert hole[255:, :100].mean() < 0.05


@pytest.mark.parametrize("seed", range(3))
def test_what_is_dark_and_goes_on_is_no_shade(seed: int) -> None:
    # A hedge beside the ball, of the grass's colour in shade, reaches beyond where shade may be.
    photo, y, x = lawn(seed)
    ball = (x - 170) ** 2 + (y - 170) ** 2 < 40**2
    hedge = (x > 195) & (x < 330) & (y < 250)
    seen = np.where(hedge[..., None], photo * SUNLESS, photo)
    seen[ball] = (225, 200, 40)
    hole, _ = taken_out(np.clip(seen, 0, 255).astype(np.uint8), [ball])
    assert hole[hedge & (x > 240)].mean() < 0.1


def court(seed: int) -> tuple[Image, np.ndarray, np.ndarray]:
    """Sunny ground of two colours with a white line between (H, W, 3), its rows and columns."""
    noise = np.random.default_rng(seed).normal(0, 8, SIZE)[..., None]
    y, x = np.indices(SIZE)
    across = y - 120 - 0.4 * x
    colours = np.where((across > 0)[..., None], (190.0, 88, 42), (96.0, 100, 98))
    colours = np.where((np.abs(across) < 9)[..., None], 245.0, colours)
    return np.clip(colours + noise, 0, 255).astype(np.uint8), y, x


@pytest.mark.parametrize("seed", range(3))
def test_black_shade_is_that_of_the_ground_beside_it(seed: int) -> None:
    photo, y, x = court(seed)
    ball = (x - 130) ** 2 + (y - 185) ** 2 < 38**2
    shadow = ((x - 128) / 34) ** 2 + ((y - 232) / 40) ** 2 < 1
    seen = photo * np.where(shadow[..., None], 0.09, 1.0)
    seen[ball] = (215, 90, 40)
    hole, _ = taken_out(np.clip(seen, 0, 255).astype(np.uint8), [ball])
    assert hole[shadow & ~ball].mean() > 0.95
    assert hole[:, 260:].mean() < 0.02
