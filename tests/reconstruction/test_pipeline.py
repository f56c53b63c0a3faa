"""The whole way, on pictures with known truth."""

import math
from pathlib import Path

import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.bench import reference_masks
from physagent_studio.benchmark.reconstruction.synthetic import TrueMasks, scene
from physagent_studio.errors import Cancelled, InputError
from physagent_studio.exchange import load_case
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Box,
    Click,
    Grounding,
    Scale,
    SceneObject,
    SceneState,
    Sphere,
)
from physagent_studio.reconstruction import photo_hash, reconstruct
from physagent_studio.reconstruction.background.plate import fill
from physagent_studio.reconstruction.contact_sheet import contact_sheet
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.records.case import Case


def _case(image, names, prompt="It moves.", click=(50.0, 50.0)):
    grounding = Grounding(points=(Click(x=click[0], y=click[1]),))
    objects = tuple((name, grounding) for name in names)
    return Case("t", image, photo_hash(image), objects, (), (), prompt)


def _state(case, **update):
    objects = tuple(SceneObject(name=name, grounding=g) for name, g in case.objects)
    return SceneState(objects=objects, **update)


def _object(found, name) -> SceneObject:
    item = found.state.object(name)
    assert item is not None
    return item


@pytest.fixture(scope="module")
def drawn():
    return scene(2)


@pytest.fixture(scope="module")
def made(drawn):
    case = _case(drawn.image, [o.name for o in drawn.objects])
    state = _state(case, camera=drawn.camera)
    return case, state, reconstruct(case, state, segmenter=TrueMasks(drawn.masks))


def test_objects_are_where_they_are(drawn, made):
    _, _, found = made
    for truth in drawn.objects:
        item = _object(found, truth.name)
        assert item.position == pytest.approx(truth.position, abs=0.08)
        assert item.support == "floor"


@pytest.mark.usefixtures("unfilled_here")
def test_a_tilted_horizon_tilts_the_camera():
    """Said to be level, the same picture has things half a hand farther off."""
    drawn = scene(2, roll=math.radians(5))
    case = _case(drawn.image, [o.name for o in drawn.objects])
    row, focal = drawn.camera.horizon, drawn.camera.focal
    level = Camera.from_horizon(drawn.camera.size, row, 1.0, focal=focal)
    off = {}
    for roll in (0.0, 5.0):
        state = _state(case, camera=level, horizon=row, horizon_source="person", roll=roll)
        found = reconstruct(case, state, segmenter=TrueMasks(drawn.masks))
        assert found.state.camera is not None
        assert math.degrees(found.state.camera.roll) == pytest.approx(roll, abs=1e-6)
        assert found.state.camera.horizon == pytest.approx(row)
        places = [_object(found, truth.name).position for truth in drawn.objects]
        truths = [truth.position for truth in drawn.objects]
        off[roll] = np.linalg.norm(np.array(places) - np.array(truths), axis=1).max()
    assert off[5.0] < 0.04
    assert off[0.0] > 0.1


def test_every_check_holds_and_nothing_is_open(made):
    _, _, found = made
    assert found.state.is_resolved
    assert [f.text for f in found.findings if not f.ok] == []
    contacts = [f.measured for f in found.findings if f.name == "contact"]
    assert contacts
    assert all(0 < gap < 1e-4 for gap in contacts)


def test_a_rerun_without_changes_is_the_same_scene(made):
    case, state, found = made
    assert reconstruct(case, state, previous=found) is found


def test_what_a_person_set_survives_a_rerun(drawn, made):
    case, _, found = made
    name = drawn.objects[0].name
    items = tuple(
        item.model_copy(update={"shape": Sphere(radius=0.123), "position": None})
        if item.name == name
        else item
        for item in found.state.objects
    )
    state = found.state.model_copy(update={"objects": items})
    again = reconstruct(case, state, previous=found)
    changed = _object(again, name)
    assert changed.shape == Sphere(radius=0.123)
    assert (changed.position or (0, 0, 0))[2] == pytest.approx(0.123, abs=1e-3)
    assert again.plate is found.plate  # same masks, same background
    for other in drawn.objects[1:]:
        assert _object(again, other.name) == _object(found, other.name)


def test_same_bits_twice(drawn, made):
    case, state, found = made
    again = reconstruct(case, state, segmenter=TrueMasks(drawn.masks))
    assert again.state == found.state
    assert again.plate is not None
    assert np.array_equal(again.plate, found.plate)


@pytest.mark.usefixtures("unfilled_here")
def test_one_click_finds_the_objects(drawn):
    case = _case(drawn.image, ["thing"])
    mask = drawn.masks["object_1"]
    rows, columns = np.nonzero(mask)
    click = Click(x=float(np.median(columns)), y=float(np.median(rows)))
    state = SceneState(
        objects=(SceneObject(name="thing", grounding=Grounding(points=(click,))),),
        camera=drawn.camera,
    )
    found = reconstruct(case, state)
    assert iou(found.masks["thing"], mask) > 0.85
    assert 1 <= len(found.candidates["thing"]) <= 4


@pytest.mark.usefixtures("unfilled_here")
def test_a_typed_size_sets_the_scale(drawn):
    case = _case(drawn.image, [o.name for o in drawn.objects])
    horizon = drawn.camera.horizon
    sizes = []
    for metres in (0.2, 0.4):
        scale = Scale(reference="object_1", metres=metres, source="person")
        state = _state(case, horizon=horizon, scale=scale)
        found = reconstruct(case, state, segmenter=TrueMasks(drawn.masks))
        sizes.append(np.ptp(found.meshes["object_2"].vertices, axis=0))
        assert found.state.scale == scale
    assert sizes[1] / sizes[0] == pytest.approx(2.0, rel=0.05)


@pytest.mark.usefixtures("unfilled_here")
def test_stacked_boxes_touch():
    image = np.full((400, 640, 3), 170, np.uint8)
    rng = np.random.default_rng(0)
    image = np.clip(image + rng.normal(0, 2, image.shape), 0, 255).astype(np.uint8)
    masks = {name: np.zeros((400, 640), bool) for name in ("upper_box", "lower_box")}
    masks["lower_box"][250:330, 260:380] = True
    masks["upper_box"][180:250, 275:365] = True
    for mask, color in zip(masks.values(), ((200, 60, 40), (40, 80, 200)), strict=True):
        image[mask] = color
    case = _case(image, list(masks))
    found = reconstruct(case, _state(case, horizon=150.0), segmenter=TrueMasks(masks))
    upper, lower = _object(found, "upper_box"), _object(found, "lower_box")
    assert upper.support == "lower_box"
    assert lower.support == "floor"
    gaps = {f.subject: f.measured for f in found.findings if f.name == "contact"}
    assert gaps["upper_box"] == pytest.approx(1e-5, abs=1e-6)
    assert isinstance(lower.shape, Box)


def test_the_background_closes_over_the_object():
    ramp = np.linspace(60, 200, 300)
    image = np.repeat(np.repeat(ramp[None, :, None], 200, 0), 3, 2).astype(np.uint8)
    photo = image.copy()
    hole = np.zeros((200, 300), bool)
    hole[70:130, 110:190] = True
    photo[hole] = (255, 0, 0)
    filled = fill(photo, hole)
    assert np.array_equal(filled[~hole], photo[~hole])
    assert np.abs(filled[hole].astype(int) - image[hole]).mean() < 14


def test_clicks_outside_the_picture_are_told(drawn):
    case = _case(drawn.image, ["thing"], click=(9000.0, 10.0))
    with pytest.raises(InputError, match="outside the picture of 640 × 400"):
        reconstruct(case, _state(case))


def test_a_person_can_cancel(drawn):
    case = _case(drawn.image, ["thing"])
    with pytest.raises(Cancelled):
        reconstruct(case, _state(case), cancelled=lambda: True)


def test_the_sheet_shows_six_panels(made):
    _, _, found = made
    sheet = contact_sheet(found)
    assert sheet.dtype == np.uint8
    assert sheet.shape[1] == 3 * (560 + 4)


@pytest.mark.usefixtures("unfilled_here")
@pytest.mark.parametrize(
    ("name", "clicked"),
    [
        ("soccer_ball", 0.9),
        ("cube_table_edge", 0.9),
        ("curling", 0.9),
    ],
)
def test_photographs_with_clicks(cases_dir: Path, name, clicked):
    case = load_case(cases_dir / name)
    assert case.image is not None
    state = SceneState(
        objects=tuple(SceneObject(name=n, grounding=g) for n, g in case.objects),
        supports=case.supports,
    )
    found = reconstruct(case, state)
    for thing, mask in reference_masks(name, case.image.shape[:2]).items():
        assert iou(found.masks[thing], mask) > clicked
    assert found.state.is_resolved
    assert all(math.isfinite(v) for item in found.state.objects for v in item.position or ())
