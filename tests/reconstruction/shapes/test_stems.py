"""Stems and handles are drawn with the body they belong to; shadows at its foot are not."""

import cv2
import numpy as np

from physagent_studio.knowledge.things import usual_size
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject, Sphere
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.shapes.stems import with_parts

CAMERA = Camera.from_horizon((640, 480), 100, 1.0, focal=600.0)
ITEM = SceneObject(name="pumpkin", shape=Sphere(radius=0.3), position=(0.2, 3.0, 0.3))
USUAL = usual_size("pumpkin")


def _seen(mesh) -> np.ndarray:
    return silhouette(CAMERA, in_world(ITEM, mesh), mesh.faces)


def _with(mask, corner, other) -> np.ndarray:
    canvas = mask.astype(np.uint8)
    cv2.rectangle(canvas, corner, other, 1, -1)
    return canvas.astype(bool)


def test_a_stem_is_part_of_what_is_drawn():
    assert ITEM.shape is not None
    ball = mesh_of(ITEM.shape)
    body = _seen(ball)
    rows, columns = np.nonzero(body)
    middle, top = int(columns.mean()), int(rows.min())
    mask = _with(body, (middle - 6, top - 30), (middle + 6, top + 4))
    mesh = with_parts(CAMERA, mask, ITEM, ball, USUAL)
    assert iou(_seen(mesh), mask) > 0.98
    assert np.array_equal(mesh.vertices[: len(ball.vertices)], ball.vertices)
    assert with_parts(CAMERA, mask, ITEM, ball, usual_size("soccer ball")) is ball


def test_a_shadow_at_the_foot_and_a_rough_rim_are_no_parts():
    assert ITEM.shape is not None
    ball = mesh_of(ITEM.shape)
    body = _seen(ball)
    rows, columns = np.nonzero(body)
    low = int(rows.max())
    shadow = _with(body, (int(columns.mean()), low - 6), (int(columns.max()) + 20, low + 6))
    assert with_parts(CAMERA, shadow, ITEM, ball, USUAL) is ball
    rough = cv2.dilate(body.astype(np.uint8), np.ones((3, 3))).astype(bool)
    assert with_parts(CAMERA, rough, ITEM, ball, USUAL) is ball


def test_a_part_beside_the_foot_does_not_reach_into_the_ground():
    assert ITEM.shape is not None
    ball = mesh_of(ITEM.shape)
    body = _seen(ball)
    rows, columns = np.nonzero(body)
    low, right = int(rows.max()), int(columns.max())
    mask = _with(body, (right - 10, low - 60), (right + 25, low - 10))
    mesh = with_parts(CAMERA, mask, ITEM, ball, USUAL)
    assert len(mesh.vertices) > len(ball.vertices)
    assert mesh.vertices[:, 2].min() >= ball.vertices[:, 2].min()
