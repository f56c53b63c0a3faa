"""The rim of a plate is an ellipse, told from the part of it that is seen."""

import math

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Cylinder
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.photo.ellipses import rim_of
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.reconstruction.survey.sighting import without_side


def _drawn(points: tuple[int, int], axes: tuple[int, int]) -> BoolArray:
    canvas = np.zeros((300, 400), np.uint8)
    return cv2.ellipse(canvas, points, axes, 0, 0, 360, 1, -1).astype(bool)


@pytest.mark.parametrize("flat", [0.25, 0.5, 0.8])
def test_a_rim_behind_a_cup_is_as_flat_as_it_is(flat: float) -> None:
    plate = _drawn((200, 180), (120, round(120 * flat)))
    cup = _drawn((205, 150), (60, 60))
    found = rim_of(plate & ~cup, cup)
    assert found is not None
    assert found.flatness == pytest.approx(flat, abs=0.03)
    assert (found.x, found.y) == (pytest.approx(200.5, abs=3), pytest.approx(180.5, abs=3))


def test_a_spoon_that_sticks_out_changes_nothing() -> None:
    plate = _drawn((200, 180), (120, 60))
    plate[176:182, 300:380] = True
    found = rim_of(plate, np.zeros_like(plate))
    assert found is not None
    assert found.flatness == pytest.approx(0.5, abs=0.03)


def test_too_little_of_a_rim_tells_nothing() -> None:
    plate = _drawn((200, 180), (120, 60))
    hidden = np.zeros_like(plate)
    hidden[:225] = True
    assert rim_of(plate & ~hidden, hidden) is None


def test_what_is_no_ellipse_is_no_rim() -> None:
    tray = np.zeros((300, 400), bool)
    tray[100:220, 80:320] = True
    assert rim_of(tray, np.zeros_like(tray)) is None


@pytest.mark.parametrize("pitch", [15, 30, 50])
def test_a_plate_under_a_cup_tells_how_steeply_it_is_seen(pitch: int) -> None:
    down = math.radians(pitch)
    high, away = math.sin(down), math.cos(down)
    camera = Camera.from_horizon((640, 480), 240 - 900 * math.tan(down), high, focal=900.0)
    plate, cup = Cylinder(radius=0.13, height=0.012), Cylinder(radius=0.045, height=0.07)
    seen = [
        silhouette(camera, mesh.vertices + np.array([0.02, away, low]), mesh.faces)
        for mesh, low in ((mesh_of(plate), 0.006), (mesh_of(cup), 0.047))
    ]
    rim = rim_of(seen[0] & ~seen[1], seen[1])
    assert rim is not None
    rim = without_side(rim, 0.05)
    ray = camera.rays(np.array([[rim.x, rim.y]]))[0]
    slope = math.degrees(math.asin(-ray[2] / np.linalg.norm(ray)))
    assert math.degrees(math.asin(rim.flatness)) == pytest.approx(slope, abs=3)


def test_an_empty_mask_has_no_rim() -> None:
    nothing = np.zeros((300, 400), bool)
    assert rim_of(nothing, nothing) is None
