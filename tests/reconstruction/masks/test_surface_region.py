"""A clicked top is found as far as its edges go, whatever is drawn on it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.surface_region import with_surface
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate


def planked(seed: int) -> tuple[Image, BoolArray]:
    """A picture of a top of planks that leaves it to the left, before a wall and a floor."""
    rng = np.random.default_rng(seed)
    wall, floor, wood = ((rng.uniform(60, 220, 3)) for _ in range(3))
    if np.abs(wood - wall).max() < 50 or np.abs(wood - floor).max() < 50:
        wood = 255 - (wall + floor) / 2
    image = np.empty((360, 480, 3), np.float32)
    image[:150], image[150:] = wall, floor
    right = int(rng.integers(300, 440))
    corners = np.array([[-40, 140], [right, 150], [right + 30, 300], [-40, 320]], np.int32)
    top = cv2.fillConvexPoly(np.zeros((360, 480), np.uint8), corners, 1) > 0
    image[top] = wood
    for row in range(150, 330, int(rng.integers(14, 30))):
        line = cv2.line(np.zeros((360, 480), np.uint8), (0, row), (480, row + 8), 1, 1) > 0
        image[line & top] = wood * 0.9
    image += rng.normal(0, 4, image.shape)
    soft = cv2.GaussianBlur(np.clip(image, 0, 255).astype(np.uint8), (0, 0), 0.8)
    return np.asarray(soft, np.uint8), top


@pytest.mark.parametrize("seed", range(6))
def test_a_top_of_planks_is_found_whole_from_one_click(seed: int) -> None:
    image, top = planked(seed)
    plank = np.zeros_like(top)
    plank[200:214, 60:160] = True
    found = with_surface(
        image,
        Grounding(points=(Click(x=100.0, y=207.0),)),
        [Candidate(plank, 0.4, "map")],
    )
    assert found[0].method == "surface"
    assert iou(found[0].mask, top) > 0.9
    assert found[1].method == "map"


def test_clicks_beside_it_keep_it_off_and_what_is_bounded_better_stays_first() -> None:
    image, top = planked(0)
    whole = [Candidate(top, 0.4, "map")]
    click = Click(x=100.0, y=207.0)
    assert with_surface(image, Grounding(points=(click,)), whole)[0].method == "map"
    beside = Click(x=160.0, y=209.0, label=0)
    found = with_surface(image, Grounding(points=(click, beside)), [])
    assert not any(one.mask[209, 160] for one in found)
