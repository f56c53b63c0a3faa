"""Meshes are closed and centred; contacts and gaps are exact."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from physagent_studio.errors import InputError
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Frustum,
    Inflated,
    Ramp,
    Revolved,
    Slab,
    Sphere,
    Wall,
)
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.shapes.contact import vertical_gap
from physagent_studio.reconstruction.shapes.inflation import inflated_mesh
from physagent_studio.reconstruction.shapes.meshes import (
    profile_centre,
    support_mesh,
    volume_and_centre,
)
from physagent_studio.reconstruction.shapes.silhouettes import silhouette

PROFILE = [(0.0, 0.1), (0.1, 0.2), (0.3, 0.05)]
SHAPES = {
    "sphere": (Sphere(radius=0.2), 4 / 3 * math.pi * 0.2**3),
    "ellipsoid": (Ellipsoid(radii=(0.1, 0.2, 0.3)), 4 / 3 * math.pi * 0.006),
    "box": (Box(size=(0.1, 0.2, 0.3)), 0.006),
    "cylinder": (Cylinder(radius=0.1, height=0.4), math.pi * 0.004),
    "capsule": (Capsule(radius=0.1, height=0.5), math.pi * (0.003 + 4 / 3 * 0.001)),
    "frustum": (
        Frustum(bottom_radius=0.2, top_radius=0.1, height=0.3),
        math.pi * 0.1 * (0.04 + 0.02 + 0.01),
    ),
    "cone": (Frustum(bottom_radius=0.2, top_radius=0.0, height=0.3), math.pi * 0.1 * 0.04),
    "revolved": (
        Revolved(profile=tuple((z - profile_centre(PROFILE), r) for z, r in PROFILE)),
        math.pi / 3 * (0.1 * (0.01 + 0.02 + 0.04) + 0.2 * (0.04 + 0.01 + 0.0025)),
    ),
}


def _closed(faces):
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    forward = {(int(a), int(b)) for a, b in edges}
    return len(forward) == len(edges) and all((b, a) in forward for a, b in forward)


@pytest.mark.parametrize("kind", SHAPES)
def test_mesh_has_its_volume_and_its_centre(kind):
    shape, volume = SHAPES[kind]
    mesh = mesh_of(shape)
    found, centre = volume_and_centre(mesh.vertices, mesh.faces)
    assert found == pytest.approx(volume, rel=0.01)  # positive: the faces look outward
    assert np.abs(centre).max() < 1e-3
    if kind != "box":  # its sides do not share vertices
        assert _closed(mesh.faces)


def test_shapes_with_their_mesh_elsewhere_say_so():
    with pytest.raises(InputError, match="inflated"):
        mesh_of(Inflated(size=(1, 1, 1)))


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (Slab(position=(0, 1, 0.5), size=(1, 2, 0.1), yaw=0.4), 0.2),
        (Ramp(toe=(0, 1, 0), yaw=0.3, run=0.6, rise=0.2, width=0.5), 0.03),
        (Ramp(toe=(0, 1, 0), yaw=2.3, run=0.6, rise=0.2, width=0.5, plateau=0.2), 0.05),
    ],
)
def test_solid_supports_look_outward(shape, volume):
    mesh = support_mesh(shape, 5.0)
    assert volume_and_centre(mesh.vertices, mesh.faces)[0] == pytest.approx(volume, rel=1e-9)


def test_a_wall_faces_its_normal():
    mesh = support_mesh(Wall(point=(0, 3, 0), yaw=-math.pi / 2), 2.0)
    a, b, c = mesh.vertices[mesh.faces[0]]
    normal = np.cross(b - a, c - a)
    assert normal[1] < 0


def _camera(pitch=10.0):
    focal = 400.0
    row = 120 - focal * math.tan(math.radians(pitch))
    return Camera.from_horizon((320, 240), row, 1.0, focal=focal)


def _disc_mask():
    y, x = np.mgrid[:240, :320]
    return np.hypot(x - 160, y - 120) < 60


@pytest.mark.parametrize("depth", [0.2, 0.9, 1.6])
def test_inflation_has_its_size_and_is_closed(depth):
    mesh = inflated_mesh(_disc_mask(), _camera(), Inflated(size=(0.4, depth, 0.3)))
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx((0.4, depth, 0.3), rel=1e-6)
    volume, centre = volume_and_centre(mesh.vertices, mesh.faces)
    assert volume > 0.3 * 0.4 * depth * 0.3
    assert np.abs(centre).max() < 1e-6
    assert _closed(mesh.faces)


def test_inflation_keeps_holes_open():
    mask = _disc_mask()
    mask[100:140, 140:180] = False
    camera = _camera()
    mesh = inflated_mesh(mask, camera, Inflated(size=(0.4, 0.3, 0.4)))
    ray = camera.rays(np.array([[160.0, 120.0]]))[0]
    seen = silhouette(camera, mesh.vertices + np.asarray(camera.position) + 1.3 * ray, mesh.faces)
    assert not seen[115:125, 155:165].any()
    assert seen.sum() > 5000
    assert _closed(mesh.faces)


@settings(max_examples=25, deadline=None)
@given(gap=st.floats(-0.05, 0.2), x=st.floats(-0.05, 0.05))
def test_gap_of_stacked_boxes_is_exact(gap, x):
    low, high = mesh_of(Box(size=(0.3, 0.3, 0.2))), mesh_of(Box(size=(0.2, 0.2, 0.1)))
    above = high.vertices + np.array([x, 0, 0.15 + gap])
    assert vertical_gap(above, high.faces, low.vertices, low.faces) == pytest.approx(gap, abs=1e-9)


def test_gap_of_balls_is_where_they_touch():
    ball = mesh_of(Sphere(radius=0.1))
    above = ball.vertices + np.array([0, 0, 0.25])
    gap = vertical_gap(above, ball.faces, ball.vertices, ball.faces)
    assert gap == pytest.approx(0.05, abs=1e-6)


def test_no_gap_beside_each_other():
    ball = mesh_of(Sphere(radius=0.1))
    beside = ball.vertices + np.array([1, 0, 0])
    assert vertical_gap(beside, ball.faces, ball.vertices, ball.faces) is None
