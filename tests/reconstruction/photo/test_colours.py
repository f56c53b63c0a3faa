"""Colour words: what may be called so, what certainly may not, and where it is."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.knowledge import colour_bounds, colours
from physagent_studio.reconstruction.photo.colours import (
    colour_of,
    likeness,
    pixels_like,
    places_of,
    said_of,
)

PAINTS = {
    "red": (190, 40, 35), "orange": (230, 130, 40), "yellow": (225, 190, 50),
    "green": (50, 130, 70), "cyan": (60, 180, 190), "blue": (40, 80, 160),
    "purple": (110, 60, 130), "pink": (235, 150, 180), "brown": (110, 75, 45),
    "white": (235, 232, 228), "grey": (120, 122, 125), "black": (20, 20, 22),
}  # fmt: skip


def test_every_word_has_a_paint() -> None:
    assert set(PAINTS) == set(colour_bounds())


@pytest.mark.parametrize("word", PAINTS)
@pytest.mark.parametrize("light", [0.65, 1.0])
def test_a_paint_may_be_called_by_its_word_in_light_and_half_shade(word: str, light: float) -> None:
    colour = np.clip(np.array(PAINTS[word]) * light, 0, 255).astype(np.uint8)
    image = np.full((4, 4, 3), colour, np.uint8)
    assert pixels_like(image, word).all()


@pytest.mark.parametrize(
    ("paint", "word"), [("red", "blue"), ("yellow", "grey"), ("green", "red"), ("white", "black")]
)
def test_a_paint_is_not_called_by_a_far_word(paint: str, word: str) -> None:
    image = np.full((4, 4, 3), PAINTS[paint], np.uint8)
    assert not pixels_like(image, word).any()


@pytest.mark.parametrize(
    ("name", "word"),
    [("red_car", "red"), ("Gray box", "grey"), ("left_pin", None), ("red_and_blue_ball", None)],
)
def test_a_name_has_one_colour_or_none(name: str, word: str | None) -> None:
    assert colour_of(name) == word


def test_the_largest_free_patch_comes_first() -> None:
    image = np.full((60, 80, 3), PAINTS["grey"], np.uint8)
    image[10:20, 10:20] = PAINTS["red"]
    image[30:50, 40:60] = PAINTS["red"]
    taken = np.zeros((60, 80), bool)
    large, small = places_of(image, "red", taken)
    assert large == pytest.approx((50, 40), abs=9)
    assert small == pytest.approx((15, 15), abs=4)
    taken[30:50, 40:60] = True
    assert len(places_of(image, "red", taken)) == 1
    assert said_of(image, taken) == "red"


def test_every_colour_word_is_called_by_its_own_kind() -> None:
    """A patch in the middle of what a word stands for may be called by the kind it counts as."""
    for word, colour in colours().items():
        if not colour.kind:
            continue
        hue = colour.hue[0] if colour.hue else 0.0
        middle = [np.mean(colour.saturation), np.mean(colour.value)]
        hsv = np.array([[[hue % 360, *middle]]], np.float32)
        patch = np.round(cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB) * 255).astype(np.uint8)
        assert likeness(patch, [word]).min() > 0.9, word
        assert pixels_like(patch, colour.kind).all(), word


def test_words_for_one_colour_count_as_one() -> None:
    assert colour_of("crimson_ball") == colour_of("scarlet_ball") == colour_of("red_ball")
    assert colour_of("navy_box") == "blue"
    assert colour_of("lime_cup") == "green"
    assert colour_of("red_blue_ball") is None
