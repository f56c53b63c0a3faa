"""Clicks a few pixels beside the corners of a table find the corners."""

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Grounding, Mark, Support
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.supports.snapping import snapped

SIZE = (832, 480)
CORNERS = np.array([[150.0, 330.0], [610.0, 400.0], [700.0, 240.0], [330.0, 200.0]])


def _picture(corners=CORNERS, seen=(0, 1, 2, 3)) -> np.ndarray:
    rng = np.random.default_rng(4)
    canvas = np.full((SIZE[1], SIZE[0], 3), (196, 190, 184), np.uint8)
    cv2.fillPoly(canvas, [np.round(corners * 16).astype(np.int32)], (150, 104, 66), shift=4)
    for k in set(range(4)) - set(seen):
        (x, y), (u, v) = np.round([corners[k], corners[(k + 1) % 4]]).astype(int).tolist()
        cv2.line(canvas, (x, y), (u, v), (90, 120, 60), 60)
    return np.clip(canvas + rng.normal(0, 3, canvas.shape), 0, 255).astype(np.uint8)


def _table(clicks, name="table") -> Support:
    marks = tuple(Mark(role="top", x=float(x), y=float(y)) for x, y in clicks)
    foot = Mark(role="foot", x=150.0, y=430.0)
    return Support(name=name, grounding=Grounding(marks=(marks[0], foot, *marks[1:])))


def _moved(support: Support, picture: np.ndarray) -> np.ndarray:
    out = snapped(support, segments(picture), SIZE)
    assert out.grounding.marked("foot") == support.grounding.marked("foot")
    return np.array(out.grounding.marked("top"))


@pytest.mark.parametrize("seed", range(6))
def test_corners_are_found_from_clicks_that_are_a_few_pixels_off(seed):
    off = np.random.default_rng(seed).uniform(-4, 4, CORNERS.shape)
    found = _moved(_table(CORNERS + off), _picture())
    assert np.abs(found - CORNERS).max() < 1.5


def test_a_corner_whose_edges_are_not_seen_stays():
    picture = _picture(seen=(0,))
    off = np.array([[3.0, -3.0], [2.0, 3.0], [-3.0, 2.0], [3.0, 3.0]])
    found = _moved(_table(CORNERS + off), picture)
    edge = CORNERS[1] - CORNERS[0]
    normal = np.array([-edge[1], edge[0]]) / np.linalg.norm(edge)
    assert np.abs((found[:2] - CORNERS[0]) @ normal).max() < 1.0
    assert np.abs(found[2:] - (CORNERS + off)[2:]).max() < 8


def test_clicks_at_the_border_ramps_and_blank_pictures_are_left_alone():
    corners = CORNERS.copy()
    corners[1] = (831.0, 433.0)
    found = _moved(_table(corners), _picture(corners))
    assert found[1].tolist() == [831.0, 433.0]
    blank = np.full((SIZE[1], SIZE[0], 3), 128, np.uint8)
    assert _moved(_table(CORNERS + 3), blank) == pytest.approx(CORNERS + 3)
    ramp = _table(CORNERS + 3, "ramp")
    assert snapped(ramp, segments(_picture()), SIZE) is ramp
