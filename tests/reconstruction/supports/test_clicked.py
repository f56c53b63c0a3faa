"""Supports from marks: known shapes are projected, clicked and found again."""

from __future__ import annotations

import math

import numpy as np
import pytest

from physagent_studio.knowledge import Usual
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Grounding,
    Mark,
    Ramp,
    SceneState,
    Slab,
    Support,
    Wall,
)
from physagent_studio.reconstruction.camera.scale import FLOOR, Heights, Measured, Scale
from physagent_studio.reconstruction.supports import clicked

CAMERA = Camera.from_horizon((832, 480), 90.0, 1.4, source="given", confirmed=True)


def support(name: str, **parts: list[tuple[float, float, float]]) -> Support:
    """A support whose marks are where its world points are seen."""
    marks = []
    for role, points in parts.items():
        for x, y in CAMERA.project(np.array(points))[0]:
            marks.append(Mark.model_validate({"role": role, "x": float(x), "y": float(y)}))
    return Support(name=name, grounding=Grounding(marks=tuple(marks)))


def corners_of(slab: Slab) -> list[tuple[float, float, float]]:
    """Corners of the upper side, in order round it, the near left one first."""
    half = np.array([*slab.size[:2], 0.0]) / 2
    signs = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    turn = matrix_of(about_up(slab.yaw))
    x, y, z = slab.position
    centre = np.array([x, y, z + slab.size[2] / 2])
    return [tuple(centre + turn @ (half * sign)) for sign in signs]  # type: ignore[misc]


TABLE = Slab(position=(0.2, 3.0, 0.7), size=(1.2, 0.7, 0.05), yaw=0.3)


def test_a_table_from_its_corners():
    found = clicked.shape_of(support("table", top=corners_of(TABLE)), CAMERA, 0.725, 0.05)
    assert isinstance(found, Slab)
    assert found.position == pytest.approx(TABLE.position, abs=1e-6)
    assert found.size == pytest.approx(TABLE.size, abs=1e-6)
    assert found.yaw == pytest.approx(0.3, abs=1e-6)


def test_a_cut_by_the_border_turns_no_table():
    """The right end of the table is outside the picture, and the cut there is its longest side."""
    near_left, far_left = (-0.3, 2.2, 0.7), (-0.3, 3.4, 0.7)
    pixels, _ = CAMERA.project(np.array([near_left, (3.0, 2.2, 0.7), (3.0, 3.4, 0.7), far_left]))
    left, right = pixels[0], pixels[1]
    share = (831 - left[0]) / (right[0] - left[0])
    front = left + share * (right - left)
    share = (831 - pixels[3][0]) / (pixels[2][0] - pixels[3][0])
    back = pixels[3] + share * (pixels[2] - pixels[3])
    marks = tuple(
        Mark(role="top", x=float(x), y=float(y)) for x, y in (left, front, back, pixels[3])
    )
    table = Support(name="table", grounding=Grounding(marks=marks))
    found = clicked.shape_of(table, CAMERA, 0.7, 0.05)
    assert isinstance(found, Slab)
    assert found.yaw == pytest.approx(0.0, abs=1e-6)
    assert found.position[0] - found.size[0] / 2 == pytest.approx(-0.3, abs=1e-6)


def test_the_foot_gives_the_height_at_any_scale():
    corner = corners_of(TABLE)[0]
    table = support("table", top=corners_of(TABLE), foot=[(corner[0], corner[1], 0.0)])
    for height in (1.0, 7.0):
        unit = CAMERA.model_copy(update={"position": (0.0, 0.0, height)})
        rises = clicked.rises_of(SceneState(supports=(table,)), unit)
        assert rises["table"] == pytest.approx(0.725 / 1.4, abs=1e-6)


def test_sizes_on_a_top_of_known_rise_count_for_the_floor():
    cup = Measured("cup", "table", 0.5, Usual(0.1, 0.1))
    ball = Measured("ball", FLOOR, 0.2, Usual(0.22, 0.04))
    told = clicked.on_one_floor([cup, ball], {"table": 0.6})
    assert told[0].plane == FLOOR
    assert told[0].units == pytest.approx(0.2)
    assert told[1] == ball
    assert (told[2].name, told[2].units) == ("table", 0.6)
    heights = clicked.with_rises(Heights(1.5, {FLOOR: 0.0}, Scale()), {"table": 0.6})
    assert heights.tops == {FLOOR: 0.0, "table": pytest.approx(0.9)}


@pytest.mark.parametrize("yaw", [0.0, math.pi, 2.5, -0.6])
def test_a_ramp_from_toe_foot_top_and_end(yaw: float):
    ahead, side = (
        np.array([math.cos(yaw), math.sin(yaw), 0]),
        np.array([-math.sin(yaw), math.cos(yaw), 0]),
    )
    toe, up = np.array([0.1, 3.0, 0.0]), np.array([0, 0, 1.0])
    near = min((1, -1), key=lambda sign: (toe + sign * side * 0.2)[1])
    edge = toe + near * side * 0.2
    ramp = support(
        "ramp",
        toe=[tuple(edge), tuple(toe - near * side * 0.2)],
        foot=[tuple(edge + ahead * 0.8)],
        top=[tuple(edge + ahead * 0.8 + up * 0.3)],
        end=[tuple(edge + ahead * 1.1 + up * 0.3)],
    )
    found = clicked.shape_of(ramp, CAMERA, 0.0, 0.0)
    assert isinstance(found, Ramp)
    assert found.toe == pytest.approx((0.1, 3.0, 0.0), abs=1e-6)
    sizes = (found.run, found.rise, found.width, found.plateau)
    assert sizes == pytest.approx((0.8, 0.3, 0.4, 0.3), abs=1e-6)
    assert math.cos(found.yaw - yaw) == pytest.approx(1.0, abs=1e-9)


def test_without_a_foot_a_ramp_runs_across_the_picture():
    ramp = support("ramp", toe=[(0.5, 3, 0)], top=[(-0.3, 3, 0.4)])
    found = clicked.shape_of(ramp, CAMERA, 0.0, 0.0)
    assert isinstance(found, Ramp)
    assert (found.run, found.rise) == pytest.approx((0.8, 0.4), abs=1e-6)
    assert abs(found.yaw) == pytest.approx(math.pi)
    assert found.toe[1] > 3.0  # The clicked side is the near one.


def test_a_wall_faces_the_camera():
    found = clicked.shape_of(support("back_wall", foot=[(-1, 4, 0), (2, 5, 0)]), CAMERA, 0, 0)
    assert isinstance(found, Wall)
    normal = np.array([math.cos(found.yaw), math.sin(found.yaw)])
    assert normal @ [3, 1] == pytest.approx(0.0, abs=1e-6)
    assert normal @ (np.array([0.0, 0.0]) - found.point[:2]) > 0


def test_the_region_of_a_table_is_inside_its_corners():
    table = support("table", top=corners_of(TABLE))
    region = clicked.region_of(table, (480, 832))
    assert region is not None
    inside, _ = CAMERA.project(np.array([[0.2, 3.0, 0.725]]))
    assert region[int(inside[0, 1]), int(inside[0, 0])]
    assert not region[0, 0]


def test_without_marks_nothing_is_decided():
    for name in ("table", "ramp", "wall", "floor"):
        bare = Support(name=name)
        assert clicked.shape_of(bare, CAMERA, 0.7, 0.05) is None
        assert clicked.region_of(bare, (480, 832)) is None
        assert clicked.profile_of(bare) is None


def test_marks_above_the_horizon_give_no_shape():
    sky = Mark(role="toe", x=100, y=10), Mark(role="top", x=400, y=5)
    ramp = Support(name="ramp", grounding=Grounding(marks=sky))
    assert clicked.shape_of(ramp, CAMERA, 0.0, 0.0) is None


@pytest.mark.parametrize("share", [0.8, 1.0, 2.2])
def test_square_corners_give_the_focal_length(share: float):
    focal = CAMERA.focal * share
    camera = Camera.from_horizon((832, 480), 90.0, 1.4, focal=focal)
    pixels, _ = camera.project(np.array(corners_of(TABLE)))
    marks = tuple(Mark(role="top", x=float(x), y=float(y)) for x, y in pixels)
    table = Support(name="table", grounding=Grounding(marks=marks))
    found = clicked.focal_of(SceneState(horizon=90.0, supports=(table,)), (832, 480), 90.0)
    assert found == pytest.approx(focal, rel=0.03)
    assert clicked.focal_of(SceneState(supports=(table,)), (832, 480), 90.0) is None


def test_corners_that_are_square_for_no_lens_give_none():
    corners = ((100, 300), (700, 310), (380, 200), (360, 200))
    marks = tuple(Mark(role="top", x=x, y=y) for x, y in corners)
    table = Support(name="table", grounding=Grounding(marks=marks))
    assert clicked.focal_of(SceneState(horizon=90.0, supports=(table,)), (832, 480), 90.0) is None
