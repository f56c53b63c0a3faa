"""Lines painted on the ground are found by the words of a landmark, told as proposals, or asked."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Landmark
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.survey.landmarks import UNASKED, Shown, resolve
from physagent_studio.reconstruction.survey.painted_lines import painted_lines
from physagent_studio.records.case import Image

SIZE = (800, 500)
WHITE, RED = (235, 235, 230), (200, 40, 35)
Line = tuple[tuple[float, float], tuple[float, float]]


def _camera() -> Camera:
    focal = 600.0
    return Camera.from_horizon(SIZE, 250 - focal * math.tan(math.radians(16)), 1.2, focal=focal)


def _floor(
    lines: Sequence[tuple[Line, tuple[int, int, int]]], camera: Camera, grain: float = 4.0
) -> Image:
    """A grey floor with painted stripes 4 cm wide between two places on it, m."""
    rng = np.random.default_rng(5)
    image = np.full((SIZE[1], SIZE[0], 3), 120.0)
    image[: int(camera.horizon)] = 190.0
    for (start, end), color in lines:
        a, b = np.array(start, float), np.array(end, float)
        across = np.array([-(b - a)[1], (b - a)[0]]) / np.hypot(*(b - a)) * 0.02
        ring = np.array([a + across, b + across, b - across, a - across])
        pixels = camera.project(np.column_stack([ring, np.zeros(4)]))[0]
        cv2.fillPoly(image, [np.round(pixels * 16).astype(np.int32)], color, cv2.LINE_AA, 4)
    image = cv2.GaussianBlur(image, (0, 0), 0.7) + rng.normal(0, grain, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def _resolved(
    name: str, kind: str, image: Image, camera: Camera, covered: BoolArray | None = None
) -> tuple[Landmark, tuple[str, ...]]:
    landmark = Landmark.model_validate({"name": name, "kind": kind})
    shown = Shown(lines=tuple(painted_lines(image, covered)))
    (found,), said = resolve((landmark,), camera, (), shown)
    return found, said


@pytest.mark.parametrize("grain", [2.0, 8.0])
def test_the_only_line_on_the_floor_is_taken_and_told(grain: float) -> None:
    camera = _camera()
    image = _floor([(((-0.9, 3.0), (0.8, 3.6)), WHITE)], camera, grain)
    found, said = _resolved("finish_line", "line", image, camera)
    assert found.points is not None
    ends = sorted((x, y) for x, y, _ in found.points)
    assert np.allclose(ends, [(-0.9, 3.0), (0.8, 3.6)], atol=0.08)
    assert all(z == 0 for _, _, z in found.points)
    assert found.source == "estimated"
    assert said[0].endswith(UNASKED)


def test_of_two_lines_a_person_has_to_say_unless_the_colour_does() -> None:
    camera = _camera()
    lines = [(((-0.8, 2.6), (0.8, 2.6)), WHITE), (((-0.8, 3.4), (0.8, 3.4)), RED)]
    image = _floor(lines, camera)
    found, said = _resolved("line", "line", image, camera)
    assert found.points is None
    assert " or " in said[0]
    assert "click it" in said[-1]
    red, _ = _resolved("red_line", "line", image, camera)
    assert red.points is not None
    assert np.allclose([p[1] for p in red.points], 3.4, atol=0.05)


def test_a_lane_is_the_ground_between_two_lines() -> None:
    camera = _camera()
    lines = [(((x, 2.4), (x, 4.4)), WHITE) for x in (-0.45, 0.4)]
    found, _ = _resolved("lane", "area", _floor(lines, camera), camera)
    assert found.points is not None
    corners = np.array(found.points)[:, :2]
    assert np.allclose(sorted(corners[:, 0]), (-0.45, -0.45, 0.4, 0.4), atol=0.05)
    assert np.allclose(sorted(corners[:, 1]), (2.4, 2.4, 4.4, 4.4), atol=0.25)
    # In the order of a ring: opposite corners are the farthest apart.
    assert np.linalg.norm(corners[0] - corners[2]) > np.linalg.norm(corners[0] - corners[1])


def test_stripes_on_things_and_on_walls_are_no_lines_on_the_ground() -> None:
    camera = _camera()
    image = _floor([], camera)
    image[60:66, 100:600] = WHITE
    image[380:386, 200:500] = WHITE
    thing = np.zeros((SIZE[1], SIZE[0]), bool)
    thing[350:420, 180:520] = True
    assert camera.horizon > 66
    found, said = _resolved("line", "line", image, camera, thing)
    assert found.points is None
    assert said == ("landmark 'line' is open: click it in the photo",)


def test_a_bare_floor_and_a_step_between_two_floors_have_no_stripes() -> None:
    image = _floor([], _camera())
    image[400:] = (image[400:] * 0.6).astype(np.uint8)
    assert not [stripe for stripe in painted_lines(image) if stripe.strength > 0.12]
