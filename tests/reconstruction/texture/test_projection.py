"""The photo on a body: the far side shows the thing, not what lies around its outline."""

import cv2
import numpy as np
import pytest

from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Cylinder,
    Ellipsoid,
    Frustum,
    Inflated,
    Revolved,
    SceneObject,
    Sphere,
)
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.camera.rays import on_upright
from physagent_studio.reconstruction.shapes.inflation import inflated_mesh, upright_extent
from physagent_studio.reconstruction.texture.projection import textured
from physagent_studio.reconstruction.texture.round_bodies import round_textured
from physagent_studio.records.scene import Mesh


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


@pytest.mark.parametrize(
    ("shape", "lying"),
    [
        (Cylinder(radius=0.2, height=0.6), False),
        (Cylinder(radius=0.2, height=0.9), True),
        (Frustum(bottom_radius=0.15, top_radius=0.22, height=0.5), False),
    ],
)
def test_round_sides_are_not_drawn_out_and_meet_behind_without_a_seam(shape, lying):
    camera = Camera.from_horizon((320, 240), 70, 1.0, focal=300.0)
    turn = (0.70710678, 0.0, 0.70710678, 0.0) if lying else (1.0, 0.0, 0.0, 0.0)
    item = SceneObject(name="can", shape=shape, position=(0.1, 2.5, 0.3), rotation=turn)
    body = mesh_of(shape)
    world = body.vertices @ matrix_of(turn).T + np.asarray(item.position)
    hull = cv2.convexHull(np.round(camera.project(world)[0]).astype(np.int32))
    mask = cv2.fillConvexPoly(np.zeros((240, 320), np.uint8), hull, 1).astype(bool)
    x = np.arange(320.0)[None] * np.ones((240, 1))
    photo = np.repeat((70 + 0.5 * x)[..., None], 3, 2).astype(np.uint8)
    mesh = textured(photo, mask, camera, item, body)
    assert mesh.uv is not None
    assert mesh.texture is not None
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    side = np.abs(normal[:, 2]) < 0.6 * np.linalg.norm(normal, axis=1)
    flat = mesh.uv[mesh.faces]
    first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    fine = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    fine = (fine / np.maximum(np.linalg.norm(normal, axis=1), 1e-12))[side]
    assert np.percentile(fine, 4) > 0.1 * np.median(fine)
    # All around a side, vertices that lie on one another show one colour.
    u, v = mesh.uv.astype(np.float32).T
    seen = cv2.remap(mesh.texture, u[None] - 0.5, v[None] - 0.5, cv2.INTER_LINEAR)[0].astype(float)
    own = np.unique(mesh.faces[side])
    own = own[np.abs(mesh.vertices[own, 2]) < 0.35 * shape.height]
    _, same = np.unique(np.round(mesh.vertices[own], 6), axis=0, return_inverse=True)
    spread = [np.ptp(seen[own][same == k], axis=0).max() for k in np.unique(same)]
    assert max(spread) < 16


def _colour(mesh, way: np.ndarray) -> np.ndarray:
    """The colour (3,) of the mesh where a ray from its middle leaves it."""
    unit = mesh.vertices / np.linalg.norm(mesh.vertices, axis=1, keepdims=True)
    u, v = mesh.uv[int((unit @ way).argmax())].astype(int)
    return mesh.texture[v, u].astype(float)


def test_the_calyx_of_a_fruit_goes_around_its_axis_and_comes_once():
    camera = Camera.from_horizon((320, 240), 20, 1.0, focal=420.0)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 24)
    profile = [(0.2 * float(np.sin(a)), 0.25 * float(np.cos(a)) + 1e-4) for a in angle]
    fruit = Revolved(profile=tuple(profile))
    item = SceneObject(name="fruit", shape=fruit, position=(0.0, 2.5, 0.2))
    body = mesh_of(fruit)
    world = body.vertices + np.asarray(item.position)
    pixels = camera.project(world)[0]
    hull = cv2.convexHull(np.round(pixels).astype(np.int32))
    mask = cv2.fillConvexPoly(np.zeros((240, 320), np.uint8), hull, 1).astype(bool)
    # Orange, and dark within 35 degrees of its upper end.
    photo = np.full((240, 320, 3), (230, 120, 30), np.uint8)
    cap = world[np.arctan2(np.hypot(*body.vertices[:, :2].T), body.vertices[:, 2]) < 0.6]
    dark = cv2.convexHull(np.round(camera.project(cap)[0]).astype(np.int32))
    cv2.fillConvexPoly(photo, dark, (40, 30, 20))
    mesh = textured(photo, mask, camera, item, body)
    for azimuth in np.linspace(0, 2 * np.pi, 8, endpoint=False):
        flat = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        assert _colour(mesh, 0.3 * flat + [0, 0, 0.954])[0] < 120
        for height in (-0.9, -0.5, 0.0, 0.4):
            way = np.sqrt(1 - height**2) * flat + [0, 0, height]
            assert _colour(mesh, way)[0] > 190


def test_the_far_side_of_what_is_thin_shows_its_own_colour():
    camera = Camera.from_horizon((320, 240), 90, 1.0, focal=300.0)
    # A dark block and a light pole above it that is narrower than the block's outer ring.
    mask = np.zeros((240, 320), bool)
    mask[150:220, 110:210] = True
    mask[60:150, 157:163] = True
    photo = np.full((240, 320, 3), (40, 120, 40), np.uint8)
    photo[150:220, 110:210] = (20, 20, 20)
    photo[60:150, 157:163] = (220, 220, 220)
    width, depth, height = (2.5 * part for part in upright_extent(mask, camera, 12))
    shape = Inflated(size=(width, depth, height))
    body = inflated_mesh(mask, camera, shape)
    middle = on_upright(camera, [(160, 140)], 2.5)[0]
    x, y, z = middle - (body.vertices.min(0) + body.vertices.max(0)) / 2
    item = SceneObject(name="sign", shape=shape, position=(float(x), float(y), float(z)))
    mesh = textured(photo, mask, camera, item, body)
    assert mesh.uv is not None
    assert mesh.texture is not None
    place = mesh.vertices + np.asarray(item.position)
    behind = place[:, 1] > 2.5
    rows = camera.project(place)[0][:, 1]
    pole = mesh.uv[behind & (rows > 70) & (rows < 140)].astype(int)
    assert len(pole) > 20
    assert (mesh.texture[pole[:, 1], pole[:, 0]].mean(1) > 180).mean() > 0.9


def test_a_body_of_several_colours_with_a_handle_is_not_shown_again_on_its_sides():
    camera = Camera.from_horizon((320, 240), 20, 1.0, focal=420.0)
    stone = Ellipsoid(radii=(0.25, 0.25, 0.16))
    item = SceneObject(name="stone", shape=stone, position=(0.0, 2.5, 0.16))
    body = mesh_of(stone)
    rod = np.array([[-0.1, 0, 0.2], [0.1, 0, 0.2], [0.1, 0, 0.24], [-0.1, 0, 0.24]])
    faces = np.array([[0, 1, 2], [0, 2, 3]]) + len(body.vertices)
    handled = Mesh(np.vstack([body.vertices, rod]), np.vstack([body.faces, faces]))
    world = body.vertices + np.asarray(item.position)
    pixels = np.round(camera.project(world)[0]).astype(np.int32)
    outline = cv2.convexHull(pixels)
    mask = cv2.fillConvexPoly(np.zeros((240, 320), np.uint8), outline, 1).astype(bool)
    # Wide bands of yellow and black.
    photo = np.full((240, 320, 3), (40, 42, 45), np.uint8)
    photo[:, np.arange(320) // 9 % 2 == 0] = (240, 210, 20)
    crop = (photo, (0, 0))
    assert round_textured(camera, item, body, mask, crop) is not None
    assert round_textured(camera, item, handled, mask, crop) is None
