"""What is round about an axis, turned: rings go on, inside and underside have colours of theirs."""

import cv2
import numpy as np

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Frustum, Revolved, SceneObject
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.texture.projection import textured
from physagent_studio.records.scene import Mesh

CAMERA = Camera.from_horizon((320, 240), 10, 1.0, focal=420.0)


def pictured(item: SceneObject, body: Mesh, paint, above: int = 0) -> Mesh:
    """The body as a photo of it on green ground shows it; paint: points (N, 3) to colours.

    above: the row above which something else covers it.
    """
    colours = np.array([paint(*point) for point in body.vertices[body.faces].mean(1)], np.uint8)
    photo = np.full((240, 320, 3), (20, 160, 40), np.uint8)
    world = body.vertices + np.asarray(item.position)
    pixels, depth = CAMERA.project(world)
    order = np.argsort(-depth[body.faces].mean(1))
    a, b, c = (world[body.faces[:, k]] for k in range(3))
    towards = (np.cross(b - a, c - a) * (np.asarray(CAMERA.position) - a)).sum(1) > 0
    mask = np.zeros((240, 320), np.uint8)
    for face in order[towards[order]]:
        spot = np.round(pixels[body.faces[face]] * 16).astype(np.int32)
        cv2.fillConvexPoly(photo, spot, colours[face].tolist(), shift=4)
        cv2.fillConvexPoly(mask, spot, 1, shift=4)
    photo[:above] = (20, 160, 40)
    mask[:above] = 0
    return textured(photo, mask.astype(bool), CAMERA, item, body)


def seen_of(mesh: Mesh, chosen: np.ndarray) -> np.ndarray:
    """The colours (N, 3) of the middles of some of its faces (F,)."""
    assert mesh.uv is not None
    assert mesh.texture is not None
    u, v = mesh.uv[mesh.faces[chosen]].mean(1).astype(np.float32).T
    return cv2.remap(mesh.texture, u[None] - 0.5, v[None] - 0.5, cv2.INTER_LINEAR)[0]


def test_what_a_stem_hides_of_a_disc_is_no_second_stem():
    profile = [(-0.12, 0.02), (0.0, 0.25), (0.02, 0.25), (0.021, 0.03), (0.2, 0.03)]
    top = Revolved(profile=tuple(profile))
    item = SceneObject(name="top", shape=top, position=(0.0, 2.0, 0.12))

    def paint(x: float, y: float, z: float) -> tuple[int, int, int]:
        return (150, 90, 40) if z > 0.03 else (60, 60, 200)

    mesh = pictured(item, mesh_of(top), paint)
    middle = mesh.vertices[mesh.faces].mean(1)
    away = np.hypot(middle[:, 0], middle[:, 1])
    colours = seen_of(mesh, away > 0.06).astype(int)
    # Neither of the stem nor, below, of the ground.
    assert (colours[:, 2] > colours[:, 0] + 60).mean() > 0.98
    assert (colours[:, 1] < 100).mean() > 0.98


def test_the_inside_of_a_vessel_shows_nothing_of_its_outside():
    cup = Frustum(bottom_radius=0.2, top_radius=0.2, height=0.3, wall=0.012)
    item = SceneObject(name="cup", shape=cup, position=(0.0, 2.0, 0.15))

    def paint(x: float, y: float, z: float) -> tuple[int, int, int]:
        inside = np.hypot(x, y) < 0.195 and z > -0.145
        return (230, 225, 220) if inside else (40, 60, 200) if x * 30 % 2 < 1 else (200, 60, 40)

    mesh = pictured(item, mesh_of(cup), paint)
    middle = mesh.vertices[mesh.faces].mean(1)
    inner = (np.hypot(middle[:, 0], middle[:, 1]) < 0.19) & (middle[:, 2] > -0.14)
    colours = seen_of(mesh, inner).astype(int)
    assert (np.ptp(colours, axis=1) < 30).mean() > 0.98
    # Its floor is darker than its wall, for little light comes there.
    floor = middle[inner][:, 2] < -0.13
    assert colours[floor].mean() < 0.85 * colours[~floor].max()


def test_what_another_thing_covers_shows_no_pixels_drawn_out_over_it():
    can = Frustum(bottom_radius=0.2, top_radius=0.2, height=0.4)
    item = SceneObject(name="can", shape=can, position=(0.0, 2.0, 0.2))

    def paint(x: float, y: float, z: float) -> tuple[int, int, int]:
        # A leaf hangs down from what is covered.
        return (40, 30, 20) if abs(x) < 0.08 and z > -0.02 else (230, 120, 20)

    rows = CAMERA.project(np.array([[0.0, 1.8, 0.2]]))[0][0, 1]
    mesh = pictured(item, mesh_of(can), paint, above=round(rows))
    middle = mesh.vertices[mesh.faces].mean(1)
    top = (middle[:, 2] > 0.15) & (np.hypot(middle[:, 0], middle[:, 1]) < 0.12)
    assert (seen_of(mesh, top).astype(int)[:, 0] > 120).mean() > 0.9
