"""The photo on a body: the far side shows the thing, not what lies around its outline."""

import cv2
import numpy as np

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import Ellipsoid, SceneObject, Sphere
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.texture import textured


def test_the_far_side_of_a_ball_shows_nothing_of_its_surroundings():
    camera = Camera.from_horizon((320, 240), 90, 1.0, focal=300.0)
    ball = Sphere(radius=0.25)
    item = SceneObject(name="ball", shape=ball, position=(0.0, 2.5, 0.25))
    spot = camera.project(np.array([[0.0, 2.5, 0.25]]))[0][0]
    y, x = np.indices((240, 320)) + 0.5
    away = np.hypot(x - spot[0], y - spot[1])
    mask = away < 30
    # The ground shines through a rim of a pixel: green, where the ball is red.
    photo = np.where((away < 29)[..., None], (200, 30, 30), (20, 160, 40)).astype(np.uint8)
    mesh = textured(photo, mask, camera, item, mesh_of(ball))
    assert mesh.uv is not None
    assert mesh.texture is not None
    place = mesh.vertices + np.asarray(item.position)
    behind = (place - np.asarray(camera.position)) @ camera.matrix[:, 2] > 2.6
    u, v = mesh.uv[behind].astype(np.float32).T
    seen = cv2.remap(mesh.texture, u[None] - 0.5, v[None] - 0.5, cv2.INTER_LINEAR)[0]
    assert behind.sum() > 20
    assert (seen[:, 0] > 180).all()


def test_a_ball_is_nowhere_stretched_and_has_no_seams():
    camera = Camera.from_horizon((320, 240), 90, 1.0, focal=300.0)
    ball = Ellipsoid(radii=(0.3, 0.25, 0.25))
    item = SceneObject(name="ball", shape=ball, position=(0.0, 2.5, 0.25))
    body = mesh_of(ball)
    spot = camera.project(body.vertices + np.asarray(item.position))[0]
    hull = cv2.convexHull(np.round(spot).astype(np.int32))
    mask = cv2.fillConvexPoly(np.zeros((240, 320), np.uint8), hull, 1).astype(bool)
    y, x = np.indices((240, 320))
    light = 1.2 - (y - y[mask].min()) / 90 + 0.1 * np.sin(x)
    photo = np.clip(light[..., None] * np.array([190.0, 90, 40]), 0, 255).astype(np.uint8)
    mesh = textured(photo, mask, camera, item, body)
    assert mesh.uv is not None
    assert mesh.texture is not None
    corners = mesh.vertices[mesh.faces]
    size = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    flat = mesh.uv[mesh.faces]
    first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    fine = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])[size > 1e-9]
    fine = fine / size[size > 1e-9]
    assert fine.min() > 0.25 * np.median(fine)
    # Where vertices of two sides lie on one another, they have one colour.
    u, v = mesh.uv.astype(np.float32).T
    seen = cv2.remap(mesh.texture, u[None] - 0.5, v[None] - 0.5, cv2.INTER_LINEAR)[0].astype(float)
    _, same = np.unique(np.round(mesh.vertices, 6), axis=0, return_inverse=True)
    spread = [np.ptp(seen[same == k], axis=0).max() for k in np.unique(same)]
    assert max(spread) < 24
