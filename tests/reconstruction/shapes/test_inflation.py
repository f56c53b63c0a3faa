"""Bodies made from a silhouette stand on the ground as the picture shows them."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
import trimesh

from physagent_studio.knowledge import usual_size
from physagent_studio.knowledge.things import UNKNOWN
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Inflated
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.shapes.footing import stands
from physagent_studio.reconstruction.shapes.forms import forms, inflated_form
from physagent_studio.reconstruction.shapes.inflation import (
    inflated_mesh,
    natural_depth,
    upright_extent,
)
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.sheets import sheet_of, thickness
from physagent_studio.reconstruction.supports.stances import foot_of


def _upright_thing(camera, draw) -> np.ndarray:
    canvas = np.zeros((camera.size[1], camera.size[0]), np.uint8)
    draw(canvas)
    return canvas.astype(bool)


@pytest.mark.parametrize("off", [-1.0, 0.0, 1.0])
def test_what_stands_on_feet_stands_wherever_it_is_seen(off):
    """A board on two wheels with a pole, seen at an angle: both wheels touch the ground."""
    camera = Camera.from_horizon((640, 480), 40, 1.4, focal=620.0)
    yaw = 0.5
    ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    middle = np.array([off, 4.0, 0.0])

    def at(along, up):
        spot = middle + along * ahead + np.array([0.0, 0.0, up])
        return np.round(camera.project(spot[None])[0][0]).astype(int).tolist()

    def draw(canvas):
        for along in (-0.5, 0.5):
            cv2.circle(canvas, at(along, 0.12), 14, 1, -1)
        cv2.line(canvas, at(-0.5, 0.12), at(0.5, 0.12), 1, 6)
        cv2.line(canvas, at(0.45, 0.1), at(0.4, 1.0), 1, 6)

    mask = _upright_thing(camera, draw)
    usual = replace(usual_size("kick scooter"), depth=0.1)
    foot = foot_of(mask)
    spot = on_plane(camera, [foot], 0.0)[0]
    form = forms(camera, mask, Base(float(spot[0]), float(spot[1]), 0.0), usual, "inflated")[0]
    low = form.mesh.vertices[:, 2].min()
    base = form.mesh.vertices[form.mesh.vertices[:, 2] < low + 1e-3]
    assert stands(form.mesh.vertices, np.zeros(3))
    assert np.ptp(base[:, :2] @ ahead[:2]) > 0.8
    assert form.iou > 0.7


def test_a_body_with_a_round_foot_gets_a_base_to_stand_on():
    camera = Camera.from_horizon((640, 480), 100, 1.0, focal=600.0)
    mask = _upright_thing(camera, lambda c: cv2.ellipse(c, (330, 300), (25, 80), 0, 0, 360, 1, -1))
    width, depth, height = upright_extent(mask, camera, natural_depth(mask))
    mesh = inflated_mesh(mask, camera, Inflated(size=(width, depth, height)))
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx((width, depth, height))
    assert stands(mesh.vertices, np.zeros(3))
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert solid.is_watertight
    assert solid.volume > 0


@pytest.mark.parametrize("slope", [0, 1])
def test_a_sliver_of_a_mask_still_gets_a_body(slope):
    mask = np.zeros((480, 832), bool)
    for column in range(300):
        mask[200 + slope * column // 2, 200 + column] = True
    sheet = sheet_of(mask)
    assert len(sheet.faces)
    assert np.isfinite(sheet.pixels).all()


@pytest.mark.parametrize("radius", [60, 100])
def test_the_body_of_a_disc_is_a_ball_up_to_its_outline(radius):
    """Next to the outline, where its distance from the grid's cells matters most."""
    rows, columns = np.mgrid[:300, :300] + 0.5 - 150
    sheet = sheet_of(np.hypot(rows, columns) < radius)
    away = sheet.pixels - 150
    off = np.hypot(*away.T)
    ball = np.sqrt(np.maximum(radius**2 - off**2, 1))
    upper = (away[:, 1] < -0.2 * radius) & ~sheet.rim
    ratio = sheet.swell / ball / np.median((sheet.swell / ball)[upper & (off < 0.8 * radius)])
    rim = ratio[upper & (off > 0.97 * radius)]
    # Its last two pixels: the outline of a mask is known to half a pixel.
    assert rim.mean() == pytest.approx(1, abs=0.15)
    assert rim.std() < 0.1


def test_what_is_narrow_is_a_tube_and_stays_round_when_the_body_is_flattened():
    """A round belly with a long neck: no thin part is thicker than it is wide, or pressed flat."""
    mask = np.zeros((300, 300), bool)
    rows, columns = np.mgrid[:300, :300] + 0.5 - 150
    mask[np.hypot(rows - 60, columns) < 60] = True
    mask[20:170, 142:158] = True
    sheet = sheet_of(mask)
    neck = (sheet.pixels[:, 1] > 40) & (sheet.pixels[:, 1] < 140)
    assert sheet.swell.max() == pytest.approx(60, rel=0.05)
    assert sheet.swell[neck].max() == pytest.approx(8, abs=1.0)
    flat = thickness(sheet, 15.0)
    assert flat.max() == pytest.approx(15.0, rel=0.01)
    assert flat[neck].max() > 0.9 * sheet.swell[neck].max()


@pytest.mark.parametrize(("name", "straight"), [("toy_lorry", True), ("figurine", False)])
def test_what_drives_is_cut_straight_through_and_stands_on_its_sides(name, straight):
    """However high its body is: one that bellies rolls over at the first bump."""
    camera = Camera.from_horizon((640, 480), 100, 1.0, focal=600.0)
    mask = _upright_thing(camera, lambda c: cv2.rectangle(c, (250, 240), (410, 360), 1, -1))
    spot = on_plane(camera, [foot_of(mask)], 0.0)[0]
    base = Base(float(spot[0]), float(spot[1]), 0.0, 1.0)
    form = next(
        f for f in forms(camera, mask, base, usual_size(name), "inflated") if f.kind == "inflated"
    )
    assert isinstance(form.shape, Inflated)
    assert form.shape.straight is straight


def test_a_person_is_half_as_deep_as_wide_and_faces_the_view_though_making_a_step():
    """Round, a chest would be a barrel; across two feet at a step, one would stand turned."""
    camera = Camera.from_horizon((640, 480), 100, 1.0, focal=600.0)

    def draw(canvas):
        cv2.ellipse(canvas, (320, 230), (32, 60), 0, 0, 360, 1, -1)
        cv2.line(canvas, (310, 270), (296, 352), 1, 16)
        cv2.line(canvas, (330, 270), (348, 362), 1, 16)

    mask = _upright_thing(camera, draw)
    spot = on_plane(camera, [foot_of(mask)], 0.0)[0]
    base = Base(float(spot[0]), float(spot[1]), 0.0)
    shape = forms(camera, mask, base, usual_size("woman"), "inflated")[0].shape
    assert isinstance(shape, Inflated)
    assert shape.facing
    assert not shape.straight
    assert shape.size[1] == pytest.approx(0.5 * shape.size[0], rel=0.1)


@pytest.mark.parametrize(("opening", "turned"), [(12, False), (60, True)])
def test_two_feet_of_what_is_about_as_deep_as_wide_tell_its_turn_where_they_are_legs(
    opening, turned
):
    """What sits low has one foot in front of the other without being turned."""
    camera = Camera.from_horizon((640, 480), 60, 1.0, focal=600.0)
    mask = np.zeros((480, 640), bool)
    mask[200 : 340 - opening, 260:380] = True
    mask[300:340, 260:285], mask[300:320, 355:380] = True, True
    form = inflated_form(camera, mask, Base(0.0, 2.0, 0.0), UNKNOWN)
    assert isinstance(form.shape, Inflated)
    assert form.shape.facing is not turned
