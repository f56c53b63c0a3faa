"""Deep things stand on posts where their silhouette shows legs."""

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Inflated, Sphere
from physagent_studio.reconstruction.shapes.inflation import inflated_mesh, seen_mesh
from physagent_studio.reconstruction.shapes.legs import split_legs
from physagent_studio.reconstruction.shapes.meshes import volume_and_centre
from physagent_studio.simulation import simulate

ROWS, COLUMNS = np.mgrid[:240, :320]


def _table(legs=(70, 250), width=16):
    mask = (abs(ROWS - 100) < 10) & (abs(COLUMNS - 160) < 105)
    for middle in legs:
        mask |= (ROWS > 100) & (ROWS < 190) & (abs(COLUMNS - middle) < width / 2)
    return mask


def _camera():
    focal = 500.0
    row = 120 - focal * math.tan(math.radians(8))
    return Camera.from_horizon((320, 240), row, 1.0, focal=focal)


def test_legs_are_told_from_a_body():
    body, legs = split_legs(_table())
    assert len(legs) == 2
    assert not body[150:].any()
    assert all(leg[185].any() and leg[105].any() for leg in legs)
    assert np.array_equal(body | legs[0] | legs[1], _table())
    assert len(split_legs(_table((70, 130, 190, 250)))[1]) == 4


@pytest.mark.parametrize(
    "mask",
    [
        np.hypot(ROWS - 120, COLUMNS - 160) < 60,
        (abs(ROWS - 120) < 50) & (abs(COLUMNS - 160) < 60),
        _table((160,)),
        _table((110, 210), 90),
    ],
    ids=["ball", "box", "one leg", "a wide arch"],
)
def test_what_has_no_legs(mask):
    same, legs = split_legs(mask)
    assert legs == []
    assert np.array_equal(same, mask)


def test_a_stool_seen_from_above_stands_on_the_legs_behind_as_well():
    """Those seem to end higher; on the one in front alone it would fall over."""
    mask = _table((70, 160, 250))
    mask[178:, :120] = mask[178:, 200:] = False
    mesh = inflated_mesh(mask, _camera(), Inflated(size=(1.2, 0.7, 0.6)))
    low = mesh.vertices[mesh.vertices[:, 2] < mesh.vertices[:, 2].min() + 0.02]
    assert np.ptp(low[:, 0]) > 0.9


@pytest.mark.parametrize(("legs", "rows"), [((100, 220), 2), ((100, 160, 220), 1)])
def test_what_is_drawn_has_legs_behind_unless_the_photo_shows_them(legs, rows):
    mask = _table(legs, 10) & (abs(COLUMNS - 160) < 70)
    mask |= (abs(ROWS - 70) < 40) & (abs(COLUMNS - 160) < 70)
    camera, shape = _camera(), Inflated(size=(1.0, 0.8, 1.0), straight=True)
    body = inflated_mesh(mask, camera, shape).vertices + np.array([0, 3.0, 0.5])
    vertices, _ = seen_mesh(mask, camera, shape, body)
    low = np.sort(vertices[camera.project(vertices)[0][:, 1] > 150, 1])
    assert 1 + (np.diff(low) > 0.2).sum() == rows


def test_a_table_on_two_seen_legs_stands_on_four_and_a_ball_rolls_under_it_either_way():
    size = (1.2, 0.7, 0.6)
    mesh = inflated_mesh(_table(), _camera(), Inflated(size=size))
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx(size, rel=1e-6)
    volume, centre = volume_and_centre(mesh.vertices, mesh.faces)
    assert 0 < volume < 0.4 * math.prod(size)
    assert np.abs(centre).max() < 1e-6
    table = thing("table", Inflated(size=size), (0, 0, -mesh.vertices[:, 2].min()), density=600)
    for go, start in (((2.0, 0, 0), (-1.0, 0, 0.1)), ((0, 2.0, 0), (0, -1.0, 0.1))):
        ball = thing("ball", Sphere(radius=0.1), start, density=50)
        action = SetVelocity(id="go", name="ball", velocity=go)
        clip = program([table, ball], [ground()], [action], seconds=1.4)
        path = simulate(clip, {"table": mesh}).positions
        assert np.abs(path[-1, 0] - path[0, 0]).max() < 2e-3
        assert np.linalg.norm(path[-1, 1] - path[0, 1]) > 1.5
