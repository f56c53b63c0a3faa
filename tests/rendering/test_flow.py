"""Flow: end points lie on the same point of the surface, and what is hidden is known."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.program.rotations import about_axis, matrix_of
from physagent_studio.rendering import Compositor, flow_between
from physagent_studio.rendering.compositor import initial_poses
from tests.rendering.scenes import FLOOR, SIZE, ball, crate, scene_of


def followed(scene, frame, before, after):
    """Where the surface point of each object pixel is in the next frame, from depth and poses."""
    camera = scene.state.camera
    y, x = np.nonzero(frame.ids >= 0)
    pixels = np.stack([x + 0.5, y + 0.5], 1)
    world = np.array(camera.position) + camera.rays(pixels) * frame.depth[y, x, None]
    moved = np.empty_like(world)
    for k, index in enumerate(frame.ids[y, x]):
        local = matrix_of(before[1][index]).T @ (world[k] - before[0][index])
        moved[k] = matrix_of(after[1][index]) @ local + after[0][index]
    target, _ = camera.project(moved)
    return (y, x), target - pixels


def moved_poses(scene):
    positions, rotations = initial_poses(scene)
    after = positions + np.array([[0.12, 0.05, 0.03], [-0.05, 0.1, 0.0]])
    turned = np.array([about_axis((0.2, 1, 0.3), 0.25), about_axis((0, 0, 1), -0.2)])
    return (positions, rotations), (after, turned)


def test_end_points_lie_on_the_same_surface_point(two_things):
    compositor = Compositor(two_things)
    before, after = moved_poses(two_things)
    first, second = compositor.frame(*before), compositor.frame(*after)
    flow = flow_between(first, second)
    where, truth = followed(two_things, first, before, after)
    assert len(truth) > 800
    assert np.abs(truth).max() > 3
    # The truth here comes from the float32 depth image.
    assert np.abs(flow.vectors[where] - truth).max() < 1e-3


def test_background_stands_still_and_is_hidden_by_what_comes(two_things):
    compositor = Compositor(two_things)
    before, after = moved_poses(two_things)
    first, second = compositor.frame(*before), compositor.frame(*after)
    flow = flow_between(first, second)
    background = first.ids < 0
    assert (flow.vectors[background] == 0).all()
    assert np.array_equal(flow.visible[background], second.ids[background] < 0)


def test_no_motion_is_no_flow(two_things):
    compositor = Compositor(two_things)
    frame = compositor.frame()
    flow = flow_between(frame, compositor.frame())
    assert np.abs(flow.vectors).max() < 1e-6
    assert flow.visible.all()


def test_far_side_of_a_turn_is_hidden():
    item, mesh = crate((0.0, 2.6, 0.3), (0.5, 0.5, 0.6))
    scene = scene_of([item], {"crate": mesh}, [FLOOR])
    compositor = Compositor(scene)
    positions, _ = initial_poses(scene)
    first = compositor.frame(positions, np.array([about_axis((0, 0, 1), 0.6)]))
    second = compositor.frame(positions, np.array([about_axis((0, 0, 1), -0.3)]))
    flow = flow_between(first, second)
    seen = flow.visible[first.ids == 0].mean()
    assert 0.3 < seen < 0.9


def test_passing_behind_another_object():
    back, back_mesh = ball((-0.1, 3.4, 0.25), name="back")
    front, front_mesh = crate((0.4, 2.4, 0.4), (0.5, 0.3, 0.8), name="front")
    scene = scene_of([back, front], {"back": back_mesh, "front": front_mesh}, [FLOOR])
    compositor = Compositor(scene)
    positions, rotations = initial_poses(scene)
    first = compositor.frame(positions, rotations)
    after = positions.copy()
    after[0, 0] += 0.7
    second = compositor.frame(after, rotations)
    assert (second.ids == 0).sum() < 0.3 * (first.ids == 0).sum()
    flow = flow_between(first, second)
    mine = first.ids == 0
    y, x = np.nonzero(mine & flow.visible)
    ends = np.stack([x, y], 1) + 0.5 + flow.vectors[y, x]
    near = [second.ids[int(v) - 1 : int(v) + 2, int(u) - 1 : int(u) + 2] for u, v in ends]
    assert all((patch == 0).any() for patch in near)
    assert flow.visible[mine].mean() < 0.4


def test_leaving_the_picture_and_passing_the_camera(two_things):
    compositor = Compositor(two_things)
    positions, rotations = initial_poses(two_things)
    first = compositor.frame(positions, rotations)
    after = positions + np.array([[9.0, 0, 0], [0, -6.0, 0]])
    flow = flow_between(first, compositor.frame(after, rotations))
    assert not flow.visible[first.ids >= 0].any()
    assert np.isfinite(flow.vectors).all()
    assert flow.vectors[first.ids == 0][:, 0].min() > SIZE[0] / 2
    assert (flow.vectors[first.ids == 1] == 0).all()


def test_deformed_vertices_carry_the_flow():
    centre = np.array([0.0, 3.0, 0.3])
    item, mesh = ball((0.0, 3.0, 0.3), 0.3)
    scene = scene_of([item], {"ball": mesh}, [FLOOR])
    compositor = Compositor(scene)
    first = compositor.frame()
    squashed = mesh.vertices * (1.1, 1.1, 0.7) + centre
    second = compositor.frame(vertices={"ball": squashed})
    flow = flow_between(first, second)
    camera = scene.state.camera
    assert camera is not None
    y, x = np.nonzero(first.ids == 0)
    pixels = np.stack([x, y], 1) + np.float64(0.5)
    world = np.array(camera.position) + camera.rays(pixels) * first.depth[y, x, None]
    local = (world - centre) * (1.1, 1.1, 0.7)
    truth = camera.project(local + centre)[0] - pixels
    assert np.abs(flow.vectors[y, x] - truth).max() < 1e-3


@pytest.mark.parametrize("shift", [(0.3, 0.0, 0.0), (0.0, 0.4, 0.1)])
def test_flow_warps_the_next_frame_back(two_things, shift):
    compositor = Compositor(two_things)
    positions, rotations = initial_poses(two_things)
    first = compositor.frame(positions, rotations)
    second = compositor.frame(positions + np.array([shift, (0, 0, 0)]), rotations)
    flow = flow_between(first, second)
    y, x = np.nonzero((first.ids == 0) & flow.visible)
    ends = np.stack([x, y], 1) + 0.5 + flow.vectors[y, x]
    u, v = ends.astype(int).T
    change = np.abs(first.rgb[y, x].astype(int) - second.rgb[v, u]).mean()
    assert change < 6
