"""How far the surroundings shine into an outline."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.reconstruction.texture.soft_rim import soft_rim


def _picture(blur: float, ground: int = 20) -> tuple[np.ndarray, np.ndarray]:
    mask = cv2.circle(np.zeros((160, 200), np.uint8), (100, 80), 50, 1, -1).astype(bool)
    photo = np.where(mask[..., None], (220, 150, 140), (ground, 70, 160)).astype(np.float32)
    return cv2.GaussianBlur(photo, (0, 0), blur).astype(np.uint8), mask


def test_a_blurred_outline_has_a_wide_rim() -> None:
    rims = [soft_rim(*_picture(blur)) for blur in (0.3, 1.5, 3.0)]
    assert rims[0] == 1
    assert rims == sorted(rims)
    assert rims[-1] >= 4


def test_what_is_of_the_colour_of_its_surroundings_has_no_rim_that_is_told() -> None:
    photo, mask = _picture(3.0)
    assert soft_rim(np.full_like(photo, 90), mask) == 1


@pytest.mark.parametrize("radius", [2, 5])
def test_what_is_too_small_to_have_an_inside_is_left_as_it_is(radius: int) -> None:
    photo, _ = _picture(1.0)
    mask = cv2.circle(np.zeros((160, 200), np.uint8), (100, 80), radius, 1, -1).astype(bool)
    assert soft_rim(photo, mask) == 1
