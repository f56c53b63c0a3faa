"""Shade that the ground lays on a ball's rim is light: it stays below as the ball rolls."""

import cv2
import numpy as np

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject, Sphere
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.switches import without
from physagent_studio.reconstruction.texture.projection import textured
from physagent_studio.rendering.lit import Paint, lit

SIDE, RADIUS = 240, 0.1


def ball_on_dark_ground() -> tuple[np.ndarray, np.ndarray, Camera, SceneObject]:
    """A ball (H, W, 3) lit from above on the left, dark in a narrow crescent at its foot."""
    camera = Camera(
        size=(SIDE, SIDE),
        focal=600.0,
        principal=(SIDE / 2, SIDE / 2),
        position=(0.0, 0.0, RADIUS),
        rotation=(np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0),
    )
    item = SceneObject(
        name="ball", shape=Sphere(radius=RADIUS), position=(0.0, 0.8, RADIUS), support="floor"
    )
    y, x = np.indices((SIDE, SIDE)) + 0.5
    rays = np.stack([(x - SIDE / 2) / 600, np.ones_like(x), -(y - SIDE / 2) / 600], -1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    middle = np.array([0.0, 0.8, 0.0])
    along = rays @ middle
    reach = RADIUS**2 - (middle @ middle - along**2)
    mask = reach > 0
    normal = (rays * (along - np.sqrt(np.maximum(reach, 0)))[..., None] - middle) / RADIUS
    light = 0.55 + 0.45 * np.clip(normal @ np.array([-0.4, -0.6, 0.7]), -1, 1)
    light *= 1 - 0.6 / (1 + np.exp((normal[..., 2] + 0.8) * 25))
    photo = np.full((SIDE, SIDE, 3), 90.0)
    photo[mask] = (light[mask, None] * (235, 190, 60)).clip(0, 255)
    noise = np.random.default_rng(0).normal(0, 2, photo.shape)
    image = (cv2.GaussianBlur(photo, (0, 0), 0.6) + noise).clip(0, 255).astype(np.uint8)
    return image, mask, camera, item


def darkness_of_texture(mesh) -> float:
    """How much darker the darkest twentieth of a ball's own colours is than its middle, log."""
    points = mesh.uv[mesh.faces].mean(1)
    own = np.log(Paint.of(mesh).sample(points, 1.0).mean(1) + 16.0)
    return float(np.median(own) - np.percentile(own, 5))


def test_the_crescent_is_in_the_light_and_not_in_the_texture():
    image, mask, camera, item = ball_on_dark_ground()
    mesh = textured(image, mask, camera, item, mesh_of(Sphere(radius=RADIUS)))
    assert mesh.shading is not None
    assert mesh.shading.shade is not None
    with without(["rim shade"]):
        before = textured(image, mask, camera, item, mesh_of(Sphere(radius=RADIUS)))
    assert darkness_of_texture(mesh) < 0.7 * darkness_of_texture(before)


def test_shade_is_by_the_direction_in_which_the_surface_faces():
    image, mask, camera, item = ball_on_dark_ground()
    mesh = textured(image, mask, camera, item, mesh_of(Sphere(radius=RADIUS)))
    assert mesh.shading is not None
    grey = np.full((2, 3), 200.0)
    foot = np.array([[0.0, -0.35, -0.94], [0.0, -0.9, 0.44]])
    below, front = lit(mesh.shading, grey, foot / np.linalg.norm(foot, axis=1)[:, None]).mean(1)
    assert below < 0.6 * front
