"""Pictures that were taken askew are told from level ones by their upright edges alone."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.camera.estimate import Horizon
from physagent_studio.reconstruction.camera.roll import Levelled, roll_of
from physagent_studio.reconstruction.photo.line_segments import segments

SIZE = (640, 400)
BOARDS = [(-1.3, 5.0), (-0.7, 4.0), (-0.2, 5.5), (0.4, 4.4), (0.9, 5.2), (1.5, 6.0)]
"""Where boards stand, m to the right and away."""


def _picture(roll: float, leaning: tuple[float, ...] = (0.0,) * 6, pitch: float = 12.0):
    """Boards on a floor, seen by a camera that is turned; each leans by so many degrees."""
    focal = SIZE[1] / 2 / math.tan(math.radians(22.5))
    row = SIZE[1] / 2 - focal * math.tan(math.radians(pitch)) / math.cos(math.radians(roll))
    camera = Camera.from_horizon(SIZE, row, 1.2, focal=focal, roll=math.radians(roll))
    rng = np.random.default_rng(3)
    image = np.full((SIZE[1], SIZE[0], 3), 150.0)
    for (x, y), lean in zip(BOARDS, leaning, strict=True):
        across = math.tan(math.radians(lean))
        low, high = np.array([x, y, 0.0]), np.array([x + across * 0.9, y, 0.9])
        wide = np.array([0.25, 0.0, 0.0])
        corners = np.array([low, low + wide, high + wide, high])
        pixels = camera.project(corners)[0]
        colour = [float(v) for v in rng.uniform(30, 240, 3)]
        cv2.fillPoly(image, [np.round(pixels).astype(np.int32)], colour)
    image = cv2.GaussianBlur(image, (0, 0), 0.8) + rng.normal(0, 2, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def _told(image: np.ndarray) -> float:
    return math.degrees(roll_of(segments(image), SIZE))


@pytest.mark.parametrize("roll", [-9.0, -3.0, 2.5, 6.0])
def test_boards_that_all_lean_alike_tell_the_roll(roll: float) -> None:
    assert _told(_picture(roll)) == pytest.approx(roll, abs=0.7)


@pytest.mark.parametrize(
    ("leaning", "roll"),
    [
        ((0.0,) * 6, 0.0),
        ((0.0, 0.0, 6.0, 6.0, 6.0, 0.0), 0.0),
        ((-12.0, 9.0, -5.0, 6.0, 14.0, -8.0), 0.0),
        ((0.0,) * 6, 0.8),
    ],
)
def test_level_pictures_stay_level(leaning: tuple[float, ...], roll: float) -> None:
    """Also where some lean one way, or each its own, or the tilt is too small to be told."""
    assert _told(_picture(roll, leaning)) == 0.0


def test_a_few_edges_tell_nothing() -> None:
    image = np.full((SIZE[1], SIZE[0], 3), 150, np.uint8)
    cv2.fillPoly(image, [np.array([[300, 80], [350, 85], [330, 330], [280, 325]])], (40, 60, 200))
    assert _told(image) == 0.0
    assert _told(np.full_like(image, 90)) == 0.0


@pytest.mark.parametrize("roll", [-8.0, 0.0, 4.0])
def test_the_level_picture_is_the_one_of_a_level_camera(roll: float) -> None:
    level = Camera.from_horizon(SIZE, 90.0, 1.2, focal=480.0)
    made = Levelled(SIZE, math.radians(roll))
    tilted = made.tilted(Horizon(level.horizon, 5.0, 480.0))
    turned = Camera.from_horizon(SIZE, tilted.row, 1.2, focal=480.0, roll=tilted.roll)
    points = np.array([[0.6, 4.0, 0.0], [-0.9, 3.0, 0.4], [0.0, 9.0, 0.2]])
    seen, same = turned.project(points)[0], level.project(points)[0]
    assert [made.row((float(x), float(y))) for x, y in seen] == pytest.approx(same[:, 1])
