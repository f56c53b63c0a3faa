"""Ramps that one looks down on: both long edges of their upper side are seen."""

import math

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.supports.ramps import find_profile, place_ramp

SIZE = (832, 480)
CAMERA = Camera.from_horizon(SIZE, 60.0, 0.6, focal=900.0)


def _seen(ramp):
    """The picture of a ramp's upper side and near side, and pixels on the middle of its slope."""
    x, y, _ = ramp.toe
    left, half = x - ramp.run, ramp.width / 2
    top = [(x, y - half, 0), (x, y + half, 0), (left, y + half, ramp.rise)]
    top.append((left, y - half, ramp.rise))
    side = [(x, y - half, 0), (left, y - half, ramp.rise), (left, y - half, 0)]
    image = np.full((SIZE[1], SIZE[0], 3), 120, np.uint8)
    for corners, colour in ((top, (210, 190, 150)), (side, (90, 80, 60))):
        pixels = CAMERA.project(np.array(corners, float))[0]
        cv2.fillPoly(image, [np.round(pixels).astype(np.int32)], colour, cv2.LINE_AA)
    middle = CAMERA.project(np.array([(x - ramp.run / 2, y, ramp.rise / 2)]))[0][0]
    return image, (float(middle[0]), float(middle[1]))


@pytest.mark.parametrize("width", [0.16, 0.3])
def test_the_far_edge_of_a_slope_tells_its_width_and_what_stands_on_it(width):
    ramp = Ramp(toe=(0.25, 1.6, 0.0), yaw=math.pi, run=0.6, rise=0.15, width=width)
    image, middle = _seen(ramp)
    profile = find_profile(segments(image), [middle], SIZE)
    assert profile is not None
    assert profile.far is not None
    assert profile.carries(*middle)
    assert not profile.carries(middle[0], middle[1] + 90)
    placed = place_ramp(CAMERA, profile)
    assert placed is not None
    assert placed.width == pytest.approx(width, rel=0.12)
    assert (placed.run, placed.rise) == pytest.approx((0.6, 0.15), rel=0.08)
    assert placed.toe == pytest.approx(ramp.toe, abs=0.03)


def test_the_thickness_of_a_board_seen_from_its_side_is_no_upper_side():
    ramp = Ramp(toe=(0.25, 1.6, 0.0), yaw=math.pi, run=0.6, rise=0.15, width=0.02)
    image, middle = _seen(ramp)
    profile = find_profile(segments(image), [middle], SIZE)
    assert profile is None or profile.far is None


def test_nothing_marked_shows_no_ramp():
    ramp = Ramp(toe=(0.25, 1.6, 0.0), yaw=math.pi, run=0.6, rise=0.15, width=0.2)
    image, _ = _seen(ramp)
    assert find_profile(segments(image), [], SIZE) is None
