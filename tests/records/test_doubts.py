"""Doubts: what is more likely wrong than right, the worst first."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Grounding, SceneObject, SceneState
from physagent_studio.records import Scene, doubts_of


def _scene(sigma: float | None = None, *, confirmed: bool = False, **sureness: float) -> Scene:
    camera = Camera.from_horizon(
        (640, 480), 200.0, 1.0, source="estimated", confirmed=confirmed, horizon_sigma=sigma
    )
    none = MappingProxyType({})
    photo = np.zeros((480, 640, 3), np.uint8)
    state = SceneState(camera=camera)
    scene = Scene(state, photo, photo, none, none, none, none, (), "")
    return replace(scene, sureness=MappingProxyType(dict(sureness)))


def test_masks_below_one_half_are_doubted_worst_first() -> None:
    found = doubts_of(_scene(ball=0.49, duck=0.2, cup=0.5))
    assert [(one.kind, one.name) for one in found] == [("mask", "duck"), ("mask", "ball")]
    assert found[0].text == "the mask of duck is doubtful (20 % sure): draw a box around duck"


@pytest.mark.parametrize(("sigma", "doubted"), [(20.0, False), (120.0, False), (200.0, True)])
def test_a_camera_is_doubted_where_its_horizon_may_be_far_off(sigma: float, doubted: bool) -> None:
    assert [one.kind for one in doubts_of(_scene(sigma))] == ["camera"] * doubted


def test_what_a_person_has_confirmed_is_not_doubted() -> None:
    assert doubts_of(_scene(300.0, confirmed=True)) == ()


def test_words_that_nobody_understood_are_doubts_as_well() -> None:
    (found,) = doubts_of(None, ["sideways"])
    assert (found.kind, found.name, found.probability) == ("word", "sideways", 0.0)


def test_no_box_is_asked_for_where_one_is_drawn() -> None:
    scene = _scene(duck=0.2)
    duck = SceneObject(name="duck", grounding=Grounding(box=(1.0, 1.0, 9.0, 9.0)))
    state = scene.state.model_copy(update={"objects": (duck,)})
    (found,) = doubts_of(replace(scene, state=state))
    assert found.helps == "click on what is missing of duck, or paint over it in the studio"
