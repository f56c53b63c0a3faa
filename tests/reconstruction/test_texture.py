"""The photo on a body: the far side shows the thing, not what lies around its outline."""

import cv2
import numpy as np

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import SceneObject, Sphere
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
