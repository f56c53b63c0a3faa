"""Bars across the free ends of poles, before surroundings of their own pattern."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.parts.joined_crossbars import with_crossbars
from physagent_studio.reconstruction.masks.parts.pole_ends import pole_ends
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.case import Image

SIZE = (320, 240)
FOOT, TIP, WIDTH = (150.0, 215.0), (170.0, 75.0), 8.0


def _leaves(seed: int) -> Image:
    """Green spots of all lightnesses."""
    rng = np.random.default_rng(seed)
    spots = cv2.GaussianBlur(rng.normal(0, 1, (SIZE[1], SIZE[0])), (0, 0), 2.5)
    spots = (60 + 260 * spots).clip(15, 150)[..., None]
    return (spots * (0.7, 1.0, 0.35)).astype(np.uint8)


def _stroke(
    image: NDArray[np.uint8], line: tuple[tuple[float, float], ...], wide: float, colour: tuple
) -> BoolArray:
    """Draws a straight band, lighter on one side; where it is."""
    start, end = (np.array(point) for point in line)
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array([-along[1], along[0]])
    drawn = np.zeros(image.shape[:2], np.uint8)
    corners = [start + across * wide / 2, end + across * wide / 2]
    corners += [end - across * wide / 2, start - across * wide / 2]
    cv2.fillPoly(drawn, [np.rint(np.array(corners) * 16).astype(np.int32)], 1, shift=4)
    rows, columns = np.nonzero(drawn)
    aside = (np.stack([columns, rows], 1) - start) @ across / wide
    image[rows, columns] = np.clip(np.array(colour) * (1 + 0.5 * aside)[:, None], 0, 255)
    return drawn.astype(bool)


def _pole(image: Image) -> BoolArray:
    """A pole on a body, drawn; the mask of both."""
    pole = _stroke(image, (FOOT, TIP), WIDTH, (190, 190, 195))
    return pole | _stroke(image, ((110, 210), (200, 210)), 28, (150, 60, 50))


def _bar(image: Image, half: float = 40.0) -> BoolArray:
    """A light bar with dark grips across the pole's end, drawn; where it is."""
    (x, y), tilt = TIP, 0.06
    out = _stroke(image, ((x - half, y - tilt * half), (x + half, y + tilt * half)), 8, (205,) * 3)
    for way in (-1, 1):
        ends = [(x + way * part * half, y + way * part * tilt * half) for part in (0.45, 1.0)]
        out |= _stroke(image, (ends[0], ends[1]), 11, (60, 52, 50))
    return out


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_handlebar_before_leaves_joins_its_pole(seed: int) -> None:
    image = _leaves(seed)
    pole = _pole(image)
    whole = pole | _bar(image)
    found = with_crossbars(image, pole, Grounding())
    assert found is not None
    assert iou(found & ~pole, whole & ~pole) > 0.8
    assert (found[pole]).all()


@pytest.mark.parametrize("seed", range(6))
def test_a_pole_without_a_bar_gets_none(seed: int) -> None:
    image = _leaves(seed)
    assert with_crossbars(image, _pole(image), Grounding()) is None


def test_what_goes_on_behind_the_pole_is_no_bar() -> None:
    image = _leaves(0)
    _stroke(image, ((0, 72), (SIZE[0], 78)), 9, (90, 80, 70))
    assert with_crossbars(image, _pole(image), Grounding()) is None


def test_a_bar_that_holds_a_click_outside_or_leaves_the_box_is_left() -> None:
    image = _leaves(1)
    pole = _pole(image)
    _bar(image)
    click = Grounding(points=(Click(x=200, y=76, label=0),))
    assert with_crossbars(image, pole, click) is None
    assert with_crossbars(image, pole, Grounding(box=(100, 60, 190, 230))) is None
    assert with_crossbars(image, pole, Grounding(box=(100, 60, 230, 230))) is not None


def test_the_end_of_a_pole_is_told_with_its_direction_and_width() -> None:
    (end,) = pole_ends(_pole(_leaves(0)))
    along = np.array(TIP) - FOOT
    assert np.linalg.norm(end.tip - TIP) < 3
    assert end.outward @ along / np.linalg.norm(along) > 0.995
    assert abs(end.width - WIDTH) < 1.5


def test_a_body_without_poles_has_no_ends() -> None:
    canvas = np.zeros((120, 160), np.uint8)
    cv2.ellipse(canvas, (80, 60), (50, 35), 10, 0, 360, 1, -1)
    assert pole_ends(canvas.astype(bool)) == ()
    assert pole_ends(np.zeros((50, 50), bool)) == ()
