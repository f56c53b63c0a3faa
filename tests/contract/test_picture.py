"""Outlines through the camera: what part of them is in the frame, and how far they move in it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.picture import NEAR, Sight, beyond_of, sight_of
from physagent_studio.program import Camera, Clip, EventProgram, PhysicalProgram, SceneState
from physagent_studio.program.rotations import about_axis, matrices_of
from physagent_studio.program.scene.shapes import Placed, outline_of, stretched
from physagent_studio.program.scene.state import (
    Box,
    Cylinder,
    Ellipsoid,
    Floor,
    SceneObject,
    Shape,
    Sphere,
    Support,
)
from physagent_studio.simulation import simulate

FloatArray = NDArray[np.float64]
CAMERA = Camera.from_horizon((320, 200), 60.0, 1.0)

shapes = st.sampled_from(
    [
        Sphere(radius=0.2),
        Box(size=(0.5, 0.2, 0.3)),
        Cylinder(radius=0.12, height=0.5),
        Ellipsoid(radii=(0.3, 0.1, 0.2)),
    ]
)
axis = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)


def placed(shape: Shape, spots: FloatArray, turn: FloatArray | None = None) -> Placed:
    """The shape at spots (T, 3), all turned alike."""
    rotation = np.array([1.0, 0, 0, 0]) if turn is None else turn
    matrices = matrices_of(np.broadcast_to(rotation, (len(spots), 4)))
    return Placed(outline_of(shape), positions=spots, matrices=matrices)


def cloud(body: Placed) -> FloatArray:
    """(K, 3) points of the surface of a body at its first pose, thickly sown."""
    ways = np.random.default_rng(0).normal(size=(3000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return stretched(body, len(ways)).support(ways)


def counted(points: FloatArray, camera: Camera) -> float:
    """Part of the convex outline of projected points in the frame, by counting a fine raster."""
    pixels, _ = camera.project(points)
    hull = ConvexHull(pixels)
    sides = [np.linspace(a, b, 150) for a, b in zip(hull.min_bound, hull.max_bound, strict=True)]
    raster = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
    within = (raster @ hull.equations[:, :2].T + hull.equations[:, 2] <= 0).all(axis=1)
    seen = ((raster >= 0) & (raster <= camera.size)).all(axis=1)
    return float((within & seen).sum() / within.sum())


@settings(max_examples=25, deadline=None)
@given(
    shapes,
    axis,
    st.floats(0, 3),
    st.floats(-0.1, 1.1),
    st.floats(-0.1, 1.1),
    st.floats(2.5, 8.0),
)
def test_the_share_in_the_frame_is_what_counting_gives(
    shape: Shape, way: tuple[float, float, float], angle: float, x: float, y: float, away: float
) -> None:
    pixel = np.array([[x * CAMERA.size[0], y * CAMERA.size[1]]])
    spot = np.array(CAMERA.position) + away * CAMERA.rays(pixel)
    turn = np.array(about_axis(way, angle))
    body = placed(shape, spot, turn)
    # Two frames are the least that a clip has.
    share = sight(shape, np.repeat(spot, 2, axis=0), turn).share[0]
    assert share == pytest.approx(counted(cloud(body), CAMERA), abs=0.03)


def test_the_share_is_all_within_and_nothing_outside_and_half_on_the_rim() -> None:
    pixels = np.array([[160.0, 100.0], [0.0, 100.0], [320.0, 100.0], [160.0, 200.0], [-60.0, 100]])
    spots = np.array(CAMERA.position) + 5.0 * CAMERA.rays(pixels)
    shares = sight(Sphere(radius=0.1), spots).share
    assert shares == pytest.approx([1.0, 0.5, 0.5, 0.5, 0.0], abs=0.03)


def test_what_is_behind_the_camera_is_not_in_the_picture() -> None:
    ahead = CAMERA.matrix[:, 2]
    spots = np.array(CAMERA.position) + np.outer([3.0, -0.01, -3.0], ahead)
    assert sight(Sphere(radius=0.2), spots).share.tolist() == [1.0, 0.0, 0.0]
    beyond = beyond_of(placed(Sphere(radius=0.2), spots), CAMERA)
    assert np.isinf(beyond).tolist() == [False, True, True]


@settings(max_examples=25, deadline=None)
@given(
    shapes, axis, st.floats(0, 3), st.floats(-0.1, 1.1), st.floats(-0.1, 1.1), st.floats(2.5, 8.0)
)
def test_how_far_it_reaches_beyond_the_frame_is_what_its_surface_shows(
    shape: Shape, way: tuple[float, float, float], angle: float, x: float, y: float, away: float
) -> None:
    pixel = np.array([[x * CAMERA.size[0], y * CAMERA.size[1]]])
    spot = np.array(CAMERA.position) + away * CAMERA.rays(pixel)
    body = placed(shape, spot, np.array(about_axis(way, angle)))
    pixels, _ = CAMERA.project(cloud(body))
    over = max(float(np.maximum(-pixels, pixels - np.array(CAMERA.size)).max()), 0.0)
    expected = over / float(np.ptp(pixels, axis=0).max())
    assert beyond_of(body, CAMERA)[0] == pytest.approx(expected, abs=0.03)


def sight(shape: Shape, spots: FloatArray, turns: FloatArray | None = None) -> Sight:
    """How a thing at spots (F, 3), with rotations (F, 4), is seen."""
    item = SceneObject(name="thing", shape=shape, position=(0, 4, 0.5), support="air")
    floor = Support(name="floor", shape=Floor())
    frames = len(spots)
    program = PhysicalProgram(
        clip=Clip(frames=frames, steps_per_frame=1),
        scene=SceneState(camera=CAMERA, objects=(item,), supports=(floor,)),
        event=EventProgram(),
    )
    rollout = simulate(program, {})
    rollout.positions[:, 0] = spots
    rollout.rotations[:, 0] = np.array([1.0, 0, 0, 0]) if turns is None else turns
    found = sight_of(Facts.of(program, rollout), "thing")
    assert found is not None
    return found


def test_a_ball_is_followed_by_its_middle_alone() -> None:
    angles = np.linspace(0, 2, 6)
    turns = np.array([about_axis((0, 1, 0), a) for a in angles])
    spots = np.tile([0.0, 4.0, 1.0], (6, 1))
    turning = sight(Sphere(radius=0.2), spots, turns)
    assert turning.marks.shape == (6, 1, 2)
    assert turning.steps == pytest.approx(np.zeros(5), abs=1e-12)


def test_a_spinning_top_stands_still_and_a_spinning_box_does_not() -> None:
    angles = np.linspace(0, 2, 6)
    turns = np.array([about_axis((0, 0, 1), a) for a in angles])
    spots = np.tile([0.0, 4.0, 1.0], (6, 1))
    top = sight(Cylinder(radius=0.2, height=0.3), spots, turns)
    box = sight(Box(size=(0.4, 0.4, 0.3)), spots, turns)
    assert top.steps == pytest.approx(np.zeros(5), abs=1e-9)
    assert box.steps.min() > 0.002


def test_a_step_is_measured_in_widths_of_the_picture() -> None:
    rng = np.random.default_rng(3)
    across = rng.uniform(0.01, 0.1, 5)
    x = np.concatenate([[0.0], np.cumsum(across)])
    spots = np.stack([x, np.full(6, 4.0), np.full(6, 1.0)], axis=1)
    pixels, _ = CAMERA.project(spots)
    expected = np.linalg.norm(np.diff(pixels, axis=0), axis=1) / CAMERA.size[0]
    assert sight(Sphere(radius=0.1), spots).steps == pytest.approx(expected, rel=1e-6)


def test_steps_out_of_the_picture_do_not_count() -> None:
    x = np.array([0.0, 1.0, 4.0, 30.0, 80.0])
    spots = np.stack([x, np.full(5, 4.0), np.full(5, 1.0)], axis=1)
    seen = sight(Sphere(radius=0.1), spots)
    assert seen.share[:2] == pytest.approx([1.0, 1.0])
    assert seen.share[2:].max() == 0.0
    assert seen.steps[0] > 0.1
    assert seen.steps[1:].tolist() == [0.0, 0.0, 0.0]


def test_the_middle_and_the_length_are_those_of_the_silhouette() -> None:
    spots = np.array([[0.0, 4.0, 1.0], [0.0, 8.0, 1.0]])
    seen = sight(Sphere(radius=0.2), spots)
    expected, depth = CAMERA.project(spots)
    assert seen.centre == pytest.approx(expected, abs=1.0)
    assert seen.length == pytest.approx(0.4 * CAMERA.focal / depth, rel=0.03)


def test_nothing_is_seen_where_there_is_no_camera() -> None:
    item = SceneObject(name="thing", shape=Sphere(radius=0.1), position=(0, 4, 0.1))
    state = SceneState(objects=(item,), supports=(Support(name="floor", shape=Floor()),))
    program = PhysicalProgram(clip=Clip(frames=3), scene=state)
    assert sight_of(Facts.of(program, simulate(program, {})), "thing") is None


def test_the_nearest_that_is_seen_is_a_finger_wide() -> None:
    spot = np.array([CAMERA.position]) + (NEAR + 0.02) * CAMERA.matrix[:, 2]
    assert sight(Sphere(radius=0.01), np.repeat(spot, 2, axis=0)).share[0] > 0
