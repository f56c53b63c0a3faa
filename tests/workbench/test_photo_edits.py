"""Corrections in the photo: one group of edits each, the scene follows, undo brings all back."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.errors import InputError
from physagent_studio.program import SetField, apply
from physagent_studio.program.scene.state import Click, Grounding, Landmark, Stroke
from physagent_studio.session import Store
from physagent_studio.workbench import Snapshot, Workbench, commands, photo_edits


@pytest.fixture(scope="module")
def workbench(tmp_path_factory: pytest.TempPathFactory, unfilled: None) -> Iterator[Workbench]:
    """The demo, reconstructed; every test undoes what it does."""
    made = Workbench(Store(tmp_path_factory.mktemp("photo")), evidence=False)
    made.post(commands.OpenCase(assets_dir() / "demo"))
    assert made.wait(120)
    yield made
    made.close()


@pytest.fixture
def before(workbench: Workbench) -> Iterator[Snapshot]:
    first = workbench.snapshot()
    yield first
    while workbench.snapshot().has_draft:
        workbench.post(commands.Undo())
        assert workbench.wait(60)
    assert workbench.snapshot().program == first.program


def carry_out(workbench: Workbench, edits) -> Snapshot:
    """Edits applied; no notice came of them."""
    told = len(workbench.snapshot().notices)
    workbench.post(commands.ApplyEdits(tuple(edits), "test"))
    assert workbench.wait(120)
    after = workbench.snapshot()
    assert [one.text for one in after.notices[told:]] == []
    assert after.has_draft
    assert after.program.scene.is_closed
    return after


@pytest.mark.slow
def test_the_scene_follows_the_horizon(workbench: Workbench, before: Snapshot) -> None:
    scene = before.program.scene
    assert before.case is not None
    assert scene.camera is not None
    row = scene.camera.horizon - 40
    edits = photo_edits.horizon_edits(before.program, before.case, (), row)
    after = carry_out(workbench, edits).program.scene
    assert after.camera is not None
    assert after.camera.horizon == pytest.approx(row, abs=0.5)
    assert after.camera.confirmed
    assert after.horizon_source == "person"
    moved = zip(scene.objects, after.objects, strict=True)
    assert all(old.position != new.position for old, new in moved)


def test_a_tilted_horizon_turns_the_camera(workbench: Workbench, before: Snapshot) -> None:
    scene = before.program.scene
    assert before.case is not None
    assert scene.camera is not None
    row = scene.camera.horizon
    edits = photo_edits.horizon_edits(before.program, before.case, (), row, 3.0)
    after = carry_out(workbench, edits).program.scene
    assert after.camera is not None
    assert after.roll == 3.0
    assert np.degrees(after.camera.roll) == pytest.approx(3.0)
    assert after.camera.horizon == pytest.approx(row, abs=0.5)
    # Moved up, it stays tilted.
    program = before.program.model_copy(update={"scene": after})
    again = photo_edits.horizon_edits(program, before.case, (), row - 20)
    assert all(edit.path != "scene.roll" for edit in again)


@pytest.mark.slow
def test_a_size_scales_everything(workbench: Workbench, before: Snapshot) -> None:
    scene, case = before.program.scene, before.case
    assert case is not None
    name = scene.objects[0].name
    small = carry_out(workbench, photo_edits.size_edits(before.program, case, (), name, 0.1))
    large = carry_out(workbench, photo_edits.size_edits(small.program, case, (), name, 1.0))
    one, other = small.program.scene.camera, large.program.scene.camera
    assert one is not None
    assert other is not None
    assert other.position[2] / one.position[2] == pytest.approx(10, rel=0.05)
    assert large.program.scene.scale.source == "person"


def test_what_is_pinned_stays(workbench: Workbench, before: Snapshot) -> None:
    scene, case = before.program.scene, before.case
    assert case is not None
    item = scene.objects[0]
    pinned = (f"scene.objects.{item.name}.position",)
    edits = photo_edits.horizon_edits(before.program, case, pinned, 10.0)
    assert pinned[0] not in {edit.path for edit in edits}
    after = carry_out(workbench, edits).program.scene.object(item.name)
    assert after is not None
    assert after.position == item.position


def test_a_mask_survives_a_rerun(workbench: Workbench, before: Snapshot) -> None:
    scene, case = before.program.scene, before.case
    assert case is not None
    assert before.scene is not None
    item = scene.objects[0]
    rows, columns = np.nonzero(before.scene.masks[item.name])
    x, y = float(np.median(columns)), float(np.median(rows))
    brush = Stroke(effect="erase", points=((x, y),), radius=4)
    mine = item.grounding.model_copy(update={"strokes": (brush,)})
    edits = photo_edits.mask_edits(before.program, case, (), item.name, mine)
    after = carry_out(workbench, edits)
    assert after.scene is not None
    mask = after.scene.masks[item.name]
    assert not mask[int(y), int(x)]

    again = photo_edits.horizon_edits(after.program, case, (), 30.0)
    later = carry_out(workbench, again)
    assert later.scene is not None
    assert np.array_equal(later.scene.masks[item.name], mask)


def test_what_stood_on_a_wrong_mask_finds_its_place_anew(
    workbench: Workbench, before: Snapshot
) -> None:
    ball, block = before.program.scene.objects[:2]
    wrong = SetField(path=f"scene.objects.{block.name}.support", value=ball.name)
    program = apply(before.program, (wrong,))
    assert before.case is not None
    edits = photo_edits.mask_edits(program, before.case, (), ball.name, ball.grounding)
    after = carry_out(workbench, (wrong, *edits)).program.scene.object(block.name)
    assert after is not None
    assert after.support == block.support


def test_another_form(workbench: Workbench, before: Snapshot) -> None:
    item = before.program.scene.objects[0]
    assert item.shape is not None
    edits = photo_edits.form_edits(before.program, (), item.name, None)
    after = carry_out(workbench, edits).program.scene.object(item.name)
    assert after is not None
    assert after.shape is not None
    assert after.shape.kind == after.form != item.shape.kind


def test_shapes_are_walked_in_their_order_and_none_is_forgotten(
    workbench: Workbench, before: Snapshot
) -> None:
    item = before.program.scene.objects[0]
    assert before.scene is not None
    offers = before.scene.shapes[item.name]
    assert len(offers) > 1
    assert [one.merit for one in offers] == sorted((one.merit for one in offers), reverse=True)
    order = photo_edits.forms_of(item.name, before.program.event.prompt, offers)
    assert list(order[: len(offers)]) == [one.kind for one in offers]
    assert sorted(order) == sorted(photo_edits.FORMS)
    assert item.shape is not None
    after_it = order[(order.index(item.shape.kind) + 1) % len(order)]
    edits = photo_edits.form_edits(before.program, (), item.name, None, offers)
    after = carry_out(workbench, edits)
    made = after.program.scene.object(item.name)
    assert made is not None
    assert made.form == after_it
    assert after.scene is not None
    assert {one.kind for one in after.scene.shapes[item.name]} >= {one.kind for one in offers}


def test_a_ramp_by_three_clicks(workbench: Workbench, before: Snapshot) -> None:
    case = before.case
    assert case is not None
    assert case.image is not None
    height, width = case.image.shape[:2]
    toe, foot = (0.3 * width, 0.9 * height), (0.6 * width, 0.9 * height)
    top = (0.6 * width, 0.7 * height)
    edits = photo_edits.ramp_edits(before.program, case, (), "", (toe, foot, top))
    after = carry_out(workbench, edits).program.scene.support("ramp")
    assert after is not None
    assert after.shape is not None
    assert after.shape.kind == "ramp"
    camera = workbench.snapshot().program.scene.camera
    assert camera is not None
    seen = camera.project(np.array([after.shape.toe]))[0][0]
    assert seen == pytest.approx(toe, abs=0.15 * width)


def test_nonsense_is_refused_in_a_sentence(before: Snapshot) -> None:
    program, case = before.program, before.case
    assert case is not None
    name = program.scene.objects[0].name
    far = Grounding(points=(Click(x=9e4, y=1),))
    with pytest.raises(InputError, match="lies outside the picture"):
        photo_edits.mask_edits(program, case, (), name, far)
    with pytest.raises(InputError, match="nothing is marked as inside"):
        photo_edits.mask_edits(program, case, (), name, Grounding())
    with pytest.raises(InputError, match="too far from the picture"):
        photo_edits.horizon_edits(program, case, (), 9e4)
    with pytest.raises(InputError, match="no size of a thing"):
        photo_edits.size_edits(program, case, (), name, 1e4)
    with pytest.raises(InputError, match="three clicks"):
        photo_edits.ramp_edits(program, case, (), "", ((5, 5), (6, 5), (6, 9)))


def test_a_new_thing_is_added(workbench: Workbench, before: Snapshot, tmp_path: Path) -> None:
    case = before.case
    assert case is not None
    points = before.program.scene.objects[0].grounding.points
    beside = Click(x=points[0].x + 1, y=points[0].y + 1)
    edits = photo_edits.mask_edits(before.program, case, (), "thing", Grounding(points=(beside,)))
    assert carry_out(workbench, edits).program.scene.object("thing") is not None


def test_a_landmark_without_pixels_stays_where_it_is_seen(before: Snapshot) -> None:
    """The line that was assumed before a ball lies elsewhere when the horizon moves."""
    scene = before.program.scene
    assert scene.camera is not None
    assert before.case is not None
    marks = (
        Landmark(name="line", kind="line", points=((-0.2, 3, 0), (0.3, 3, 0)), source="assumed"),
        Landmark(name="typed", kind="point", points=((0.1, 3, 0),), source="person"),
    )
    program = before.program.model_copy(
        update={"scene": scene.model_copy(update={"landmarks": marks})}
    )
    edits = photo_edits.horizon_edits(program, before.case, (), scene.camera.horizon - 30)
    after: dict[str, Any] = {edit.path: edit.value for edit in edits if isinstance(edit, SetField)}
    pixels = scene.camera.project(np.array(marks[0].points))[0]
    assert np.allclose(np.array(after["scene.landmarks.line.pixels"]), pixels, atol=0.1)
    assert after["scene.landmarks.line.points"] is None
    assert not any("typed" in path for path in after)
    pinned = ("scene.landmarks.line.points",)
    kept = photo_edits.horizon_edits(program, before.case, pinned, 10.0)
    assert not any("landmarks" in edit.path for edit in kept)


def test_like_things_are_marked_as_one_group(before: Snapshot) -> None:
    assert before.case is not None
    boxes = ((120.0, 300.0, 240.0, 410.0), (300.0, 300.0, 340.0, 360.0))
    edits = photo_edits.alike_edits(before.program, before.case, (), "green_cube", boxes)
    scene = apply(before.program, edits).scene
    found = [scene.object(name) for name in ("cube_2", "cube_3")]
    assert [item.grounding.box for item in found if item is not None] == list(boxes)
