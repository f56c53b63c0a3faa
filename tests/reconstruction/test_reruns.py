"""Reruns fill what is open and nothing else: what a person corrected survives each of them."""

import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.synthetic import TrueMasks, scene
from physagent_studio.program.scene.state import (
    Box,
    Click,
    Grounding,
    Landmark,
    Scale,
    SceneObject,
    SceneState,
    Slab,
    Sphere,
    Support,
)
from physagent_studio.reconstruction import photo_hash, reconstruct
from physagent_studio.reconstruction.background.scene_plate import scene_plate
from physagent_studio.reconstruction.masks import sureness
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.records.case import Case
from physagent_studio.records.scene import Scene

KEPT = Box(size=(0.3, 0.2, 0.25))
PLACE = (0.4, 3.1, 0.125)
STEP = Support(name="step", shape=Slab(position=(1.5, 3.0, 0.1), size=(0.5, 0.5, 0.2)))
MARK = Landmark(name="target", kind="point", on="floor", pixels=((320.0, 300.0),))


@pytest.fixture(scope="module")
def drawn():
    return scene(2)


@pytest.fixture(scope="module")
def corrected(drawn) -> tuple[Case, Scene]:
    """A scene that was reconstructed, then corrected: one object's shape and place, one step."""
    grounding = Grounding(points=(Click(x=50.0, y=50.0),))
    names = [item.name for item in drawn.objects]
    case = Case(
        name="t",
        image=drawn.image,
        image_hash=photo_hash(drawn.image),
        objects=tuple((name, grounding) for name in names),
        supports=(),
        landmarks=(),
        prompt="It moves.",
    )
    objects = tuple(SceneObject(name=name, grounding=grounding) for name in names)
    state = SceneState(objects=objects, horizon=drawn.camera.horizon, landmarks=(MARK,))
    found = reconstruct(case, state, segmenter=TrueMasks(drawn.masks))
    hand = found.state.objects[0].model_copy(
        update={"shape": KEPT, "position": PLACE, "source": "person"}
    )
    state = found.state.model_copy(
        update={
            "objects": (hand, *found.state.objects[1:]),
            "supports": (*found.state.supports, STEP),
        }
    )
    return case, reconstruct(case, state, previous=found)


def _open(state: SceneState, **update) -> SceneState:
    """Everything open that hangs on the camera, but for what a person gave."""
    objects = tuple(
        item
        if item.source == "person"
        else item.model_copy(update={"shape": None, "position": None})
        for item in state.objects
    )
    marks = tuple(mark.model_copy(update={"points": None}) for mark in state.landmarks)
    return state.model_copy(
        update={"camera": None, "objects": objects, "landmarks": marks, **update}
    )


EDITS = {
    "horizon": {"horizon": 20.0, "horizon_source": "person"},
    "scale": {"scale": Scale(reference="object_2", metres=1.1, source="person")},
    "nothing": {},
}


@pytest.mark.usefixtures("unfilled_here")
@pytest.mark.parametrize("edit", EDITS)
def test_corrections_survive_and_what_is_open_follows(drawn, corrected, edit):
    case, before = corrected
    state = _open(before.state, **EDITS[edit])
    after = reconstruct(case, state, previous=before, segmenter=TrueMasks(drawn.masks))
    hand = after.state.objects[0]
    assert (hand.shape, hand.position, hand.source) == (KEPT, PLACE, "person")
    assert STEP in after.state.supports
    assert after.state.is_resolved
    assert after.state.landmarks[0].points is not None
    moved = [
        float(np.linalg.norm(np.subtract(a.position or PLACE, b.position or PLACE)))
        for a, b in zip(after.state.objects[1:], before.state.objects[1:], strict=True)
    ]
    if edit == "nothing":
        assert max(moved) < 1e-9
    else:
        assert min(moved) > 0.02
        assert after.state.landmarks[0].points != before.state.landmarks[0].points
    assert (after.plate is before.plate) == (edit != "horizon")


def test_a_typed_horizon_turns_a_camera_that_is_there(corrected, monkeypatch):
    case, before = corrected
    # How sure masks are that stay as they are is not asked again.
    monkeypatch.setattr(sureness, "probability", None)
    assert before.state.camera is not None
    row = before.state.camera.horizon + 25
    state = before.state.model_copy(update={"horizon": row, "horizon_source": "person"})
    after = reconstruct(case, state, previous=before)
    assert after.state.camera is not None
    assert after.state.horizon == pytest.approx(row, abs=1e-6)
    assert after.state.camera.horizon == pytest.approx(row, abs=1e-6)
    assert after.state.camera.focal == before.state.camera.focal
    assert after.state.camera.confirmed
    assert after.sureness == before.sureness != {}
    assert after.state.objects[0] == before.state.objects[0]
    # The ground runs otherwise through the photo: it is filled in anew, as if for the first time.
    found = segments(case.image)
    fresh = scene_plate(
        case.image, after.masks, found, after.state.camera, after.state.supports, None
    )
    assert after.plate is not None
    assert np.array_equal(after.plate, fresh)
    assert not np.array_equal(after.plate, before.plate)


def test_what_no_picture_shows_changes_nothing_that_it_shows(corrected):
    case, before = corrected
    items = tuple(o.model_copy(update={"density": 700.0}) for o in before.state.objects)
    after = reconstruct(case, before.state.model_copy(update={"objects": items}), previous=before)
    assert after.meshes is before.meshes
    assert after.state.objects[1].density == 700.0


def test_what_a_person_sets_down_in_the_scene_is_not_sought_in_the_photo(corrected):
    case, found = corrected
    ball = SceneObject(
        name="added", shape=Sphere(radius=0.1), position=(0.0, 2.5, 0.1), source="person"
    )
    state = found.state.model_copy(update={"objects": (*found.state.objects, ball)})
    after = reconstruct(case, state, previous=found)
    assert after.state.objects[-1] == ball
    assert "added" in after.meshes
    assert after.plate is found.plate  # nothing of the photo is behind it
    assert all(one.ok for one in after.findings if one.subject == "added")
    # What the photo shows is judged as before, also where the new thing would cover it.
    kept = {(one.name, one.subject): one.ok for one in found.findings}
    for one in after.findings:
        if one.subject != "added":
            assert one.ok == kept[one.name, one.subject]
