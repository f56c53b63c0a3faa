"""What drives stands over the rectangle on which it is seen to stand."""

import cv2
import numpy as np
import pytest

from physagent_studio.program import Camera
from physagent_studio.program.scene.state import Inflated
from physagent_studio.reconstruction.shapes.footprint import footprint_of
from physagent_studio.reconstruction.shapes.inflation import inflated_mesh
from physagent_studio.reconstruction.shapes.prisms import plan_seen, prism_mesh

SIZE = (832, 480)
LONG, WIDE, HIGH = 0.4, 0.18, 0.2


def camera(down: float) -> Camera:
    """1 m above the ground, looking down by so many degrees."""
    focal = 480 / 2 / np.tan(np.radians(22.5))
    horizon = 240 - focal * np.tan(np.radians(down))
    return Camera.from_horizon(SIZE, horizon, 1.0, source="given", confirmed=True)


def van(turn: float, down: float) -> np.ndarray:
    """Eight corners (8, 3), m, of a block in the middle of that camera's picture."""
    angle = np.radians(turn)
    spin = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    half = np.array([[x, y] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * (LONG, WIDE)
    level = half @ spin.T + (0.05, 1.0 / np.tan(np.radians(down)))
    return np.vstack([np.column_stack([level, np.full(4, z)]) for z in (0.0, HIGH)])


def seen(points: np.ndarray, view: Camera) -> np.ndarray:
    """(H, W) which pixels the convex outline of points covers by more than half."""
    fine = 8
    pixels, _ = view.project(points)
    hull = cv2.convexHull((pixels * fine - 0.5).astype(np.float32))
    mask = np.zeros((SIZE[1] * fine, SIZE[0] * fine), np.uint8)
    cv2.fillConvexPoly(mask, np.round(hull * 16).astype(np.int32), 255, shift=4)
    return cv2.resize(mask, SIZE, interpolation=cv2.INTER_AREA) > 127


@pytest.mark.parametrize("turn", [5, 30, 55, 85, 130, 160])
def test_a_footprint_is_found_on_whatever_sides_are_seen(turn):
    view = camera(20)
    plan = plan_seen(seen(van(turn, 20), view), view, 0.0, WIDE / LONG, HIGH / LONG)
    assert plan is not None
    assert abs((plan.turn - turn + 90) % 180 - 90) < 4
    long, wide = plan.high - plan.low
    assert long == pytest.approx(LONG, rel=0.25)
    assert wide == pytest.approx(WIDE, rel=0.35)


def test_the_body_looks_right_from_where_no_photo_was_taken():
    view, corners = camera(20), van(35, 20)
    mask = seen(corners, view)
    plan = plan_seen(mask, view, 0.0, WIDE / LONG, HIGH / LONG)
    assert plan is not None
    body, _ = prism_mesh(mask, view, plan)
    middle = (corners.min(0) + corners.max(0)) / 2 * (1, 1, 0)
    for yaw in (0, 45, 90, 180):
        angle = np.radians(yaw)
        spin = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0]])
        spin = np.vstack([spin, [0, 0, 1]])
        true, own = (seen((p - middle) @ spin.T + middle, view) for p in (corners, body))
        assert (true & own).sum() / (true | own).sum() > (0.97 if yaw == 0 else 0.82)


def test_its_numbers_make_the_same_body_again():
    view = camera(25)
    mask = seen(van(40, 25), view)
    plan = plan_seen(mask, view, 0.0, WIDE / LONG, HIGH / LONG)
    assert plan is not None
    first, _ = prism_mesh(mask, view, plan)
    x, y, z = (float(side) for side in np.ptp(first, axis=0))
    again = inflated_mesh(mask, view, Inflated(size=(x, y, z), turn=plan.turn, thickness=plan.slim))
    # But for its base, which is cut level.
    assert np.ptp(again.vertices, axis=0) == pytest.approx((x, y, z), rel=0.02)


def test_what_is_cut_off_by_the_picture_shows_no_footprint():
    view = camera(20)
    mask = seen(van(35, 20), view)
    cut = np.roll(mask, -int(np.flatnonzero(mask.any(0))[0]), axis=1)
    assert plan_seen(cut, view, 0.0, WIDE / LONG, HIGH / LONG) is None


def test_a_side_alone_is_not_stood_up_under_a_horizon_that_is_a_guess():
    known = camera(20)
    guessed = known.model_copy(update={"confirmed": False, "horizon_sigma": 100.0})
    mask = seen(van(10, 20), known)
    plans = [plan_seen(mask, view, 0.0, WIDE / LONG, HIGH / LONG) for view in (known, guessed)]
    assert [plan is not None and plan.shown for plan in plans] == [True, False]


def test_a_horizon_that_leaves_the_rim_unexplained_is_sought_though_it_seemed_sure():
    mask = seen(van(50, 24), camera(24))
    wrong = camera(6).model_copy(update={"confirmed": False, "horizon_sigma": 4.0})
    found = footprint_of(mask, wrong, 0.0)
    assert found is not None
    assert found.along > found.across > 0
    assert footprint_of(mask, wrong.model_copy(update={"confirmed": True}), 0.0) is None
