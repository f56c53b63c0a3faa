"""Every kind of shape is found from its own silhouette, without a name, against all the others."""

import math

import numpy as np
import pytest

from physagent_studio.knowledge import UNKNOWN, usual_size
from physagent_studio.program.rotations import about_up, matrix_of, multiply
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Frustum,
    Revolved,
    Sphere,
    Torus,
)
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.shapes.forms import forms
from physagent_studio.reconstruction.shapes.meshes import mesh_of, profile_centre
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.rings import hole_of
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.reconstruction.supports.stances import foot_of

FOCAL = 300.0
CAMERA = Camera.from_horizon((320, 240), 56.0, 1.0, focal=FOCAL)
TO_X = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)
_BOTTLE = [(0.0, 0.08), (0.2, 0.085), (0.25, 0.03), (0.36, 0.028)]
BOTTLE = Revolved(profile=tuple((z - profile_centre(_BOTTLE), r) for z, r in _BOTTLE))
TYRE = Torus(radius=0.15, tube=0.05)

CASES = {
    "sphere": (Sphere(radius=0.15), LEVEL),
    "ellipsoid": (Ellipsoid(radii=(0.2, 0.2, 0.12)), LEVEL),
    "box": (Box(size=(0.3, 0.2, 0.25)), about_up(0.5)),
    "slab": (Box(size=(0.5, 0.35, 0.04)), about_up(0.3)),
    "cylinder": (Cylinder(radius=0.12, height=0.4), LEVEL),
    "frustum": (Frustum(bottom_radius=0.2, top_radius=0.08, height=0.35), LEVEL),
    "capsule": (Capsule(radius=0.08, height=0.5), LEVEL),
    "revolved": (BOTTLE, LEVEL),
    "torus": (TYRE, multiply(about_up(math.pi / 2 + 0.5), TO_X)),
    "thin torus": (Torus(radius=0.3, tube=0.015), multiply(about_up(math.pi / 2), TO_X)),
}


def _drawn(shape, rotation, x=0.1, y=2.5):
    mesh = mesh_of(shape)
    body = mesh.vertices @ matrix_of(rotation).T
    place = np.array([x, y, -body[:, 2].min()])
    return silhouette(CAMERA, body + place, mesh.faces), place


def _base(mask):
    spot = on_plane(CAMERA, [foot_of(mask)], 0.0)[0]
    return Base(float(spot[0]), float(spot[1]), 0.0)


@pytest.mark.parametrize("case", CASES)
def test_the_right_kind_wins_and_is_where_it_was(case):
    shape, rotation = CASES[case]
    mask, place = _drawn(shape, rotation)
    best = forms(CAMERA, mask, _base(mask), UNKNOWN)[0]
    assert best.kind == shape.kind
    assert best.iou > (0.85 if case == "thin torus" else 0.94)
    assert np.abs(np.array(best.position) - place).max() < 0.06


def test_an_outline_like_no_primitive_is_inflated():
    rows, columns = np.mgrid[:240, :320]
    chair = (abs(rows - 150) < 14) & (abs(columns - 160) < 50)
    chair |= (abs(columns - 125) < 14) & (abs(rows - 115) < 48)
    assert forms(CAMERA, chair, _base(chair), UNKNOWN)[0].kind == "inflated"


def test_a_lying_tyre_whose_hole_is_not_seen_is_one_by_its_name():
    mask, place = _drawn(TYRE, LEVEL)
    assert hole_of(mask) is None
    best = forms(CAMERA, mask, _base(mask), usual_size("old_tyre"))[0]
    assert best.kind == "torus"
    assert isinstance(best.shape, Torus)
    assert best.shape.radius + best.shape.tube == pytest.approx(0.2, rel=0.05)
    assert np.abs(np.array(best.position) - place).max() < 0.02
    assert best.rotation == LEVEL


def test_holes_that_are_no_ring():
    rows, columns = np.mgrid[:240, :320]
    away = np.hypot(rows - 120, columns - 160)
    assert hole_of(away < 60) is None
    ring = (away < 60) & (away > 40)
    found = hole_of(ring)
    assert found is not None
    assert found.across == pytest.approx(2 / 3, abs=0.03)
    # The handle of a mug, and a frame of a window.
    mug = (abs(rows - 120) < 40) & (abs(columns - 140) < 30)
    mug |= (np.hypot(rows - 120, columns - 175) < 25) & (np.hypot(rows - 120, columns - 175) > 15)
    assert hole_of(mug) is None
    square = (abs(rows - 120) < 50) & (abs(columns - 160) < 50)
    assert hole_of(square & ~((abs(rows - 120) < 30) & (abs(columns - 160) < 30))) is None


def test_what_passes_in_front_of_a_ring_does_not_close_its_hole():
    mask, place = _drawn(*CASES["torus"])
    peg = np.zeros_like(mask)
    peg[:, 165:176] = True
    best = forms(CAMERA, mask & ~peg, _base(mask), UNKNOWN, hidden=peg)[0]
    assert best.kind == "torus"
    assert np.abs(np.array(best.position) - place).max() < 0.05
