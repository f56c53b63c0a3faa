"""Shadows that lie apart from things in the air leave the ground; where none lies nothing does."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.plates import SIZE, TEXTURES, WALL
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.background.detached_shadows import detached
from physagent_studio.reconstruction.background.plate import background, taken_out
from physagent_studio.reconstruction.background.surfaces import surfaces
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image

SEEDS = range(6)


@dataclass(frozen=True)
class Above:
    """A thing in the air over textured ground, with and without its shadow on it."""

    seen: Image
    truth: Image
    mask: BoolArray
    shade: BoolArray
    camera: Camera


def above(texture: str, seed: int, dark: float) -> Above:
    """A ball that keeps `dark` of the sun's light from a spot beside what is below it."""
    rng = np.random.default_rng(seed)
    pitch = math.radians(rng.uniform(14, 26))
    focal = SIZE[1] / 2 / math.tan(math.radians(22.5))
    camera = Camera.from_horizon(SIZE, SIZE[1] / 2 - focal * math.tan(pitch), 1.0, focal=focal)
    rows, columns = np.indices((SIZE[1], SIZE[0]))
    rays = camera.rays(np.stack([columns + 0.5, rows + 0.5], -1).reshape(-1, 2).astype(float))
    down = np.where(rays[:, 2] < -1e-3, -rays[:, 2], np.nan)
    ground = np.nan_to_num(rays[:, :2] / down[:, None], nan=-1.0).reshape(*rows.shape, 2)
    floor = (ground[..., 1] > 0) & (ground[..., 1] < WALL)
    wall = np.array([168.0, 164, 158]) + rng.uniform(-25, 25, 3)
    truth = np.where(floor[..., None], TEXTURES[texture](ground[..., 0], ground[..., 1], rng), wall)
    truth = cv2.GaussianBlur(truth, (0, 0), 0.6)
    radius = rng.uniform(0.06, 0.11) * SIZE[1]
    x, y = rng.uniform(0.3, 0.7) * SIZE[0], rng.uniform(0.25, 0.4) * SIZE[1]
    mask = (columns - x) ** 2 + (rows - y) ** 2 < radius**2
    at = (x + rng.uniform(-1.4, 1.4) * radius, rng.uniform(0.72, 0.85) * SIZE[1])
    high = rng.uniform(0.3, 0.5) * radius
    shade = ((columns - at[0]) / radius) ** 2 + ((rows - at[1]) / high) ** 2 < 1
    soft = cv2.GaussianBlur(shade.astype(float), (0, 0), 1.5)[..., None]
    seen = truth * (1 - dark * soft * np.array([1.05, 1.0, 0.85]))
    seen[mask], bare = (210.0, 60, 40), truth.copy()
    noise = rng.normal(0, 1.5, seen.shape)
    return Above(_image(seen + noise), _image(bare + noise), mask, shade, camera)


def _image(values: np.ndarray) -> Image:
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


def left(item: Above, *, told: bool) -> float:
    """Grey levels by which a plate is off in the shadow. told: whether it knows what is aloft."""
    aloft = [item.mask] if told else []
    plate = background(item.seen, [item.mask], camera=item.camera, aloft=aloft)
    return float(np.abs(plate.astype(float) - item.truth)[item.shade].mean())


def kept(item: Above, *, told: bool) -> float:
    """The same of what a plate keeps of the photo; what it fills is not off."""
    faces = surfaces(item.seen, item.mask, item.camera, ())
    hole, _ = taken_out(item.seen, [item.mask], faces, aloft=[item.mask] if told else [])
    off = np.abs(item.seen.astype(float) - item.truth).mean(-1)
    return float(np.where(hole, 0, off)[item.shade].mean())


@pytest.mark.parametrize("texture", sorted(TEXTURES))
def test_the_shadow_of_a_thing_in_the_air_is_taken_out_with_it(texture: str) -> None:
    items = [above(texture, seed, 0.5) for seed in SEEDS]
    before, after = (np.array([kept(item, told=told) for item in items]) for told in (False, True))
    assert before.min() > 20
    assert np.count_nonzero(after < 0.1 * before) >= len(SEEDS) - 1


@pytest.mark.parametrize(
    ("texture", "seeds"),
    [
        ("lane", SEEDS[:1]),
        *(pytest.param(texture, SEEDS, marks=pytest.mark.slow) for texture in sorted(TEXTURES)),
    ],
)
def test_what_is_behind_it_is_filled(texture: str, seeds: range) -> None:
    items = [above(texture, seed, 0.5) for seed in seeds]
    before, after = (np.array([left(item, told=told) for item in items]) for told in (False, True))
    assert np.median(after) < 0.45 * np.median(before)
    assert np.count_nonzero(after < 0.7 * before) >= len(seeds) - 1


@pytest.mark.parametrize("texture", sorted(TEXTURES))
def test_ground_without_a_shadow_stays_as_it_is(texture: str) -> None:
    same = 0
    for seed in SEEDS:
        item = above(texture, seed, 0.0)
        faces = surfaces(item.seen, item.mask, item.camera, ())
        # What is taken out is all that a plate knows of what is aloft.
        plain, told = (
            taken_out(item.seen, [item.mask], faces, aloft=aloft) for aloft in ((), [item.mask])
        )
        same += all(map(np.array_equal, plain, told))
    assert same >= len(SEEDS) - 1


@pytest.mark.parametrize(("seed", "gap"), [(0, 30), (0, 33)])
def test_what_is_dark_between_pale_things_is_no_shadow(seed: int, gap: int) -> None:
    item = above("boards", seed, 0.0)
    photo = item.seen.copy()
    x = int(np.nonzero(item.mask)[1].mean())
    high = slice(round(0.5 * SIZE[1]), round(0.7 * SIZE[1]))
    for side in (slice(x - gap // 2 - 70, x - gap // 2), slice(x + gap // 2, x + gap // 2 + 70)):
        photo[high, side] = (214, 200, 176)
    photo[high.start : high.stop - 8, x - 14 : x + 14] = (62, 58, 56)
    faces = surfaces(photo, item.mask, item.camera, ())
    assert not detached(photo, [item.mask], item.mask, faces).any()
