"""Long round things that lie are seen lying, at any turn."""

import math

import cv2
import numpy as np
import pytest

from physagent_studio.knowledge import UNKNOWN, usual_size
from physagent_studio.program.rotations import about_axis, about_up, matrix_of, multiply
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Capsule, Cylinder
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.photo.regions import bounds
from physagent_studio.reconstruction.shapes.forms import forms
from physagent_studio.reconstruction.shapes.inflation import inflated_mesh
from physagent_studio.reconstruction.shapes.lying import fit_lying, lies
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.silhouettes import silhouette

SIZE = (640, 480)


def camera(pitch: float) -> Camera:
    """A camera 1 m from a point on the ground, which it looks down at."""
    focal, tilt = 700.0, math.radians(pitch)
    row = SIZE[1] / 2 - focal * math.tan(tilt)
    return Camera.from_horizon(SIZE, row, math.sin(tilt), focal=focal)


def seen(pitch: float, shape: Cylinder | Capsule, turn: float | None):
    """Camera, mask and foot of a body that lies at a turn (degrees), or stands."""
    view = camera(pitch)
    lift, rotation = (
        (shape.radius, multiply(about_up(math.radians(turn)), LAID))
        if (turn is not None)
        else (shape.height / 2, (1.0, 0.0, 0.0, 0.0))
    )
    middle = np.array([0.05, math.cos(math.radians(pitch)), lift])
    mesh = mesh_of(shape)
    mask = silhouette(view, mesh.vertices @ matrix_of(rotation).T + middle, mesh.faces)
    x0, _, x1, y1 = bounds(mask)
    foot = on_plane(view, [((x0 + x1) / 2, y1)], 0.0)[0]
    return view, mask, Base(float(foot[0]), float(foot[1]), 0.0), middle


LAID = about_axis((0.0, 1.0, 0.0), math.pi / 2)
LONG = {"cylinder": Cylinder(radius=0.02, height=0.2), "capsule": Capsule(radius=0.03, height=0.18)}


@pytest.mark.parametrize("kind", LONG)
@pytest.mark.parametrize(("pitch", "turn"), [(12, -50), (30, 0), (30, 80), (60, 25), (60, 80)])
def test_a_lying_body_is_found_where_it_lies(pitch, turn, kind):
    shape = LONG[kind]
    view, mask, base, middle = seen(pitch, shape, turn)
    (fit,) = fit_lying(view, mask, base, (kind,), UNKNOWN)
    way = [math.cos(math.radians(turn)), math.sin(math.radians(turn)), 0.0]
    assert lies(fit.rotation)
    assert isinstance(fit.shape, Cylinder | Capsule)
    assert abs(matrix_of(fit.rotation)[:, 2] @ way) > math.cos(math.radians(5))
    assert fit.shape.height == pytest.approx(shape.height, rel=0.08)
    assert fit.shape.radius == pytest.approx(shape.radius, rel=0.1)
    assert np.linalg.norm(np.array(fit.position) - middle) < 0.012


def test_a_thing_of_unknown_name_is_taken_to_lie_where_it_does():
    view, mask, base, _ = seen(30, LONG["capsule"], -50)
    best = {form.kind: form for form in forms(view, mask, base, UNKNOWN)}
    assert all(lies(best[kind].rotation) for kind in LONG)
    assert best["capsule"].merit > best["inflated"].merit


@pytest.mark.parametrize("name", ["pencil", "bottle", "post"])
@pytest.mark.parametrize("pitch", [8, 35])
def test_what_stands_is_not_taken_to_lie(name, pitch):
    view, mask, base, _ = seen(pitch, LONG["cylinder"], None)
    best = forms(view, mask, base, usual_size(name))[0]
    assert not lies(best.rotation)


def test_a_spoon_lies_flat_and_reaches_as_far_as_it_is_seen():
    view = camera(45)
    outline = [(-0.06, 0.7), (0.1, 0.8), (0.11, 0.79), (-0.04, 0.68)]
    corners = view.project(np.array([[x, y, 0.0] for x, y in outline]))[0]
    mask = cv2.fillPoly(np.zeros(SIZE[::-1], np.uint8), [corners.round().astype(np.int32)], 1) > 0
    x, y = outline[3]
    best = forms(view, mask, Base(x, y, 0.0), usual_size("spoon"))[0]
    assert best.shape.kind == "inflated"
    assert best.shape.flat
    assert best.iou > 0.9
    width, depth, height = best.shape.size
    assert (width, depth) == pytest.approx((0.17, 0.12), rel=0.08)
    assert height < 0.02
    # Its stored numbers make the same body again.
    again = inflated_mesh(mask, view, best.shape)
    assert np.array_equal(again.vertices, best.mesh.vertices)
    assert np.ptp(again.vertices, axis=0) == pytest.approx(best.shape.size, rel=1e-6)
