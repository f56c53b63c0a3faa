"""Shapes of revolution stand on the rim of their foot, also where shade sticks to it."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.revolution import revolved

SIZE = (640, 480)


def seen_from_above(top: float, bottom: float) -> tuple[Camera, np.ndarray]:
    """A camera 1 m above the ground, and the mask of a frustum .2 m high that stands 2 m away."""
    view = Camera.from_horizon(SIZE, -60, 1.0, focal=620)
    around = np.linspace(0, 2 * math.pi, 80)
    rims = [
        np.column_stack([r * np.cos(around), 2 + r * np.sin(around), np.full(80, z)])
        for r, z in ((bottom, 0.0), (top, 0.2))
    ]
    pixels, _ = view.project(np.vstack(rims))
    mask = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    hull = cv2.convexHull(pixels.astype(np.float32)).round().astype(np.int32)
    cv2.fillConvexPoly(mask, hull, 1)
    return view, mask.astype(bool)


@pytest.mark.parametrize("spur", [0, 3, 6])
def test_a_spur_of_shade_takes_no_foot_away(spur: int) -> None:
    view, mask = seen_from_above(0.15, 0.15)
    low = int(np.flatnonzero(mask.any(1))[-1])
    middle = SIZE[0] // 2
    mask[low + 1 : low + 1 + spur, middle - 3 : middle + 3] = True
    made = revolved(view, mask, Base(0.0, 2.0, 0.0))
    assert made is not None
    profile = made[0].profile
    assert profile[0][1] > 0.75 * max(radius for _, radius in profile)


def test_what_comes_to_a_point_keeps_it() -> None:
    view, mask = seen_from_above(0.004, 0.15)
    made = revolved(view, mask, Base(0.0, 2.0, 0.0))
    assert made is not None
    profile = made[0].profile
    assert profile[-1][1] < 0.12 * max(radius for _, radius in profile)


def test_a_flat_plate_from_above_is_no_drum() -> None:
    """A cone .2 m high on a plate of a centimetre: both are seen as one silhouette."""
    view, cone = seen_from_above(0.01, 0.06)
    around = np.linspace(0, 2 * math.pi, 80)
    plate = np.zeros(cone.shape, np.uint8)
    rims = [
        np.column_stack([0.15 * np.cos(around), 2 + 0.15 * np.sin(around), np.full(80, z)])
        for z in (0.0, 0.01)
    ]
    hull = cv2.convexHull(view.project(np.vstack(rims))[0].astype(np.float32))
    cv2.fillConvexPoly(plate, hull.round().astype(np.int32), 1)
    made = revolved(view, cone | (plate > 0), Base(0.0, 2.0, 0.0))
    assert made is not None
    profile = np.array(made[0].profile)
    height = profile[:, 0] - profile[0, 0]
    wide = height[profile[:, 1] > 0.11]
    # Read row by row the plate was half as high as it is seen.
    assert np.ptp(wide) < 0.035
    assert np.interp(0.1, height, profile[:, 1]) == pytest.approx(0.035, abs=0.01)
