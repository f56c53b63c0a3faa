"""What is cut straight through has its front's colours on its far side, and its rim's on sides."""

import numpy as np

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Cylinder, Inflated, SceneObject
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.camera.rays import on_upright
from physagent_studio.reconstruction.shapes.inflation import inflated_mesh, upright_extent
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.texture.projection import textured
from physagent_studio.records.scene import Mesh

CAMERA = Camera.from_horizon((320, 240), 110, 1.0, focal=420.0)


def _shown(mesh, faces) -> np.ndarray:
    u, v = mesh.uv[mesh.faces[faces]].mean(1).astype(int).T
    return mesh.texture[v, u].astype(int)


def _normals(mesh) -> np.ndarray:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    return across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)


def pictured(spot: tuple[slice, slice], deep_px: float) -> Mesh:
    """A red block that is cut straight through, as a photo shows it with a blue spot on it."""
    mask = np.zeros((240, 320), bool)
    mask[90:150, 100:220] = True
    photo = np.full((240, 320, 3), (60, 160, 60), np.uint8)
    photo[mask] = (200, 30, 30)
    photo[spot] = (30, 30, 200)
    size = tuple(2.5 * part for part in upright_extent(mask, CAMERA, deep_px, straight=True))
    shape = Inflated(size=(size[0], size[1], size[2]), straight=True)
    body = inflated_mesh(mask, CAMERA, shape)
    middle = on_upright(CAMERA, [(160, 120)], 2.5)[0]
    x, y, z = middle - (body.vertices.min(0) + body.vertices.max(0)) / 2
    item = SceneObject(name="car", shape=shape, position=(float(x), float(y), float(z)))
    return textured(photo, mask, CAMERA, item, body)


def test_the_sides_have_the_rims_colour_and_the_far_side_the_fronts():
    mesh = pictured(np.s_[105:135, 130:190], 50)
    normals = _normals(mesh)
    sides = np.abs(normals[:, 0]) > 0.9
    red = np.abs(_shown(mesh, sides) - (200, 30, 30)).max(1) < 40
    assert red.mean() > 0.95
    back = normals[:, 1] > 0.95
    assert (_shown(mesh, back)[:, 2] > 150).mean() > 0.15
    # No picture of the ground beside it anywhere.
    assert (_shown(mesh, np.ones(len(mesh.faces), bool))[:, 1] < 100).all()


def test_upright_sides_show_what_is_beside_them_and_no_stripes():
    mesh = pictured(np.s_[100:140, 110:118], 80)
    assert mesh.uv is not None
    assert mesh.texture is not None
    left = np.flatnonzero(_normals(mesh)[:, 0] < -0.9)
    shares = np.random.default_rng(0).dirichlet((1, 1, 1), 40)
    places = np.einsum("ki,fij->fkj", shares, mesh.uv[mesh.faces[left]]).reshape(-1, 2).astype(int)
    colours = mesh.texture[places[:, 1], places[:, 0]].astype(int)
    blue = colours[:, 2] > 120
    # What is a little beside its edge is seen on it, between what is at the edge.
    assert 0.08 < blue.mean() < 0.7
    assert (colours[:, 1] < 100).all()


def test_an_end_of_a_can_that_is_not_seen_is_plain():
    can = Cylinder(radius=0.2, height=0.5)
    item = SceneObject(name="can", shape=can, position=(0.0, 2.5, 0.25))
    body = mesh_of(can)
    mask = silhouette(CAMERA, in_world(item, body), body.faces)
    photo = np.full((240, 320, 3), (90, 110, 130), np.uint8)
    photo[::6] = (200, 200, 60)
    mesh = textured(photo, mask, CAMERA, item, body)
    under = _shown(mesh, _normals(mesh)[:, 2] < -0.99)
    assert len(under) > 4
    assert np.ptp(under, axis=0).max() == 0
