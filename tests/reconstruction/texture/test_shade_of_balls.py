"""Shade that the ground lays on a ball is light: it stays below as the ball rolls."""

import cv2
import numpy as np

from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject, Sphere
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.switches import without
from physagent_studio.reconstruction.texture.lighting import unlit
from physagent_studio.reconstruction.texture.plain_ball import is_plain
from physagent_studio.reconstruction.texture.projection import textured
from physagent_studio.records import Mesh
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.lit import Paint, lit
from physagent_studio.rendering.raster import Lens, rasterise

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
    with without(["plain balls"]):
        mesh = textured(image, mask, camera, item, mesh_of(Sphere(radius=RADIUS)))
    assert mesh.shading is not None
    assert mesh.shading.shade is not None
    with without(["plain balls", "rim shade"]):
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


def test_what_changes_slowly_over_a_plain_ball_is_light():
    image, mask, camera, item = ball_on_dark_ground()
    assert is_plain(image, mask)
    mesh = textured(image, mask, camera, item, mesh_of(Sphere(radius=RADIUS)))
    with without(["plain balls"]):
        before = textured(image, mask, camera, item, mesh_of(Sphere(radius=RADIUS)))
    assert darkness_of_texture(mesh) < 0.8 * darkness_of_texture(before)
    # As it stands there, it looks as in the photo.
    inner = cv2.erode(mask.astype(np.uint8), np.ones((9, 9), np.uint8)).astype(bool)
    off = seen_again(mesh, camera, item)[inner] - image[inner].astype(float)
    assert 10 * np.log10(255**2 / (off**2).mean()) > 32


def test_a_painted_ball_keeps_its_paint():
    image, mask, _, _ = ball_on_dark_ground()
    stripes = (np.indices(mask.shape)[1] // 24 % 2).astype(bool) & mask
    image[stripes] = (image[stripes] * (0.3, 0.7, 2.5)).clip(0, 255).astype(np.uint8)
    assert not is_plain(image, mask)
    grooved = image.copy()
    grooved[stripes] = ball_on_dark_ground()[0][stripes] // 2
    assert not is_plain(grooved, mask)


def seen_again(mesh: Mesh, camera: Camera, item: SceneObject) -> np.ndarray:
    """(H, W, 3) the mesh in its light, as the camera sees it where it was built."""
    assert mesh.uv is not None
    assert mesh.shading is not None
    batch, lens = Batch.of([mesh]), Lens(*camera.size, camera.focal, *camera.principal)
    world = mesh.vertices @ matrix_of(item.rotation).T + np.asarray(item.position)
    points = (world - np.asarray(camera.position)) @ camera.matrix
    hits = rasterise(points, batch.faces, lens, batch.one_sided)
    uv = np.einsum("ki,kij->kj", hits.weights, mesh.uv[mesh.faces[hits.face]])
    normals = np.einsum("ki,kij->kj", hits.weights, batch.normals[hits.face])
    normals = normals @ matrix_of(item.rotation).T
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    out = np.zeros((SIDE * SIDE, 3))
    out[hits.pixel] = lit(mesh.shading, Paint.of(mesh).sample(uv, 1.0), normals)
    return out.reshape(SIDE, SIDE, 3)


def test_what_the_ground_throws_back_is_light_and_no_paint():
    image, mask, camera, item = ball_on_dark_ground()
    rows = np.indices(mask.shape)[0]
    middle, height = rows[mask].mean(), np.ptp(rows[mask])
    low = np.clip((rows - middle) / height * 2, 0, 1)[..., None] ** 2
    image = image.copy()
    image[~mask] = (170, 80, 40)
    # Dark seams all over, so that it is no ball of one colour.
    seams = mask & (rows % 24 < 5)
    image[seams] = image[seams] // 3
    tinted = image * (1 - low * (1 - np.array([1.0, 0.6, 0.35])))
    image[mask] = tinted.astype(np.uint8)[mask]
    grey = image.copy()
    grey[~mask] = 90

    def strayed(photo):
        """How far the blue of what is low is off that of what is high, log, without light."""
        taken = unlit(photo, mask, camera, item, mesh_of(Sphere(radius=RADIUS)))
        assert taken is not None
        plain, _ = taken
        part = mask & ~seams
        bands = [part & (low[..., 0] == 0), part & (abs(low[..., 0] - 0.3) < 0.15)]
        high, below = (np.log(plain[band] + 16.0).mean(0) for band in bands)
        return abs((high[2] - high[0]) - (below[2] - below[0]))

    assert strayed(image) < 0.5 * strayed(grey)
