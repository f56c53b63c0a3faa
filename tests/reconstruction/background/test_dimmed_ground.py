"""Shade on ground of any pattern: found by its light, lifted, and nothing else taken for it."""

import math

import cv2
import numpy as np
import pytest

from physagent_studio.arrays import FloatImage
from physagent_studio.benchmark.scenes.pictures import scene
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.background.dimmed_ground import (
    Shade,
    dimmed,
    semi_global,
)
from physagent_studio.reconstruction.background.plate import background, hole_of
from physagent_studio.reconstruction.background.shift_map import to_level
from physagent_studio.reconstruction.background.surfaces import surfaces
from physagent_studio.reconstruction.switches import without

SIZE = (480, 320)


def test_levels_are_alike_in_neighbours_and_change_where_the_prices_do() -> None:
    rng = np.random.default_rng(4)
    truth = np.zeros((40, 60), int)
    truth[10:30, 20:45] = 3
    prices = rng.uniform(0, 2, (40, 60, 5)).astype(np.float32)
    np.put_along_axis(prices, truth[..., None], 0.3, -1)
    alone = (prices.argmin(-1) == truth).mean()
    together = (semi_global(prices, 0.5, 2.0) == truth).mean()
    assert alone < 0.6
    assert together > 0.97


def _camera() -> Camera:
    focal = SIZE[1] / 2 / math.tan(math.radians(22.5))
    horizon = SIZE[1] / 2 - focal * math.tan(math.radians(22))
    return Camera.from_horizon(SIZE, horizon, 1.0, focal=focal)


def _tiles(camera: Camera, contrast: float) -> FloatImage:
    """A chequered floor (H, W, 3) seen by the camera."""
    rows, columns = np.indices(SIZE[::-1])
    pixels = np.stack([columns + 0.5, rows + 0.5, np.ones(rows.shape)], -1)
    mapped = pixels @ to_level(camera).T
    ground = mapped[..., :2] / np.maximum(mapped[..., 2:], 1e-3)
    odd = np.floor(ground / 0.22).sum(-1) % 2 > 0
    light = np.where(odd, 1.0, contrast)[..., None] * np.array([190.0, 178, 160])
    noise = np.random.default_rng(1).normal(0, 2, light.shape)
    return (light + noise).astype(np.float32)


@pytest.mark.parametrize(
    ("contrast", "shaded", "found"),
    [(0.45, True, True), (0.45, False, False), (0.7, True, True), (0.7, False, False)],
)
def test_shade_on_tiles_is_found_and_dark_tiles_are_none(
    contrast: float, shaded: bool, found: bool
) -> None:
    camera = _camera()
    floor = _tiles(camera, contrast)
    mask = cv2.ellipse(np.zeros(SIZE[::-1], np.uint8), (200, 170), (34, 40), 0, 0, 360, 1, -1) > 0
    shade = cv2.ellipse(np.zeros(SIZE[::-1], np.uint8), (250, 202), (70, 20), 0, 0, 360, 1, -1)
    seen = floor * np.where(shade > 0, 0.6, 1.0)[..., None] if shaded else floor
    photo = np.where(mask[..., None], (200, 40, 40), seen).clip(0, 255).astype(np.uint8)
    hole = hole_of([mask], photo.shape[:2])
    faces = np.zeros(photo.shape[:2], np.int64)
    light = dimmed(photo, [mask], hole, to_level(camera), faces)
    free = (shade > 0) & ~hole
    # What is white keeps its grain: that of the photo at full size, not of the one looked at.
    white = floor[40:][floor[40:].mean(-1) > 170]
    assert (np.abs(light.brightest - np.quantile(white, 0.99, axis=0)) < 3).all()
    if not found:
        assert not light.places.any()
        return
    assert light.places[free].mean() > 0.9
    assert (light.places & (shade == 0)).sum() < 0.5 * free.sum()
    # What is told by its light is as it was before there was shade on it.
    told = free & ~light.edges
    off = np.abs(light.lifted(photo)[told].astype(float) - floor[told]).mean()
    assert told.sum() > 0.3 * free.sum()
    assert off < 10


def test_what_is_lifted_gets_no_brighter_than_lit_ground_and_nothing_darker() -> None:
    photo = np.full((4, 4, 3), 200, np.uint8)
    photo[0] = 250
    dims = np.full((4, 4, 3), 0.5, np.float32)
    lit = Shade(dims, np.zeros((4, 4), bool), np.array([240.0, 230.0, 255.0])).lifted(photo)
    assert (lit[1:] == (240, 230, 255)).all()
    assert (lit[0] == (250, 250, 255)).all()


def test_ground_of_another_colour_that_goes_on_is_no_shade() -> None:
    camera = _camera()
    floor = _tiles(camera, 0.7)
    floor[:, 230:] *= 0.6
    mask = cv2.ellipse(np.zeros(SIZE[::-1], np.uint8), (200, 170), (34, 40), 0, 0, 360, 1, -1) > 0
    photo = np.where(mask[..., None], (200, 40, 40), floor).clip(0, 255).astype(np.uint8)
    hole = hole_of([mask], photo.shape[:2])
    light = dimmed(photo, [mask], hole, to_level(camera), np.zeros(photo.shape[:2], np.int64))
    assert not light.places.any()


@pytest.mark.parametrize("seed", [28])
def test_the_shade_of_drawn_things_leaves_patterned_ground(seed: int) -> None:
    drawn = scene(seed)
    masks = [subject.mask for subject in drawn.subjects]
    free = ~hole_of(masks, drawn.image.shape[:2])
    empty, seen = (
        cv2.GaussianBlur(p.astype(np.float32), (0, 0), 2.0).mean(-1)
        for p in (drawn.emptied(), drawn.image)
    )
    shade = free & (empty - seen > 8)
    left = []
    for off in (["dimmed ground"], []):
        with without(off):
            plate = background(drawn.image, masks, camera=drawn.stage.camera)
        made = cv2.GaussianBlur(plate.astype(np.float32), (0, 0), 2.0).mean(-1)
        left.append(float(np.maximum(empty - made, 0)[shade].mean()))
    assert left[1] < 0.4 * left[0]


def test_what_has_no_ground_in_the_picture_has_no_shade() -> None:
    photo = np.full((80, 120, 3), 120, np.uint8)
    mask = np.zeros((80, 120), bool)
    mask[:, 30:90] = True
    camera = _camera()
    faces = surfaces(photo, mask, Camera.from_horizon((120, 80), 20, 1.0), ())
    light = dimmed(photo, [mask, np.zeros_like(mask)], mask, to_level(camera), faces)
    assert not light.places.any()
    assert (light.lifted(photo) == photo).all()
