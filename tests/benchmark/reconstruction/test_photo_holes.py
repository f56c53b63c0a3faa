"""Holes in pictures where nothing is taken out, and what is filled in."""

from __future__ import annotations

import cv2
import numpy as np

from physagent_studio.benchmark.reconstruction.photo_holes import HOLES, filled, hole_rows, holes_of
from physagent_studio.records.case import Image


def checked(seed: int = 1) -> Image:
    """A floor of tiles before a wall (H, W, 3)."""
    y, x = np.indices((260, 400))
    tiles = np.where(((x // 25 + y // 25) % 2)[..., None], (200.0, 190, 170), (70.0, 90, 110))
    wall = np.broadcast_to((150.0, 140, 130), tiles.shape)
    noise = np.random.default_rng(seed).normal(0, 2, tiles.shape)
    return np.clip(np.where((y < 60)[..., None], wall, tiles) + noise, 0, 255).astype(np.uint8)


def test_holes_are_covered_and_the_rest_is_as_it_was() -> None:
    picture = checked()
    made = holes_of(picture, 3)
    assert len(made) == HOLES
    again = holes_of(picture, 3)
    for (covered, hole), (same, _) in zip(made, again, strict=True):
        assert np.array_equal(covered, same)
        assert np.array_equal(covered[~hole], picture[~hole])
        assert np.abs(covered[hole].astype(float) - picture[hole]).mean() > 5
        assert np.array_equal(filled(covered, hole)[~hole], picture[~hole])


def test_tiles_go_on_where_inpainting_blurs_them() -> None:
    _, ratio = hole_rows([checked()])
    assert float(ratio.value) < 0.8


def test_a_line_goes_on() -> None:
    picture = np.full((260, 400, 3), 120, np.uint8)
    cv2.line(picture, (0, 150), (399, 190), (240, 240, 240), 12)
    covered, hole = picture.copy(), np.zeros((260, 400), bool)
    hole[140:200, 170:230] = True
    covered[hole] = (160, 30, 30)
    made = filled(covered, hole).astype(float)
    assert np.abs(made - picture)[hole].mean() < 6
