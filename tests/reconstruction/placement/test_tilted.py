"""Things that rest on a slope are tilted with it."""

import math

import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.cover import movers
from physagent_studio.benchmark.reconstruction.synthetic import TrueMasks
from physagent_studio.program.rotations import about_axis, matrix_of, multiply
from physagent_studio.program.rotations import about_up as yawed
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Box,
    Click,
    Grounding,
    Ramp,
    SceneObject,
    SceneState,
    Support,
)
from physagent_studio.reconstruction import mesh_of, photo_hash, reconstruct
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.supports.ramps import height_at
from physagent_studio.records.case import Case

pytestmark = pytest.mark.usefixtures("unfilled")

CAMERA = Camera.from_horizon((640, 480), 60, 1.1, focal=620.0, source="given", confirmed=True)
CLICK = Grounding(points=(Click(x=320.0, y=240.0),))


def _seen(ramp: Ramp, along: float, name: str, yaw: float = 0.0):
    """A case that shows a box on a ramp, its state with the ramp given, and the box."""
    slope = math.atan2(ramp.rise, ramp.run)
    cos, sin = math.cos(ramp.yaw), math.sin(ramp.yaw)
    turn = about_axis((sin, -cos, 0.0), slope)
    foot = np.array([ramp.toe[0] + along * cos, ramp.toe[1] + along * sin, 0.0])
    foot[2] = height_at(ramp, float(foot[0]), float(foot[1])) or 0.0
    size = (0.26, 0.2, 0.16)
    place = foot + matrix_of(turn) @ (0, 0, size[2] / 2)
    truth = SceneObject(
        name=name,
        shape=Box(size=size),
        position=(float(place[0]), float(place[1]), float(place[2])),
        rotation=multiply(turn, yawed(yaw)),
    )
    body = mesh_of(Box(size=size))
    mask = silhouette(CAMERA, in_world(truth, body), body.faces)
    image = np.full((480, 640, 3), 150, np.uint8)
    image[mask] = (200, 60, 40)
    case = Case("t", image, photo_hash(image), ((name, CLICK),), (), (), "It slides.")
    ramp_support = Support(name="ramp", shape=ramp, friction=0.9)
    item = SceneObject(name=name, grounding=CLICK, support="ramp", friction=0.9)
    state = SceneState(camera=CAMERA, objects=(item,), supports=(ramp_support,))
    return case, state, truth, mask


@pytest.mark.parametrize("direction", [0.0, math.pi, 0.5])
def test_a_box_on_a_slope_lies_on_it_and_stays(direction):
    x = -0.5 * math.cos(direction)
    ramp = Ramp(toe=(x, 2.6, 0.0), yaw=direction, run=1.0, rise=0.36, width=0.6)
    case, state, truth, mask = _seen(ramp, 0.45, "crate", yaw=0.3)
    found = reconstruct(case, state, segmenter=TrueMasks({"crate": mask}))
    item = found.state.objects[0]
    up = matrix_of(item.rotation)[:, 2]
    true_up = matrix_of(truth.rotation)[:, 2]
    assert math.degrees(math.acos(min(1.0, float(up @ true_up)))) < 1.0
    assert item.position == pytest.approx(truth.position, abs=0.06)
    assert [
        f.text for f in found.findings if f.name in ("reprojection", "contact") and not f.ok
    ] == []
    assert movers(found) == ()


def test_on_the_level_behind_a_slope_and_on_the_floor_things_stand_upright():
    ramp = Ramp(toe=(-0.7, 2.6, 0.0), yaw=0.0, run=0.5, rise=0.2, width=0.6, plateau=0.8)
    case, state, _, mask = _seen(ramp, 0.9, "crate")
    found = reconstruct(case, state, segmenter=TrueMasks({"crate": mask}))
    assert matrix_of(found.state.objects[0].rotation)[2, 2] == pytest.approx(1.0)


def test_a_ball_is_not_tilted_and_a_rerun_keeps_what_was_tilted():
    ramp = Ramp(toe=(-0.5, 2.6, 0.0), yaw=0.0, run=1.0, rise=0.36, width=0.6)
    case, state, _, mask = _seen(ramp, 0.45, "ball")
    found = reconstruct(case, state, segmenter=TrueMasks({"ball": mask}))
    assert matrix_of(found.state.objects[0].rotation)[2, 2] == pytest.approx(1.0)
    case, state, _, mask = _seen(ramp, 0.45, "toy_car")
    found = reconstruct(case, state, segmenter=TrueMasks({"toy_car": mask}))
    again = reconstruct(case, found.state, segmenter=TrueMasks({"toy_car": mask}))
    name = found.state.objects[0].name
    assert again.state.objects == found.state.objects
    assert np.array_equal(again.meshes[name].vertices, found.meshes[name].vertices)
