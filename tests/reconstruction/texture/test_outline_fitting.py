"""What is drawn covers its mask, stays on its support and is not torn."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
import trimesh

from physagent_studio.benchmark.reconstruction.bench import _case
from physagent_studio.benchmark.reconstruction.cover import covers_of
from physagent_studio.benchmark.reconstruction.synthetic import TrueMasks, scene
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Box,
    Cylinder,
    Inflated,
    Revolved,
    SceneObject,
    SceneState,
    Shape,
    Sphere,
)
from physagent_studio.reconstruction import mesh_of, reconstruct
from physagent_studio.reconstruction.masks.foot_spill import without_spill
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.reconstruction.shapes.inflation import inflated_mesh
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.texture.carving import carved, with_parts
from physagent_studio.reconstruction.texture.outline_fitting import covering
from physagent_studio.reconstruction.texture.skins import sights_of
from physagent_studio.records.scene import Mesh

pytestmark = pytest.mark.usefixtures("unfilled")

CAMERA = Camera.from_horizon((320, 240), 60.0, 1.0, focal=300.0)
PIN = Revolved(
    profile=((-0.25, 0.06), (-0.1, 0.11), (0.0, 0.1), (0.12, 0.05), (0.2, 0.06), (0.25, 0.03))
)
SHAPES = {
    "box": (Box(size=(0.4, 0.3, 0.3)), 0.15),
    "can": (Cylinder(radius=0.13, height=0.4), 0.2),
    "pin": (PIN, 0.25),
    "ball": (Sphere(radius=0.2), 0.2),
}


def _thing(name: str, shape: Shape, x: float, lift: float, y: float = 2.2) -> SceneObject:
    return SceneObject(name=name, shape=shape, position=(x, y, lift), support="floor")


def _drawn(item: SceneObject) -> BoolArray:
    assert item.shape is not None
    mesh = mesh_of(item.shape)
    return silhouette(CAMERA, in_world(item, mesh), mesh.faces)


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("hidden", [False, True])
def test_a_body_a_little_off_is_drawn_on_its_mask(kind: str, hidden: bool) -> None:
    shape, lift = SHAPES[kind]
    truth = _thing("thing", shape, 0.0, lift)
    before = _thing("before", Box(size=(0.15, 0.1, 0.2)), 0.16, 0.1, 1.8)
    mask = _drawn(truth)
    front = _drawn(before) if hidden else np.zeros_like(mask)
    # As found it is some pixels to the left and a little farther.
    found = truth.model_copy(update={"position": (-0.02, 2.25, lift)})
    masks = {"thing": mask & ~front, "before": front}
    meshes = {"thing": mesh_of(shape), "before": mesh_of(before.shape or shape)}
    things = (found, before) if hidden else (found,)
    sights = sights_of(CAMERA, masks, things, meshes, ())
    led = covering(sights["thing"], found, meshes["thing"])
    seen = silhouette(CAMERA, in_world(found, led), led.faces) & ~front
    assert iou(seen, masks["thing"]) >= 0.95
    middles = [np.argwhere(area).mean(0) for area in (seen, masks["thing"])]
    assert float(np.linalg.norm(middles[0] - middles[1])) <= 1.0
    low = float(in_world(found, led)[:, 2].min())
    assert abs(low) < 2 * 2.2 / 300


def test_what_covers_its_mask_is_left_alone() -> None:
    item = _thing("thing", PIN, 0.0, 0.25)
    mesh = mesh_of(PIN)
    sights = sights_of(CAMERA, {"thing": _drawn(item)}, (item,), {"thing": mesh}, ())
    assert covering(sights["thing"], item, mesh) is mesh


def test_what_stands_elsewhere_is_not_drawn_to_its_mask() -> None:
    """A person has moved it: the photo shows it where it was."""
    item = _thing("thing", PIN, 0.0, 0.25)
    moved = item.model_copy(update={"position": (0.3, 2.2, 0.25)})
    mesh = mesh_of(PIN)
    sights = sights_of(CAMERA, {"thing": _drawn(item)}, (moved,), {"thing": mesh}, ())
    assert covering(sights["thing"], moved, mesh) is mesh


def test_what_collides_as_it_is_drawn_keeps_its_foot() -> None:
    mask = np.zeros((240, 320), bool)
    mask[90:160, 150:166], mask[60:110, 110:210] = True, True
    shape = Inflated(size=(0.7, 0.3, 0.7))
    mesh = inflated_mesh(mask, CAMERA, shape)
    low = float(mesh.vertices[:, 2].min())
    item = _thing("tree", shape, 0.0, -low)
    seen = silhouette(CAMERA, in_world(item, mesh), mesh.faces)
    shown = np.roll(seen, (-3, 4), axis=(0, 1))
    sights = sights_of(CAMERA, {"tree": shown}, (item,), {"tree": mesh}, ())
    led = covering(sights["tree"], item, mesh)
    assert led is not mesh
    foot = mesh.vertices[:, 2] < low + 1e-4
    assert np.allclose(led.vertices[foot], mesh.vertices[foot])
    assert float(led.vertices[:, 2].min()) >= low - 1e-9


def _stool() -> tuple[SceneObject, Mesh, BoolArray]:
    """A deep block of a stool and what is seen of one: a seat and three legs, open between."""
    box = np.zeros((240, 320), bool)
    box[80:176, 120:200] = True
    shape = Inflated(size=(0.8, 0.8, 0.95), straight=True)
    mesh = inflated_mesh(box, CAMERA, shape)
    item = _thing("stool", shape, 0.0, -float(mesh.vertices[:, 2].min()))
    seen = silhouette(CAMERA, in_world(item, mesh), mesh.faces)
    rows, columns = seen.nonzero()
    top, left, right = int(rows.min()), int(columns.min()), int(columns.max())
    legs = np.zeros_like(seen)
    for x in (left, (left + right) // 2 - 4, right - 8):
        legs[:, x : x + 9] = True
    legs[: top + 24] = True
    return item, mesh, seen & legs


def test_openings_between_legs_stay_open() -> None:
    item, mesh, shown = _stool()
    sights = sights_of(CAMERA, {"stool": shown}, (item,), {"stool": mesh}, ())
    look = carved(sights["stool"], item, mesh)
    assert iou(silhouette(CAMERA, in_world(item, mesh), mesh.faces), shown) < 0.8
    drawn = silhouette(CAMERA, in_world(item, look), look.faces)
    assert np.count_nonzero(drawn & ~shown) < 0.03 * np.count_nonzero(shown)
    assert np.count_nonzero(drawn & shown) > 0.95 * np.count_nonzero(shown)
    # Nothing of it is open, and no shreds are left of its depth: legs are as deep as they are wide.
    assert trimesh.Trimesh(look.vertices, look.faces, process=False).is_watertight
    low = look.vertices[np.unique(look.faces)]
    low = low[low[:, 2] < -0.1]
    assert np.ptp(low[:, 1]) < 0.25 * np.ptp(mesh.vertices[:, 1])


def test_what_was_moved_by_hand_is_not_drawn_where_it_was() -> None:
    item, mesh, shown = _stool()
    moved = item.model_copy(update={"position": (0.6, 2.2, 0.5)})
    sights = sights_of(CAMERA, {"stool": shown}, (moved,), {"stool": mesh}, ())
    assert carved(sights["stool"], moved, mesh) is mesh


def test_what_is_turned_about_an_axis_is_not_torn_at_its_rim() -> None:
    """A mask that is cut in at a side takes no faces off the far side of the body."""
    shape, lift = SHAPES["pin"]
    item = _thing("pin", shape, 0.0, lift)
    mask = _drawn(item)
    columns = np.flatnonzero(mask.any(0))
    mask[:, : columns[0] + 6] = False
    mesh = mesh_of(shape)
    sights = sights_of(CAMERA, {"pin": mask}, (item,), {"pin": mesh}, ())
    assert len(carved(sights["pin"], item, mesh).faces) == len(mesh.faces)


def _with_a_bow(kind: str) -> tuple[SceneObject, BoolArray]:
    """A thing and its mask with a bow on its right side, as a handle is, down to below its foot."""
    shape, lift = SHAPES[kind]
    item = _thing(kind, shape, 0.0, lift)
    mask = _drawn(item)
    rows, columns = mask.nonzero()
    bow = np.zeros(mask.shape, np.uint8)
    middle = (int(columns.max()), int(rows.max()) - 8)
    cv2.ellipse(bow, middle, (18, 14), 0, -90, 90, 1, 6)
    return item, mask | (bow > 0)


@pytest.mark.parametrize("kind", ["can", "pin"])
def test_a_part_that_stands_off_is_drawn_and_not_below_the_foot(kind: str) -> None:
    item, mask = _with_a_bow(kind)
    assert item.shape is not None
    mesh = mesh_of(item.shape)
    sight = sights_of(CAMERA, {kind: mask}, (item,), {kind: mesh}, ())[kind]
    look = with_parts(sight, item, mesh)
    world = in_world(item, look)
    before = silhouette(CAMERA, in_world(item, mesh), mesh.faces)
    assert iou(silhouette(CAMERA, world, look.faces), mask) > iou(before, mask) + 0.05
    assert float(world[:, 2].min()) > float(in_world(item, mesh)[:, 2].min()) - 1e-6
    assert np.array_equal(look.vertices[: len(mesh.vertices)], mesh.vertices)


@pytest.mark.parametrize("kind", ["ball", "box"])
def test_what_a_mask_shows_beside_a_ball_or_a_box_is_no_part(kind: str) -> None:
    item, mask = _with_a_bow(kind)
    assert item.shape is not None
    mesh = mesh_of(item.shape)
    sight = sights_of(CAMERA, {kind: mask}, (item,), {kind: mesh}, ())[kind]
    assert with_parts(sight, item, mesh) is mesh


def test_a_ball_stays_round() -> None:
    """A lump on its mask is no lump on the ball."""
    shape, lift = SHAPES["ball"]
    item = _thing("ball", shape, 0.0, lift)
    mask = np.roll(_drawn(item), 3, axis=1)
    mask[150:168, 140:170] = True
    mesh = mesh_of(shape)
    sights = sights_of(CAMERA, {"ball": mask}, (item,), {"ball": mesh}, ())
    led = covering(sights["ball"], item, mesh)
    away = led.vertices - led.vertices.mean(0)
    out = np.linalg.norm(away, axis=1)
    assert np.ptp(out) < 0.06 * float(out.mean())


def test_shade_at_the_foot_of_a_ball_is_none_of_it() -> None:
    ball, shade = np.zeros((200, 200), np.uint8), np.zeros((200, 200), np.uint8)
    cv2.circle(ball, (100, 90), 60, 1, -1)
    cv2.ellipse(shade, (95, 150), (45, 9), 0, 0, 360, 1, -1)
    photo = np.full((200, 200, 3), 150, np.uint8)
    photo[shade > 0] = 60
    photo[ball > 0] = (220, 120, 30)
    cut = without_spill(photo, (ball | shade) > 0)
    assert iou(cut, ball > 0) > 0.985
    box = np.zeros((200, 200), bool)
    box[40:160, 50:150] = True
    assert np.array_equal(without_spill(photo, box), box)


def test_the_foot_of_a_fruit_that_is_no_circle_is_its_own() -> None:
    ball, foot = np.zeros((200, 200), np.uint8), np.zeros((200, 200), np.uint8)
    cv2.circle(ball, (100, 90), 60, 1, -1)
    cv2.ellipse(foot, (100, 140), (40, 22), 0, 0, 360, 1, -1)
    apple = (ball | foot) > 0
    photo = np.full((200, 200, 3), 150, np.uint8)
    photo[apple] = (190, 50, 30)
    assert np.array_equal(without_spill(photo, apple), apple)


@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.slow), 3])
def test_drawn_scenes_cover_their_masks(seed: int) -> None:
    item = scene(seed)
    case = replace(_case(item), name="drawn")
    state = SceneState(
        camera=item.camera,
        objects=tuple(SceneObject(name=name, grounding=g) for name, g in case.objects),
    )
    for cover in covers_of(reconstruct(case, state, segmenter=TrueMasks(item.masks))):
        assert cover.iou >= 0.93, cover
        assert cover.jump <= 1.5, cover
