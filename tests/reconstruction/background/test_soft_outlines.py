"""The hole is as wide as the colours of a thing fade."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.reconstruction.background.plate import taken_out
from physagent_studio.reconstruction.background.soft_outlines import SOFT, soft_width
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image

SHAPE = (200, 300)
USUAL = 4


def disc(sigma: float) -> tuple[Image, BoolArray]:
    """A red disc on green ground behind a soft lens, and its true mask."""
    rows, columns = np.indices(SHAPE)
    mask = np.hypot(rows - 100, columns - 150) < 50
    photo = np.where(mask[..., None], (200.0, 60.0, 40.0), (70.0, 130.0, 60.0))
    photo = cv2.GaussianBlur(photo, (0, 0), sigma) if sigma else photo
    photo += np.random.default_rng(3).normal(0, 2, photo.shape)
    return np.clip(photo, 0, 255).astype(np.uint8), mask


@pytest.mark.parametrize(("sigma", "low", "high"), [(0, 4, 4), (1, 4, 4), (4, 6, 8), (6, 8, 12)])
def test_a_soft_outline_is_wider(sigma: float, low: int, high: int) -> None:
    photo, mask = disc(sigma)
    assert low <= soft_width(photo, mask, USUAL) <= high


def test_it_is_bounded_and_nothing_tells_nothing() -> None:
    photo, mask = disc(20)
    assert soft_width(photo, mask, USUAL) <= SOFT.reach_factor * USUAL
    assert soft_width(photo, np.zeros(SHAPE, bool), USUAL) == USUAL
    assert soft_width(np.full((*SHAPE, 3), 90, np.uint8), mask, USUAL) == USUAL


def test_nothing_of_its_colour_is_left_beside_the_hole() -> None:
    photo, mask = disc(4)
    hole, _ = taken_out(photo, [mask])
    beside = ~hole & (cv2.dilate(hole.astype(np.uint8), np.ones((3, 3))) > 0)
    assert abs(float(photo[beside, 0].mean()) - 70) < 8
