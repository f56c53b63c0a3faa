"""Tables in boxes: the top fills its box, round or not, whatever lies on it."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Slab
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.supports.boxed_tops import round_top, within_box
from physagent_studio.reconstruction.supports.seen_ends import Shown

SIZE = (640, 480)
CAMERA = Camera.from_horizon(SIZE, 40, 1.5, focal=600.0)
TOP = 0.75
WRONG = Slab(position=(0.3, 2.0, TOP - 0.02), size=(0.5, 0.3, 0.04), yaw=0.3)


def places_of(slab):
    """(4, 2) corners of a slab's top."""
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    half = np.array(slab.size[:2]) / 2
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
    return corners @ np.array([[cos, sin], [-sin, cos]]) + slab.position[:2]


def seen(places):
    """Pixels of places (N, 2) on the plane of the top."""
    return CAMERA.project(np.column_stack([places, np.full(len(places), TOP)]))[0]


def pictured(outline, legs=(), cloth=None, seed=0):
    """A table with a top of that outline (N, 2), m, in grain, and a box around all of it."""
    image = np.full((*SIZE[::-1], 3), (150, 160, 150), np.uint8)
    pixels = seen(outline)
    for x, y in seen(np.array(legs).reshape(-1, 2)):
        cv2.line(image, (int(x), int(y)), (int(x), int(y) + 90), (90, 60, 40), 7)
    cv2.fillPoly(image, [np.round(pixels + np.array([0, 6])).astype(np.int32)], (80, 50, 30))
    cv2.fillPoly(image, [np.round(pixels).astype(np.int32)], (120, 80, 50))
    if cloth is not None:
        cv2.fillPoly(image, [np.round(seen(cloth)).astype(np.int32)], (220, 220, 240))
    grain = np.random.default_rng(seed).normal(0, 4, image.shape)
    image = np.clip(image + grain, 0, 255).astype(np.uint8)
    low, high = pixels.min(0), pixels.max(0)
    ends = (low[0] - 12, low[1] - 10, high[0] + 12, min(high[1] + 110, SIZE[1] - 8.0))
    left, top, right, bottom = (float(side) for side in ends)
    return Shown(image, np.zeros(SIZE[::-1], bool)), (left, top, right, bottom)


def within(shown, box, slab=WRONG, standing=()):
    at = seen(np.array(standing).reshape(-1, 2)) if len(standing) else np.zeros((0, 2))
    return within_box(shown, CAMERA, slab, box, at)


@pytest.mark.parametrize(
    ("size", "yaw", "cloth"),
    [((1.0, 0.6), 0.0, 0.0), ((1.0, 0.6), 0.0, 0.6), ((0.9, 0.7), 0.45, 0.0)],
)
def test_top_fills_its_box_whatever_lies_on_it(size, yaw, cloth):
    table = Slab(position=(0.05, 2.1, TOP - 0.02), size=(*size, 0.04), yaw=yaw)
    corners = places_of(table)
    middle = np.array(table.position[:2])
    lying = middle + cloth * (corners - middle) if cloth else None
    shown, box = pictured(corners, 0.9 * (corners - middle) + middle, lying)
    found = places_of(within(shown, box, standing=[middle]))
    apart = np.linalg.norm(seen(found)[:, None] - seen(corners)[None], axis=2).min(1)
    assert apart.max() < 12


def test_round_top_ends_where_things_go_over_its_rim():
    angle = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    middle, radius = np.array([-0.1, 2.0]), 0.45
    rim = middle + radius * np.stack([np.cos(angle), np.sin(angle)], 1)
    shown, box = pictured(rim, middle + np.array([(-0.3, 0), (0.3, 0)]))
    central = within(shown, box, standing=[middle])
    assert central.position[:2] == pytest.approx(middle, abs=0.03)
    assert central.size[:2] == pytest.approx((2 * radius, 2 * radius), rel=0.12)
    # Behind the middle the rim is nearer on both sides.
    behind = within(shown, box, standing=[middle + np.array([0.0, 0.5 * radius])])
    assert behind.size[0] == pytest.approx(central.size[0] * math.sqrt(0.75), rel=0.05)
    assert behind.size[1] == pytest.approx(central.size[1], rel=0.05)


def test_top_that_fits_stays_as_it_is():
    table = Slab(position=(0.05, 2.1, TOP - 0.02), size=(1.0, 0.6, 0.04))
    shown, box = pictured(places_of(table))
    assert within(shown, box, table, [(0.0, 2.1)]) is table


def test_nothing_to_see_changes_nothing():
    blank = Shown(np.full((*SIZE[::-1], 3), 128, np.uint8), np.zeros(SIZE[::-1], bool))
    box = (100.0, 150.0, 500.0, 400.0)
    assert within(blank, box) is WRONG
    behind = WRONG.model_copy(update={"size": (9.0, 9.0, 0.04)})
    assert within(blank, box, behind) is behind
    # Nor is the top of what is higher than the camera seen.
    shown, box = pictured(places_of(WRONG))
    high = WRONG.model_copy(update={"position": (0.3, 2.0, 1.6)})
    assert within(shown, box, high) is high


def test_same_top_each_time():
    table = Slab(position=(0.05, 2.1, TOP - 0.02), size=(1.0, 0.6, 0.04))
    shown, box = pictured(places_of(table))
    assert within(shown, box) == within(shown, box)


def test_no_pixels_are_no_places():
    assert on_plane(CAMERA, [], TOP).shape == (0, 3)


def test_round_tops_tell_how_flat_they_are_seen_and_others_do_not():
    angle = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    rim = np.array([-0.1, 2.0]) + 0.45 * np.stack([np.cos(angle), np.sin(angle)], 1)
    pixels = seen(rim)
    found = round_top(*pictured(rim))
    assert found is not None
    wide, high = np.ptp(pixels, axis=0)
    assert found.flatness == pytest.approx(high / wide, rel=0.08)
    assert (found.x, found.y) == pytest.approx(tuple((pixels.max(0) + pixels.min(0)) / 2), abs=6)
    table = Slab(position=(0.05, 2.1, TOP - 0.02), size=(1.0, 0.6, 0.04))
    assert round_top(*pictured(places_of(table))) is None
