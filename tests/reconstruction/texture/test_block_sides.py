"""A block's hidden sides show what the opposite ones show, and nothing of their neighbours."""

import numpy as np

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, SceneObject
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.texture.block_sides import opposite_sides
from physagent_studio.reconstruction.texture.projection import textured

CAMERA = Camera.from_horizon((320, 240), 20, 1.0, focal=420.0)
BLOCK = SceneObject(
    name="block",
    shape=Box(size=(0.6, 0.5, 0.3)),
    position=(0.0, 2.5, 0.15),
    rotation=(np.cos(0.3), 0.0, 0.0, np.sin(0.3)),
)
PAINTS = ((220, 30, 30), (30, 200, 30), (30, 30, 220))
"""Of the sides across x, y and z."""


def _painted():
    """The block drawn with one paint for each pair of sides, and its mesh from that picture."""
    assert BLOCK.shape is not None
    body = mesh_of(BLOCK.shape)
    world = in_world(BLOCK, body)
    photo = np.full((240, 320, 3), (120, 120, 120), np.uint8)
    corners = body.vertices[body.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(1)
    eye = np.asarray(CAMERA.position)
    placed = world[body.faces]
    turned = np.cross(placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0])
    facing = ((eye - placed.mean(1)) * turned).sum(1) > 0
    for k in range(3):
        shown = silhouette(CAMERA, world, body.faces[facing & (axis == k)])
        photo[shown] = PAINTS[k]
    mask = silhouette(CAMERA, world, body.faces)
    return textured(photo, mask, CAMERA, BLOCK, body), body


def test_the_far_sides_have_the_paint_of_their_opposites():
    mesh, _ = _painted()
    assert mesh.uv is not None
    assert mesh.texture is not None
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    u, v = mesh.uv[mesh.faces].mean(1).astype(int).T
    colours = mesh.texture[v, u].astype(int)
    for k in range(3):
        for way in (-1, 1):
            side = way * normal[:, k] > 0.99
            right = np.abs(colours[side] - PAINTS[k]).max(1) < 60
            assert right.mean() > 0.9


def test_what_is_written_on_a_far_side_is_not_mirrored():
    assert BLOCK.shape is not None
    body = mesh_of(BLOCK.shape)
    found = opposite_sides(CAMERA, BLOCK, body)
    assert found is not None
    chosen, shown = found
    a, b, c = (shown[body.faces[chosen][:, k]] for k in range(3))
    outward = (np.cross(b - a, c - a) * (a + b + c)).sum(1)
    assert (outward > 0).mean() > 0.95
