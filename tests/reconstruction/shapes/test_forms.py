"""A body is as wide as it is, whatever stands off it."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from physagent_studio.knowledge.things import UNKNOWN, usual_size
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Cylinder, Frustum, Sphere
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.shapes.forms import Form, forms
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.silhouettes import silhouette

CAMERA = Camera.from_horizon((640, 480), 120, 0.35, focal=620.0)
CUP = Cylinder(radius=0.045, height=0.11)


def _mask(*, handle: bool) -> BoolArray:
    """(H, W) a cup 0.8 m away, with its handle's hole taken for a part of it."""
    mesh = mesh_of(CUP)
    world = mesh.vertices + np.array([0.0, 0.8, CUP.height / 2])
    body = silhouette(CAMERA, world, mesh.faces)
    rows, columns = np.nonzero(body)
    middle, right = int(rows.mean()), int(columns.max())
    canvas = body.astype(np.uint8)
    if handle:
        cv2.ellipse(canvas, (right, middle), (28, 26), 0, -90, 90, 1, -1)
    return canvas.astype(bool)


def _radius(form: Form) -> float:
    """Half of how wide its mesh is, m."""
    return float(np.ptp(form.mesh.vertices[:, 0])) / 2


@pytest.mark.parametrize("handle", [False, True])
def test_a_handle_makes_a_cup_no_wider(handle: bool) -> None:
    base = Base(0.0, 0.75, 0.0)
    found = forms(CAMERA, _mask(handle=handle), base, usual_size("mug"), "cylinder")
    assert _radius(found[0]) == pytest.approx(CUP.radius, rel=0.1)


def test_what_has_no_handle_keeps_its_bulge() -> None:
    base, plain = Base(0.0, 0.75, 0.0), replace(usual_size("mug"), parts=())
    found = forms(CAMERA, _mask(handle=True), base, plain, "cylinder")
    assert _radius(found[0]) > 1.1 * CUP.radius


@pytest.mark.parametrize("bite", [12, 16])
def test_a_fruit_behind_a_leaf_stays_a_round_body(bite: int) -> None:
    # What is drawn to its mask fits any mask: that alone is no reason to swell it.
    mesh = mesh_of(Sphere(radius=0.04))
    mask = silhouette(CAMERA, mesh.vertices + np.array([0.0, 0.8, 0.04]), mesh.faces)
    rows, columns = np.nonzero(mask)
    canvas = mask.astype(np.uint8)
    cv2.circle(canvas, (int(columns.min()) + 3, int(rows.mean()) + 8), bite, 0, -1)
    found = forms(CAMERA, canvas.astype(bool), Base(0.0, 0.76, 0.0), usual_size("apple"))
    assert found[0].kind in ("sphere", "ellipsoid", "revolved")


@pytest.mark.parametrize("steep", [0.5, 0.7])
def test_a_tapering_cup_seen_from_above_is_no_cone(steep: float) -> None:
    # The foot is hidden under a rim that is three times as wide.
    eye = Camera.from_horizon((640, 480), 240 - steep * 620.0, 0.5, focal=620.0)
    cup = Frustum(bottom_radius=0.02, top_radius=0.06, height=0.06)
    mesh = mesh_of(cup)
    away = 0.5 / steep
    low = float(mesh.vertices[:, 2].min())
    world = mesh.vertices + np.array([0.0, away, -low])
    mask = silhouette(eye, world, mesh.faces)
    found = forms(eye, mask, Base(0.0, away, 0.0, hold=0.6), usual_size("cup"))
    assert found[0].iou > 0.975


def test_what_is_seen_from_right_above_lies_in_its_outline() -> None:
    above = Camera.from_horizon((640, 480), -8000, 1.0, focal=620.0)
    canvas = np.zeros((480, 640), np.uint8)
    cv2.fillPoly(canvas, [np.array([(200, 150), (420, 180), (380, 330), (180, 300)])], 1)
    found = forms(above, canvas.astype(bool), Base(0.0, 0.08, 0.0), UNKNOWN, "inflated")
    assert found[0].iou > 0.95
