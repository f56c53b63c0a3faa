"""Path tracing over the plate: the same silhouettes, an untouched background, the same bits."""

from __future__ import annotations

import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest

from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.program.scene.camera import Camera
from physagent_studio.records.scene import Mesh, Scene
from physagent_studio.rendering import Compositor, render_clip
from physagent_studio.rendering.compositor import initial_poses
from physagent_studio.rendering.pbr import PathTracer
from tests.rendering.scenes import FLOOR, SIZE, ball, crate, rollout_of, scene_of, table

SAMPLES = 16


@pytest.fixture
def photographed() -> Scene:
    """A ball and a crate beside a table, before a plate of noise; its principal point is off."""
    camera = Camera.from_horizon(SIZE, 30, 1.2).model_copy(update={"principal": (96.0, 66.0)})
    plate = np.random.default_rng(1).integers(60, 200, (*SIZE[::-1], 3), np.uint8)
    first, first_mesh = ball()
    second, second_mesh = crate()
    support, support_mesh = table(position=(-0.9, 2.8, 0.2), size=(0.5, 0.5, 0.4))
    return scene_of(
        [first, second],
        {"ball": first_mesh, "crate": second_mesh},
        [FLOOR, support],
        {"table": support_mesh},
        camera,
        plate=plate,
    )


def test_without_mitsuba_there_is_one_sentence(two_things, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(BackendMissing, match=r"physagent-studio\[pbr\]"):
        PathTracer(two_things)


def test_a_number_of_samples_is_checked(two_things):
    for samples in (0, 5000):
        with pytest.raises(InputError, match="1 … 4096"):
            PathTracer(two_things, samples)


@pytest.mark.pbr
def test_things_cover_what_the_rasteriser_says_and_the_rest_is_the_plate(photographed: Scene):
    pytest.importorskip("mitsuba", reason="the package mitsuba is not installed")
    tracer, plate = PathTracer(photographed, SAMPLES), photographed.plate
    assert plate is not None
    frame, told = tracer.frame(), Compositor(photographed).frame()
    assert np.array_equal(frame.ids, told.ids)
    world = tracer._batch.placed(*initial_poses(photographed))
    _, cover = tracer._lit(world, np.ones(len(tracer._batch.faces), bool))
    seen, known = cover[..., 0] > 0.5, told.ids >= 0
    assert (seen & known).sum() / (seen | known).sum() >= 0.97
    assert np.abs(frame.rgb[known].astype(float) - plate[known]).mean() > 20
    # The sky above the horizon, and the ground in front and far to the left.
    change = np.abs(frame.rgb.astype(int) - plate)
    assert change[:25].max() <= 2
    assert change[100:, :30].max() <= 2
    # Ground in shadow is darker, and none grows bright.
    brighter = (frame.rgb.astype(int) - plate).mean(-1)[cover[..., 0] == 0]
    assert (brighter < -10).sum() > 60
    assert brighter.max() < 6


@pytest.mark.pbr
def test_a_picture_without_things_is_the_plate(photographed: Scene):
    pytest.importorskip("mitsuba", reason="the package mitsuba is not installed")
    state = photographed.state.model_copy(update={"objects": ()})
    empty = scene_of(
        (), {}, state.supports, dict(photographed.support_meshes), state.camera,
        plate=photographed.plate,
    )  # fmt: skip
    assert empty.plate is not None
    assert np.array_equal(PathTracer(empty, 4).frame().rgb, empty.plate)


@pytest.mark.pbr
def test_a_clip_has_the_same_bits_with_the_same_seed(two_things: Scene):
    pytest.importorskip("mitsuba", reason="the package mitsuba is not installed")
    positions, rotations = initial_poses(two_things)
    places = np.repeat(positions[None], 2, 0)
    places[1, 0, 0] -= 0.4
    rollout = rollout_of(("ball", "crate"), places, np.repeat(rotations[None], 2, 0))
    first, again, other = (
        [
            f.rgb
            for f in render_clip(two_things, rollout, compositor=PathTracer(two_things, 4, seed))
        ]
        for seed in (3, 3, 4)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first[0], other[0])
    assert not np.array_equal(first[0], first[1])


@pytest.mark.pbr
def test_a_texture_lies_as_the_compositor_lays_it():
    pytest.importorskip("mitsuba", reason="the package mitsuba is not installed")
    item, _ = crate(position=(0.0, 2.6, 0.4), size=(0.8, 0.8, 0.8))
    across, up = np.meshgrid([-0.4, 0.4], [0.4, -0.4])
    corners = np.stack([across.ravel(), np.full(4, -0.4), up.ravel()], 1)
    texture = np.zeros((2, 2, 3), np.uint8)
    texture[0, 0], texture[0, 1], texture[1, 0], texture[1, 1] = np.eye(4, 3) * 220 + 20
    texture = np.kron(texture, np.ones((8, 8, 1), np.uint8))
    uv = np.array([(0, 0), (16, 0), (0, 16), (16, 16)], float)
    mesh = Mesh(corners, np.array([(0, 2, 1), (1, 2, 3)], np.int32), uv, texture)
    scene = scene_of([item], {"crate": mesh}, [FLOOR])
    frame, told = PathTracer(scene, SAMPLES).frame(), Compositor(scene).frame()
    inside = told.ids == 0
    bright = told.rgb[inside].max(-1) > 100
    same = frame.rgb[inside].argmax(-1) == told.rgb[inside].argmax(-1)
    assert bright.mean() > 0.6
    assert same[bright].mean() > 0.97


@pytest.mark.pbr
def test_a_texture_that_carries_the_light_of_the_photo_is_lit_once():
    pytest.importorskip("mitsuba", reason="the package mitsuba is not installed")
    item, mesh = ball(position=(0.0, 2.6, 0.5), radius=0.5)
    plate = np.full((*SIZE[::-1], 3), 150, np.uint8)
    plain = scene_of([item], {"ball": replace(mesh, color=(170, 170, 170))}, [FLOOR], plate=plate)
    tracer = PathTracer(plain, 64)
    photo, seen = tracer.frame().rgb, Compositor(plain).frame().ids == 0
    inner = cv2.erode(seen.astype(np.uint8), np.ones((9, 9))) > 0
    lit = photo[inner].astype(float)
    # It has a side in the light and one in shade.
    assert np.ptp(np.percentile(lit, (5, 95))) > 40
    camera = plain.state.camera
    assert camera is not None
    front = mesh.vertices * (1, -1, 1)
    uv = camera.project(np.where(mesh.vertices[:, 1:2] > 0, front, mesh.vertices) + item.position)[
        0
    ]
    painted = replace(mesh, uv=uv, texture=photo)
    scene = scene_of(
        [item], {"ball": painted}, [FLOOR], plate=plate, photo=photo, masks={"ball": seen}
    )
    tracer = PathTracer(scene, 64)
    first = tracer.frame().rgb[inner]
    assert np.abs(first - lit).mean() < 4
    # Turned about the upright it is the same ball in the same light.
    half = np.radians(60) / 2
    turned = tracer.frame([(0.0, 2.6, 0.5)], [(np.cos(half), 0, 0, np.sin(half))]).rgb[inner]
    assert np.abs(turned - lit).mean() < 8
