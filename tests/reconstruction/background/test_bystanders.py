"""What stands beside a marked thing is not taken out with its shade."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.arrays import BoolArray
from physagent_studio.reconstruction.background.bystanders import about_them, bystanders
from physagent_studio.reconstruction.background.plate import taken_out
from physagent_studio.reconstruction.switches import without
from physagent_studio.records.case import Image


def _drawn(box: tuple[int, int, int]) -> tuple[Image, BoolArray, BoolArray, BoolArray]:
    """A ball with a soft shadow before a box: the picture, and where ball, box and shadow are."""
    random = np.random.default_rng(2)
    image = np.full((300, 420, 3), (176, 150, 120), np.float32)
    image[:110] = (205, 205, 200)
    image += cv2.GaussianBlur(random.normal(0, 12, image.shape), (0, 0), 1.5)
    ball, other, shadow = (np.zeros((300, 420), np.uint8) for _ in range(3))
    cv2.circle(ball, (150, 170), 34, 1, -1)
    cv2.rectangle(other, (222, 128), (272, 212), 1, -1)
    cv2.ellipse(shadow, (190, 204), (52, 11), 0, 0, 360, 1, -1)
    dark = cv2.GaussianBlur(shadow.astype(np.float32), (0, 0), 4)[..., None]
    image *= 1 - 0.55 * dark
    image[other > 0] = box
    image[128:140, 222:273] = [min(255, v + 45) for v in box]
    image[ball > 0] = (200, 50, 45)
    image = cv2.GaussianBlur(image, (0, 0), 0.8)
    cv2.circle(image, (138, 156), 8, (240, 130, 125), -1)
    rgb = np.clip(image, 0, 255).astype(np.uint8)
    return rgb, ball > 0, other > 0, (shadow > 0) & (ball == 0) & (other == 0)


@pytest.mark.parametrize("box", [(52, 46, 44), (40, 70, 130)])
def test_a_thing_beside_stays_and_the_shade_goes(box: tuple[int, int, int]) -> None:
    photo, ball, other, shadow = _drawn(box)
    hole = ball | shadow
    hole[150:216, 184:256] = True
    found = bystanders(photo, ball, hole)
    assert found[other & hole].mean() > 0.9
    assert found[shadow].mean() < 0.1
    assert not found[ball].any()


def test_where_nothing_else_stands_nothing_stays() -> None:
    photo, ball, _, shadow = _drawn((176, 150, 120))
    assert bystanders(photo, ball, ball | shadow)[shadow].mean() < 0.05


def test_it_can_be_left_out() -> None:
    photo, ball, *_ = _drawn((52, 46, 44))
    hole, _ = taken_out(photo, [ball])
    with without(["bystanders"]) as asked:
        wider, _ = taken_out(photo, [ball])
    assert "bystanders" in asked
    assert not (hole & ~wider).any()


def test_shade_around_a_bystander_is_its_own() -> None:
    """A man beside a dog: the ring around his boots, and what hangs on to it, is not the dog's."""
    things, others, hole = (np.zeros((120, 200), bool) for _ in range(3))
    things[50:90, 20:70] = True
    others[10:100, 110:140] = True
    hole[84:96, 15:106] = True  # the dog's own shade, up to the man
    hole[30:110, 104:146] = True  # the man's legs, and a ring around them
    hole[100:110, 140:190] = True  # his shade, on the far side
    hole |= things
    theirs = about_them(others, things, hole)
    assert theirs[others].all()
    assert theirs[50, 104:146].all()
    assert theirs[105, 150:190].all()
    assert not theirs[84:96, 15:85].any()
    assert not theirs[things].any()


def test_a_piece_of_a_shade_has_no_shade_of_its_own() -> None:
    things, others, hole = (np.zeros((120, 200), bool) for _ in range(3))
    things[20:60, 20:70] = True
    hole[50:70, 20:160] = True
    others[52:68, 100:130] = True
    assert np.array_equal(about_them(others, things, hole), others)


def test_without_bystanders_there_is_no_shade_of_theirs() -> None:
    none = np.zeros((10, 10), bool)
    assert not about_them(none, ~none, ~none).any()


def test_a_hard_shadow_at_a_foot_is_no_thing() -> None:
    """It stands out all around as a thing does, and reaches a third beyond what was found of it."""
    photo, ball, *_ = _drawn((176, 150, 120))
    shadow = np.zeros(ball.shape, np.uint8)
    cv2.ellipse(shadow, (92, 202), (46, 7), 0, 0, 360, 1, -1)
    dark = (shadow > 0) & ~ball
    hard = np.where(dark[..., None], (58, 48, 40), photo).astype(np.uint8)
    hole = ball | dark
    hole[:, :72] = False
    assert bystanders(hard, ball, hole)[dark & hole].mean() < 0.05
