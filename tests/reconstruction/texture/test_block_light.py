"""Light on a block of one colour: it stays where it falls when the block turns."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.program.rotations import about_axis, matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, SceneObject
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.texture.lighting import unlit
from physagent_studio.reconstruction.texture.projection import textured
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.lit import light_at
from physagent_studio.rendering.raster import Lens, rasterise

CAMERA = Camera.from_horizon((320, 240), 40, 1.2, focal=400.0)
BLOCK = Box(size=(0.5, 0.5, 0.6))
LAMP = np.array([-0.4, -0.5, 0.75]) / np.linalg.norm([-0.4, -0.5, 0.75])
GREY, PAINTS = (120.0, 110.0, 100.0), ((40.0, 60, 170), (190, 60, 40), (200, 190, 60))


def item(angle: float) -> SceneObject:
    turn = about_axis((0, 0, 1), np.radians(angle))
    return SceneObject(name="block", shape=BLOCK, position=(0.05, 2.8, 0.3), rotation=turn)


def light(normals: np.ndarray) -> np.ndarray:
    """(N,) of a large soft lamp from above, a little left."""
    return 0.5 + 0.7 * (0.5 + 0.5 * normals @ LAMP)


def photo_of(
    one: SceneObject, paints: tuple[tuple[float, ...], ...]
) -> tuple[np.ndarray, np.ndarray]:
    """The picture (H, W, 3) of the block in that light and its mask; paints: of the sides across
    its three axes."""
    mesh = mesh_of(BLOCK)
    turn = matrix_of(one.rotation)
    world = mesh.vertices @ turn.T + np.asarray(one.position)
    lens = Lens(*CAMERA.size, CAMERA.focal, *CAMERA.principal)
    points = (world - np.asarray(CAMERA.position)) @ CAMERA.matrix
    hits = rasterise(points, mesh.faces, lens, np.ones(len(mesh.faces), bool))
    corners = mesh.vertices[mesh.faces]
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    own /= np.linalg.norm(own, axis=1, keepdims=True)
    colours = np.array(paints)[np.abs(own).argmax(1)] * light(own @ turn.T)[:, None]
    photo = np.full((lens.height, lens.width, 3), 200, np.uint8)
    mask = np.zeros((lens.height, lens.width), bool)
    noise = np.random.default_rng(1).normal(0, 2, (len(hits.pixel), 1))
    photo.reshape(-1, 3)[hits.pixel] = np.clip(colours[hits.face] + noise, 0, 255)
    mask.ravel()[hits.pixel] = True
    return photo, mask


@pytest.mark.parametrize("angle", [20.0, 35.0, 60.0])
def test_a_block_of_one_colour_is_painted_in_that_colour_alone(angle: float) -> None:
    one = item(angle)
    photo, mask = photo_of(one, (GREY,) * 3)
    found = unlit(photo, mask, CAMERA, one, mesh_of(BLOCK))
    assert found is not None
    before, after = (np.log(picture[mask].mean(-1)).std() for picture in (photo, found[0]))
    # The grain of the photo is left.
    assert before > 0.05
    assert after < 0.02
    # A side that faces elsewhere gets the light of there: more from above than from below.
    up, down = light_at(found[1], np.array([[0, 0, 1.0], [0, -0.9, -0.43]])).mean(-1)
    assert up > 1.1 * down


def test_a_tipped_block_is_as_bright_as_it_would_be_there() -> None:
    one = item(35.0)
    photo, mask = photo_of(one, (GREY,) * 3)
    skin: Mesh = textured(photo, mask, CAMERA, one, mesh_of(BLOCK))
    assert skin.shading is not None
    # Whichever side faces where one faced is lit as that one was.
    sides = (matrix_of(one.rotation) @ np.array([[0, -1.0, 0], [-1.0, 0, 0], [0, 0, 1.0]]).T).T
    found = np.log(light_at(skin.shading, sides).mean(-1))
    assert np.ptp(found - np.log(light(sides))) < 0.04


def test_sides_of_several_colours_keep_what_the_photo_shows() -> None:
    one = item(35.0)
    photo, mask = photo_of(one, PAINTS)
    assert unlit(photo, mask, CAMERA, one, mesh_of(BLOCK)) is None


def test_a_side_seen_by_itself_tells_no_light() -> None:
    one = SceneObject(name="block", shape=BLOCK, position=(0.0, 2.8, 1.2))
    photo, mask = photo_of(one, (GREY,) * 3)
    assert unlit(photo, mask, CAMERA, one, mesh_of(BLOCK)) is None
