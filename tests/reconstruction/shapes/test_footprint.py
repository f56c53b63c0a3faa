"""The lower rim of a mask tells how a thing on the ground is turned."""

import cv2
import numpy as np
import pytest

from physagent_studio.program import Camera
from physagent_studio.reconstruction.shapes.footprint import footprint_of

SIZE = (832, 480)


def camera(down: float) -> Camera:
    """1 m above the ground, looking down by so many degrees."""
    focal = 480 / 2 / np.tan(np.radians(22.5))
    return Camera.from_horizon(SIZE, 240 - focal * np.tan(np.radians(down)), 1.0, source="given")


def mask_of(corners: np.ndarray, view: Camera) -> np.ndarray:
    pixels, _ = view.project(corners)
    hull = cv2.convexHull(pixels.astype(np.float32)).round().astype(np.int32)
    mask = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    cv2.fillConvexPoly(mask, hull, 1)
    return mask.astype(bool)


def car(turn: float, spot: np.ndarray, size=(0.4, 0.18, 0.15)) -> np.ndarray:
    """Eight corners, m, of a body that narrows to a point above its middle."""
    angle = np.radians(turn)
    spin = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    half = np.array([[x, y] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * size[:2]
    low = np.column_stack([half @ spin.T + spot, np.zeros(4)])
    return np.concatenate([low, low * [0, 0, 0] + [*spot, size[2]]])


@pytest.mark.parametrize("turn", [25, 40, 60, 120, 140, 155])
@pytest.mark.parametrize("down", [15, 30])
def test_a_car_seen_from_a_corner_shows_its_axis(turn, down):
    view = camera(down)
    spot = np.array([0.1, 1.0 / np.tan(np.radians(down))])
    found = footprint_of(mask_of(car(turn, spot), view), view, 0.0)
    assert found is not None
    assert abs((found.angle - turn + 90) % 180 - 90) < 6
    assert found.along > 1.3 * found.across > 0


def test_a_disc_shows_none():
    view = camera(30)
    around = np.linspace(0, 2 * np.pi, 60)
    rim = np.stack([0.2 * np.cos(around) + 0.1, 0.2 * np.sin(around) + 1.7, 0 * around], axis=1)
    disc = np.concatenate([rim, rim + np.array([0, 0, 0.1])])
    assert footprint_of(mask_of(disc, view), view, 0.0) is None


def test_what_stands_above_the_horizon_or_is_small_tells_nothing():
    view = camera(5)
    high = car(30, np.array([0.0, 3.0])) + np.array([0, 0, 1.2])
    assert footprint_of(mask_of(high, view), view, 1.2) is None
    assert footprint_of(np.zeros((480, 832), bool), view, 0.0) is None


@pytest.mark.parametrize("turn", [25, 40, 60, 120, 140, 155])
@pytest.mark.parametrize("guess", [8, 32])
def test_under_a_guessed_horizon_it_still_looks_along_its_axis(turn, guess):
    view, wrong = camera(20), camera(guess)
    unsure = wrong.model_copy(update={"horizon_sigma": 120.0})
    spot = np.array([0.1, 1.0 / np.tan(np.radians(20))])
    mask = mask_of(car(turn, spot), view)
    found = footprint_of(mask, unsure, 0.0)
    assert found is not None
    seen = as_seen(found.angle, unsure, view, mask)
    assert abs((seen - turn + 90) % 180 - 90) < 10


def as_seen(angle: float, wrong: Camera, view: Camera, mask: np.ndarray) -> float:
    """What a direction on the ground of one camera is on that of another, degrees."""
    rows, columns = np.nonzero(mask)
    foot = np.array([columns.mean(), rows.max()])
    start = ground(wrong, foot)
    ahead = start + 1e-3 * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0])
    onward = ground(view, wrong.project(ahead[None])[0][0]) - ground(view, foot)
    return float(np.degrees(np.arctan2(onward[1], onward[0])))


def ground(view: Camera, pixel: np.ndarray) -> np.ndarray:
    ray = view.rays(pixel[None])[0]
    return np.array(view.position) - ray * view.position[2] / ray[2]
