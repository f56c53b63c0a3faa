"""Supports that are seen whole: the box that shows as the region, and none where none does."""

from __future__ import annotations

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.assets import assets_dir
from physagent_studio.benchmark.reconstruction.synthetic import TrueMasks
from physagent_studio.exchange import load_case
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Click,
    Floor,
    Grounding,
    Ramp,
    SceneObject,
    SceneState,
    Slab,
    Sphere,
    Support,
)
from physagent_studio.reconstruction import photo_hash, read_photo, reconstruct
from physagent_studio.reconstruction.shapes.meshes import mesh_of, ramp_corners
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.reconstruction.supports.block import Block, placed
from physagent_studio.reconstruction.supports.blocks import best_block
from physagent_studio.records.case import Case

pytestmark = pytest.mark.usefixtures("unfilled")

TABLE = Path(__file__).parents[2] / "data" / "synthetic" / "table"
TRUTH = json.loads((TABLE / "truth.json").read_text())
CAMERA = Camera.model_validate(TRUTH["camera"])
IDS = np.asarray(cv2.imread(str(TABLE / "ids.png"), cv2.IMREAD_UNCHANGED))
IMAGE, _ = read_photo(TABLE / "input.jpg")
REGION, COVERED = IDS == 3, (IDS == 1) | (IDS == 2)


def test_a_block_is_found_from_its_outline() -> None:
    found = best_block(CAMERA, IMAGE, [REGION], COVERED)
    assert found is not None
    block, overlap = found
    assert overlap > 0.95
    slab, true = block.slab(CAMERA.position[2]), TRUTH["supports"][2]["shape"]
    distance = float(np.hypot(*true["position"][:2]))
    assert np.subtract(slab.position, true["position"]) == pytest.approx(0, abs=0.03 * distance)
    assert slab.size == pytest.approx(true["size"], rel=0.05)
    assert slab.yaw == pytest.approx(true["yaw"], abs=np.radians(2))
    assert found == best_block(CAMERA, IMAGE, [REGION], COVERED), "the same bits again"


def test_a_wedge_is_found_from_its_outline() -> None:
    folder = TABLE.parent / "ramp"
    truth = json.loads((folder / "truth.json").read_text())
    ids = np.asarray(cv2.imread(str(folder / "ids.png"), cv2.IMREAD_UNCHANGED))
    image, _ = read_photo(folder / "input.jpg")
    camera = Camera.model_validate(truth["camera"])
    found = best_block(camera, image, [ids == 3], (ids == 1) | (ids == 2), "wedge")
    assert found is not None
    ramp, true = found[0].ramp(camera.position[2]), truth["supports"][2]["shape"]
    assert np.subtract(ramp.toe, true["toe"]) == pytest.approx(0, abs=0.01)
    assert (ramp.run, ramp.rise, ramp.width) == pytest.approx(
        (true["run"], true["rise"], true["width"]), rel=0.06
    )
    slope, true_slope = np.arctan2(ramp.rise, ramp.run), np.arctan2(true["rise"], true["run"])
    assert np.degrees(slope) == pytest.approx(np.degrees(true_slope), abs=1.0)
    assert ramp.yaw == pytest.approx(true["yaw"], abs=np.radians(2))


VIEW = Camera.from_horizon((416, 312), -60.0, 0.5, focal=340.0, source="given")


@pytest.mark.parametrize("yaw", [1.57, 0.7])
def test_a_slope_is_found_from_its_upper_side_alone(yaw: float) -> None:
    true = Ramp(toe=(-0.1, 0.8, 0), yaw=yaw, run=0.36, rise=0.14, width=0.2)
    (a, _, b), (d, _, c) = ramp_corners(true)
    camera = Camera.from_horizon((832, 624), -120.0, 0.5, focal=680.0, source="given")
    pixels, _ = camera.project(np.array([a, b, c, d]))
    upper = cv2.fillPoly(np.zeros((624, 832), np.uint8), [np.floor(pixels).astype(np.int32)], 1)
    image = np.where(upper[..., None] > 0, (210, 180, 140), (90, 90, 95)).astype(np.uint8)
    part = (upper > 0) & (np.indices(upper.shape)[0] > pixels[:, 1].mean())
    found = best_block(camera, image, [part, upper > 0], np.zeros_like(part), "wedge")
    assert found is not None
    ramp = found[0].ramp(camera.position[2])
    assert np.degrees(np.arctan2(ramp.rise, ramp.run)) == pytest.approx(21.25, abs=2.0)
    assert (ramp.run, ramp.width) == pytest.approx((true.run, true.width), rel=0.06)
    assert np.sin(ramp.yaw - yaw) == pytest.approx(0, abs=np.radians(3))


@pytest.mark.parametrize("yaw", [1.57, 0.7, 3.0, -0.4])
def test_a_ball_on_a_slope_lies_where_it_is_seen(yaw: float) -> None:
    camera = VIEW
    ramp = Ramp(toe=(-0.1 * np.cos(yaw), 0.85, 0), yaw=yaw, run=0.36, rise=0.14, width=0.2)
    ahead, radius = np.array([np.cos(yaw), np.sin(yaw), 0]), 0.03
    normal = np.array([*(-ramp.rise * ahead[:2]), ramp.run]) / np.hypot(ramp.rise, ramp.run)
    place = np.array(ramp.toe) + ahead * 0.22 + [0, 0, 0.22 * 0.14 / 0.36] + normal * radius
    ball = mesh_of(Sphere(radius=radius))
    mask = silhouette(camera, ball.vertices + place, ball.faces)
    image = np.where(mask[..., None], (200, 50, 40), (140, 140, 140)).astype(np.uint8)
    y, x = (float(v) for v in np.argwhere(mask).mean(0))
    click = Grounding(points=(Click(x=x, y=y),))
    case = Case("t", image, photo_hash(image), (("ball", click),), (), (), "It rolls.")
    state = SceneState(
        camera=camera,
        supports=(Support(name="ramp", shape=ramp), Support(name="floor", shape=Floor())),
        objects=(SceneObject(name="ball", grounding=click, support="ramp"),),
    )
    found = reconstruct(case, state, segmenter=TrueMasks({"ball": mask})).state.objects[0]
    assert found.shape is not None
    assert found.shape.kind == "sphere"
    assert found.position == pytest.approx(place, abs=0.02)


def test_the_best_of_several_masks_decides() -> None:
    spilled = REGION.copy()
    spilled[150:200, 20:120] = True
    assert best_block(CAMERA, IMAGE, [spilled], COVERED) is None
    assert best_block(CAMERA, IMAGE, [spilled, REGION], COVERED) is not None


def test_what_is_no_box_or_is_cut_off_is_none() -> None:
    nothing = np.zeros_like(REGION)
    circle = nothing.astype(np.uint8)
    cv2.circle(circle, (200, 150), 50, 1, -1)
    cut = REGION.copy()
    cut[:, :170] = False
    for region in (circle.astype(bool), nothing, np.roll(cut, -170, axis=1)):
        assert best_block(CAMERA, IMAGE, [region], nothing) is None


def test_a_marked_top_that_is_seen_as_a_block_reaches_the_ground() -> None:
    case = load_case(assets_dir() / "table", "falls_off")
    state = RuleGenerator().first(case, lambda state: reconstruct(case, state)).scene
    table, cube = state.support("table"), state.object("yellow_cube")
    assert table is not None
    assert isinstance(table.shape, Slab)
    top = table.shape.position[2] + table.shape.size[2] / 2
    assert table.shape.size[2] == pytest.approx(top)
    assert cube is not None
    assert cube.support == "table"


@pytest.mark.parametrize(("yaw", "seen"), [(math.pi / 2, True), (-math.pi / 2, False), (0.0, True)])
def test_a_slope_that_is_seen_from_below_carries_nothing(yaw: float, seen: bool) -> None:
    wedge = Block(0.0, 3.0, (1.0, 1.0, 0.9), yaw, "wedge")
    view = Camera.from_horizon((640, 480), 220, 1.0, focal=600)
    middle = placed(np.array([[0.0, 0.0, 0.5]]), wedge)
    pixel = view.project(middle)[0][0]
    assert wedge.carries(view, (float(pixel[0]), float(pixel[1]))) == seen
