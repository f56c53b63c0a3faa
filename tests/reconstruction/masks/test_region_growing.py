"""Masks of thin things of one colour that stand in a row on a patterned floor."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.region_growing import regions
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter
from physagent_studio.reconstruction.photo.regions import BoolArray, iou

SIZE = (480, 832)
BARS = {
    "red_bar": (390, (186, 50, 44)),
    "blue_bar": (450, (48, 96, 178)),
    "yellow_bar": (510, (216, 176, 60)),
}
WIDE, TOP, LOW = 18, 224, 334


def _row() -> tuple[NDArray[np.uint8], dict[str, BoolArray]]:
    """Bars on boards before a grey wall, their upper ends lit; and where each one is."""
    draw = np.random.default_rng(4)
    rows, columns = SIZE
    image = np.full((rows, columns, 3), (186, 188, 194), np.float32)
    grain = cv2.GaussianBlur(
        draw.normal(0, 26, (rows, columns)).astype(np.float32), (0, 0), sigmaX=9, sigmaY=3
    )
    boards = np.array([150, 92, 58], np.float32) + 14 * (np.arange(columns) // 70 % 2)[:, None]
    image[210:] = (boards[None] + grain[210:, :, None] * 3)[: rows - 210]
    masks = {}
    for name, (x, colour) in BARS.items():
        mask = np.zeros(SIZE, bool)
        mask[TOP:LOW, x : x + WIDE] = True
        image[mask] = colour
        # The end that is seen from above mirrors the light, so that its colour is paler.
        image[TOP : TOP + 14, x : x + WIDE] = 0.75 * np.array(colour) + 60
        masks[name] = mask
    image += draw.normal(0, 4, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8), masks


def test_bars_in_a_row_are_found_from_a_click_on_their_lit_ends() -> None:
    image, masks = _row()
    clicks = [
        (name, Grounding(points=(Click(x=x + WIDE / 2, y=TOP + 7),)))
        for name, (x, _) in BARS.items()
    ]
    found = EmbeddedSegmenter().segment(image, clicks)
    scores = {name: iou(found[name][0].mask, masks[name]) for name in masks}
    assert min(scores.values()) > 0.8, scores


def test_what_mixes_colours_is_not_cut_down_to_the_one_in_its_name() -> None:
    image, _ = _row()
    stone = np.zeros(SIZE, np.uint8)
    cv2.ellipse(stone, (180, 330), (70, 34), 0, 0, 360, 1, -1)
    image[stone > 0] = (92, 92, 96)
    cv2.ellipse(image, (180, 312), (26, 9), 0, 0, 360, (214, 180, 50), -1)
    clicks = Grounding(points=(Click(x=180, y=342), Click(x=180, y=312)))
    found = EmbeddedSegmenter().segment(image, [("yellow_stone", clicks)])
    assert iou(found["yellow_stone"][0].mask, stone > 0) > 0.85


@pytest.mark.parametrize("thick", [5, 9])
def test_a_region_keeps_the_hole_of_a_ring(thick: int) -> None:
    lab = np.full((160, 240, 3), (180, 130, 140), np.float32)
    ring = np.zeros((160, 240), np.uint8)
    cv2.ellipse(ring, (120, 80), (50, 30), 0, 0, 360, 1, thick)
    lab[ring > 0] = (140, 170, 180)
    best = max(iou(mask, ring > 0) for mask in regions(lab, ((70.0, 80.0),)))
    assert best > 0.95


def test_nothing_grows_without_a_click() -> None:
    assert regions(np.zeros((20, 20, 3), np.float32), ()) == []
