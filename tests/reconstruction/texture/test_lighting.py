"""Light taken off round things: their texture is their own colour, and turns without the light."""

import numpy as np
import pytest

from physagent_studio.program.rotations import about_axis, matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, Cylinder, SceneObject, Sphere
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.texture.hidden_sides import covered_painted
from physagent_studio.reconstruction.texture.lighting import _spots, unlit
from physagent_studio.reconstruction.texture.projection import _painted, textured
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering import Compositor
from physagent_studio.rendering.raster import Lens, rasterise
from tests.rendering.scenes import scene_of

CAMERA = Camera.from_horizon((320, 240), 60, 1.0, focal=400.0)
BALL = Sphere(radius=0.5)
PLACE = (0.05, 2.6, 0.75)
LAMP = np.array([0.45, -0.5, 0.75]) / np.linalg.norm([0.45, -0.5, 0.75])
ITEM = SceneObject(name="ball", shape=BALL, position=PLACE)


def light(normals: np.ndarray) -> np.ndarray:
    """(N,) of a large soft lamp."""
    return 0.45 + 0.65 * (0.5 + 0.5 * normals @ LAMP) ** 1.5


def striped(ways: np.ndarray) -> np.ndarray:
    """Narrow bands of two shades; (N, 3)."""
    bright = 0.9 + 0.1 * np.sign(np.sin(40 * ways @ np.array([0.6, 0.0, 0.8])))
    return bright[:, None] * np.array([170.0, 120.0, 70.0])


def banded(ways: np.ndarray) -> np.ndarray:
    """Wide level bands of two shades; (N, 3)."""
    bright = 0.85 + 0.15 * np.sign(np.sin(14 * ways[:, 2]))
    return bright[:, None] * np.array([170.0, 120.0, 70.0])


def football(ways: np.ndarray) -> np.ndarray:
    """Black patches about the corners of an icosahedron on white, (N, 3)."""
    g = (1 + 5**0.5) / 2
    corners = np.array([(0, a, b * g) for a in (-1, 1) for b in (-1, 1)], float)
    corners = np.vstack([np.roll(corners, k, axis=1) for k in range(3)])
    corners /= np.linalg.norm(corners, axis=1, keepdims=True)
    black = (ways @ corners.T).max(1) > np.cos(np.radians(20))
    return np.where(black[:, None], 25.0, 175.0) * np.ones(3)


def patched(ways: np.ndarray) -> np.ndarray:
    """Six wide patches of six colours about an axis, as on a beach ball, (N, 3)."""
    turn = np.arctan2(0.8 * ways[:, 1] + 0.6 * ways[:, 2], ways[:, 0])
    paints = [
        [220, 220, 215],
        [30, 60, 180],
        [220, 170, 20],
        [215] * 3,
        [40, 150, 60],
        [200, 40, 40],
    ]
    return np.array(paints, float)[np.floor((turn / (2 * np.pi) + 0.5) * 6).astype(int) % 6]


def photo_of(paint, lamp, turn=(1.0, 0, 0, 0)):
    """The true picture of a ball: the photo (H, W, 3), its mask, its directions (K, 3), body."""
    w, h = CAMERA.size
    grid = np.stack(np.meshgrid(np.arange(w) + 0.5, np.arange(h) + 0.5), -1).reshape(-1, 2)
    rays = CAMERA.rays(grid.astype(np.float64))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    off = np.asarray(CAMERA.position) - PLACE
    b = rays @ off
    inside = b * b - off @ off + BALL.radius**2
    mask = inside > 0
    points = off + rays[mask] * (-b[mask] - np.sqrt(inside[mask]))[:, None]
    normals = points / BALL.radius
    ways = normals @ matrix_of(turn)
    photo = np.full((h * w, 3), (90, 110, 95), np.uint8)
    photo[mask] = np.clip(paint(ways) * lamp(normals).reshape(len(ways), -1) + 0.5, 0, 255)
    return photo.reshape(h, w, 3), mask.reshape(h, w), ways


def rendered(mesh: Mesh, photo, mask, turn) -> np.ndarray:
    scene = scene_of([ITEM], {"ball": mesh}, camera=CAMERA, photo=photo, plate=photo,
                     masks={"ball": mask})  # fmt: skip
    return Compositor(scene).frame([PLACE], [turn], as_built=True, shadows=False).rgb


def psnr(one, other) -> float:
    return float(10 * np.log10(255**2 / ((one.astype(float) - other) ** 2).mean()))


@pytest.mark.parametrize("paint", [striped, banded, football, patched])
def test_what_is_painted_is_found_without_the_light_on_it(paint):
    photo, mask, ways = photo_of(paint, light)
    found = unlit(photo, mask, CAMERA, ITEM, mesh_of(BALL))
    assert found is not None
    # Haze and noise in what is dark are not multiplied with light.
    own, true = found[0][mask] + 16.0, paint(ways) + 16
    towards = (np.asarray(CAMERA.position) - PLACE) / np.linalg.norm(
        np.asarray(CAMERA.position) - PLACE
    )
    seen = ways @ towards > np.cos(np.radians(68))
    bright = seen & (true.max(1) > 100)
    ratio = (own / true)[bright].mean(1)
    before = ((photo[mask] + 16.0) / true)[bright].mean(1)
    # By a factor, which brightness shares with the light.
    error = np.abs(ratio / np.median(ratio) - 1)
    assert np.median(error) < 0.035
    assert np.percentile(error, 90) < 0.12
    assert np.percentile(error, 90) < 0.4 * np.percentile(
        np.abs(before / np.median(before) - 1), 90
    )
    if paint is football:
        black = own[seen & ~bright] - 16
        assert np.median(black) < 0.3 * np.median(own[bright] - 16)


def test_a_ball_that_has_rolled_is_lit_as_before():
    photo, mask, _ = photo_of(striped, light)
    mesh = textured(photo, mask, CAMERA, ITEM, mesh_of(BALL))
    assert mesh.shading is not None
    # With the light of the photo in its texture, as things were drawn before.
    baked = _painted(photo, mask, CAMERA, ITEM, mesh_of(BALL), lit=True)
    for axis, least in (((0.0, 1.0, 0.0), 4.0), ((1.0, 0.0, 0.0), 1.5)):
        turn = about_axis(axis, np.pi / 2)
        truth = photo_of(striped, light, turn)[0]
        now = psnr(rendered(mesh, photo, mask, turn)[mask], truth[mask])
        before = psnr(rendered(baked, photo, mask, turn)[mask], truth[mask])
        assert now > before + least, (axis, now, before)
    still = rendered(mesh, photo, mask, (1.0, 0, 0, 0))[mask].astype(float)
    drawn = rendered(baked, photo, mask, (1.0, 0, 0, 0))[mask].astype(float)
    assert np.abs(still - photo[mask]).mean() < np.abs(drawn - photo[mask]).mean() + 2


def test_what_is_green_on_a_white_ball_is_the_light_of_the_cloth():
    """The hue of light from below leaves a texture that has none of its own."""

    def above_cloth(normals: np.ndarray) -> np.ndarray:
        bounce = np.maximum(-normals[:, 2:] - 0.1, 0) * np.array([0.0, 0.5, 0.15])
        return light(normals)[:, None] * (1 - 0.4 * np.maximum(-normals[:, 2:], 0)) + bounce

    def white(ways: np.ndarray) -> np.ndarray:
        return np.full((len(ways), 3), (175.0, 170.0, 160.0))

    true = white(np.zeros((1, 3)))[0]
    photo, mask, _ = photo_of(white, above_cloth)
    found = unlit(photo, mask, CAMERA, ITEM, mesh_of(BALL))
    assert found is not None

    def strayed(picture: np.ndarray) -> float:
        logs = np.log(picture[mask] + 16.0) - np.log(true + 16)
        hue = logs - logs.mean(axis=1, keepdims=True)
        return float(np.percentile(np.linalg.norm(hue - np.median(hue, axis=0), axis=1), 90))

    assert strayed(found[0]) < 0.4 * strayed(photo)


@pytest.mark.parametrize("paint", [striped, banded, football, patched])
def test_in_flat_light_the_photo_itself_is_the_texture(paint):
    photo, mask, _ = photo_of(paint, lambda normals: np.ones(len(normals)))
    assert unlit(photo, mask, CAMERA, ITEM, mesh_of(BALL)) is None


def test_gloss_stays_where_it_is_as_the_ball_rolls():
    shine = LAMP + np.array([0, -1, 0])
    shine /= np.linalg.norm(shine)
    photo, mask, ways = photo_of(lambda w: np.full((len(w), 3), (150.0, 40, 30)), light)
    spot = ways @ shine > np.cos(np.radians(9))
    photo[mask] = np.where(spot[:, None], 250, photo[mask])
    mesh = textured(photo, mask, CAMERA, ITEM, mesh_of(BALL))
    assert mesh.shading is not None
    assert mesh.shading.gloss is not None
    inner = ways @ shine > np.cos(np.radians(6))
    for angle in (0, 60, 150):
        frame = rendered(mesh, photo, mask, about_axis((0.0, 1.0, 0.0), np.radians(angle)))[mask]
        assert frame[inner][:, 2].mean() > 210
        # Nowhere else, as where the spot would have gone.
        far = ways @ shine < np.cos(np.radians(14))
        assert (frame[far][:, 2] > 120).mean() < 0.01


def test_a_can_is_lit_too_and_a_box_is_left_as_it_is():
    shape = Cylinder(radius=0.3, height=0.8)
    can = SceneObject(name="ball", shape=shape, position=PLACE)
    body = mesh_of(shape)
    points = (body.vertices + PLACE - np.asarray(CAMERA.position)) @ CAMERA.matrix
    lens = Lens(*CAMERA.size, CAMERA.focal, *CAMERA.principal)
    hits = rasterise(points, body.faces, lens, np.ones(len(body.faces), bool))
    a, b, c = (body.vertices[body.faces[hits.face]][:, k] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    photo = np.full((240 * 320, 3), 100, np.uint8)
    photo[hits.pixel] = (np.array([150.0, 150, 160]) * light(normals)[:, None]).astype(np.uint8)
    mask = np.zeros(240 * 320, bool)
    mask[hits.pixel] = True
    photo, mask = photo.reshape(240, 320, 3), mask.reshape(240, 320)
    mesh = textured(photo, mask, CAMERA, can, body)
    assert mesh.shading is not None
    # Bright to the right, as the lamp is, whatever side of it is in front.
    turned = rendered(mesh, photo, mask, about_axis((0.0, 0, 1), np.pi))
    assert np.abs(turned[mask].astype(float) - photo[mask]).mean() < 8
    crate = can.model_copy(update={"shape": Box(size=(0.5, 0.5, 0.5))})
    assert unlit(photo, mask, CAMERA, crate, mesh_of(Box(size=(0.5, 0.5, 0.5)))) is None


def test_a_covered_side_of_a_block_has_its_own_colour():
    shape = Box(size=(0.8, 0.6, 0.2))
    book = SceneObject(name="book", shape=shape, position=(0.0, 2.6, 0.3))
    body = mesh_of(shape)
    points = (
        body.vertices + np.asarray(book.position) - np.asarray(CAMERA.position)
    ) @ CAMERA.matrix
    lens = Lens(*CAMERA.size, CAMERA.focal, *CAMERA.principal)
    hits = rasterise(points, body.faces, lens, np.ones(len(body.faces), bool))
    a, b, c = (body.vertices[body.faces[hits.face]][:, k] for k in range(3))
    up = np.abs(np.cross(b - a, c - a)[:, 2]) > 1e-9
    photo = np.full((240 * 320, 3), (30, 60, 200), np.uint8)
    photo[hits.pixel[~up]] = (150, 60, 40)
    mask = np.zeros(240 * 320, bool)
    mask[hits.pixel[~up]] = True
    photo, mask = photo.reshape(240, 320, 3), mask.reshape(240, 320)
    painted = covered_painted(photo, mask, CAMERA, book, (photo, (0, 0)))
    top = np.zeros(240 * 320, bool)
    top[hits.pixel[up]] = True
    assert np.abs(painted.reshape(-1, 3)[top].astype(int) - (150, 60, 40)).max() < 8
    ball = covered_painted(photo, mask, CAMERA, ITEM, (photo, (0, 0)))
    assert ball is photo


def test_a_white_band_around_a_thing_is_paint_and_no_gloss():
    """Gloss ends before the outline; what goes across all of a cone is painted on it."""
    picture = np.full((120, 80, 3), (200, 80, 20), np.uint8)
    own = np.zeros((120, 80), bool)
    own[10:110, 15:65] = True
    spot = picture.copy()
    spot[40:60, 30:40] = 250
    assert _spots(spot, spot, own).any()
    picture[40:60] = 250
    assert not _spots(picture, picture, own).any()
