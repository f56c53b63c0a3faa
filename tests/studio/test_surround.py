"""The photo around a scene: what lies where, and that its own camera sees it as it was."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.program import Camera
from physagent_studio.studio.scene.surround import surround_of

SIZE = (320, 200)


@pytest.fixture(scope="module")
def camera() -> Camera:
    return Camera.from_horizon(SIZE, 80.0, 1.2, focal=300.0)


def _image() -> np.ndarray:
    rng = np.random.default_rng(3)
    return rng.integers(0, 255, (SIZE[1], SIZE[0], 3), dtype=np.uint8)


def test_what_the_photo_shows_is_seen_where_it_was(camera: Camera) -> None:
    made = surround_of(camera, _image(), 0.0, (), 50.0, 1.0)
    assert made.beyond
    for mesh in made.seen:
        if mesh.texture is None or mesh.texture.shape[:2] != (SIZE[1], SIZE[0]):
            continue
        used = np.unique(mesh.faces)
        pixels, depth = camera.project(np.asarray(mesh.vertices)[used])
        assert (depth > 0).all()
        assert mesh.uv is not None
        assert np.abs(pixels - mesh.uv[used]).max() < 1.0


def test_the_ground_is_level_and_below_the_things(camera: Camera) -> None:
    made = surround_of(camera, _image(), 0.0, (), 50.0, 1.0)
    ground = made.seen[-1]
    used = np.unique(ground.faces)
    heights = np.asarray(ground.vertices)[used, 2]
    assert np.ptp(heights) < 1e-6
    assert -0.01 < heights[0] < 0


def test_the_sky_closes_all_around(camera: Camera) -> None:
    made = surround_of(camera, _image(), None, (), 50.0, 1.0)
    ways = np.asarray(made.beyond[0].vertices) - np.array(camera.position)
    angles = np.sort(np.arctan2(ways[:, 1], ways[:, 0]))
    assert np.diff(angles).max() < 0.2
    assert ways[:, 2].max() > 0.99 * np.linalg.norm(ways[0])
