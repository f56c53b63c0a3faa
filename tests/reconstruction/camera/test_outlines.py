"""Outlines of things of known form say how steeply they are looked at."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from physagent_studio.knowledge import usual_size
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.camera.estimate import Standing, estimate, usual_focal
from physagent_studio.reconstruction.camera.outline_forms import ANGLES
from physagent_studio.reconstruction.camera.outlines import outline_of
from physagent_studio.reconstruction.photo.line_segments import segments

SIZE = (640, 480)
AROUND = np.radians(np.arange(0, 360, 5))
CIRCLE = np.column_stack([np.cos(AROUND), np.sin(AROUND)])
TURN = np.array([[0.8, 0.6], [-0.6, 0.8]])
CAR = np.array([[1, 0.45], [-1, 0.45], [-1, -0.45], [1, -0.45]]) @ TURN
BOOK = np.array([[1, 0.7], [-1, 0.7], [-1, -0.7], [1, -0.7]]) @ TURN


def seen(foot: np.ndarray, height: float, pitch: float, across: float = 0.0) -> np.ndarray:
    """The mask of a prism over a foot (N, 2) that a camera tilted down by so many degrees sees."""
    focal, tilt = usual_focal(SIZE), math.radians(pitch)
    horizon = SIZE[1] / 2 - focal * math.tan(tilt)
    camera = Camera.from_horizon(SIZE, horizon, 12 * math.sin(tilt), focal=focal)
    places = foot + np.array([across, 12 * math.cos(tilt)])
    points = np.vstack([np.column_stack([places, np.full(len(places), z)]) for z in (0, height)])
    pixels = camera.project(points)[0].astype(np.float32)
    mask = np.zeros(SIZE[::-1], np.uint8)
    cv2.fillConvexPoly(mask, np.rint(cv2.convexHull(pixels)).astype(np.int32), 1)
    return mask.astype(bool)


def below(height: float, pitch: float, across: float = 0.0) -> float:
    """Degrees below the level at which the middle of such a prism is looked at."""
    tilt = math.radians(pitch)
    drop = 12 * math.sin(tilt) - height / 2
    return math.degrees(math.atan2(drop, math.hypot(12 * math.cos(tilt), across)))


def angle(mask: np.ndarray, name: str, roll: float = 0.0) -> float:
    outline = outline_of(mask, usual_size(name), usual_focal(SIZE), roll)
    assert outline is not None
    return math.degrees(ANGLES[int(outline.votes.argmax())])


@pytest.mark.parametrize("pitch", [10, 30, 50, 70])
@pytest.mark.parametrize("across", [-1.5, 0.0])
def test_round_things_show_how_flat_their_circles_are(pitch, across) -> None:
    for name, height, off in (("cup", 2.2, 9), ("plate", 0.1, 5)):
        found = angle(seen(CIRCLE, height, pitch, across), name)
        assert found == pytest.approx(below(height, pitch, across), abs=off)


@pytest.mark.parametrize("pitch", [15, 35, 55, 75])
def test_boxes_show_three_sides(pitch) -> None:
    for name, foot, height in (("toy_car", CAR, 0.8), ("book", BOOK, 0.3)):
        found = angle(seen(foot, height, pitch), name)
        assert found == pytest.approx(below(height, pitch), abs=12)


def test_a_turned_camera_sees_the_same() -> None:
    mask = seen(CIRCLE, 2.2, 40)
    turn = cv2.getRotationMatrix2D((SIZE[0] / 2, SIZE[1] / 2), 10, 1.0)
    askew = cv2.warpAffine(mask.astype(np.uint8), turn, SIZE).astype(bool)
    # The picture turned against the clock is what a camera turned with it sees.
    assert angle(askew, "cup", math.radians(10)) == pytest.approx(angle(mask, "cup"), abs=7)


def test_says_nothing_of_what_is_cut_or_of_no_known_form() -> None:
    mask, focal = seen(CIRCLE, 2.2, 40), usual_focal(SIZE)
    assert outline_of(mask, usual_size("football"), focal) is None
    assert outline_of(mask, usual_size("thingummy"), focal) is None
    assert outline_of(np.roll(mask, 240, axis=0), usual_size("cup"), focal) is None
    assert outline_of(mask[::20, ::20], usual_size("cup"), focal) is None


@pytest.mark.parametrize("pitch", [8, 45, 80])
def test_the_camera_is_tilted_as_a_plate_shows(pitch) -> None:
    mask, usual = seen(CIRCLE, 0.1, pitch), usual_size("plate")
    outline = outline_of(mask, usual, usual_focal(SIZE))
    plain = np.full((SIZE[1], SIZE[0], 3), 128, np.uint8)
    rows = np.flatnonzero(mask.any(1))
    extent = float(np.ptp(np.flatnonzero(mask.any(0))))
    standing = Standing(float(rows[-1]), extent, usual.metres, usual.spread, "floor")
    assert outline is not None
    found = estimate(SIZE, segments(plain), [standing], outlines=[outline])
    tilt = math.degrees(math.atan2(SIZE[1] / 2 - found.row, found.focal))
    assert tilt == pytest.approx(pitch, abs=6)
    assert found.sigma > 1
