"""Guesses give way to a hand, and leave nothing behind."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from physagent_studio.program import PhysicalProgram, SetField
from physagent_studio.program.scene.state import Click, Grounding, SceneObject, SceneState
from physagent_studio.records import Case, Scene
from physagent_studio.studio.first_scene import disproved, stale_spots, without_stale
from physagent_studio.workbench import photo_edits


def _at(x: float, y: float, **more: Any) -> Grounding:
    return Grounding(points=(Click(x=x, y=y),), **more)


BALL, CUBE = _at(30, 10, proposed=True), _at(10, 10, proposed=True)
CLICKED = _at(12, 12)
STATE = SceneState(
    objects=(SceneObject(name="ball", grounding=BALL), SceneObject(name="cube", grounding=CUBE))
)
LEFT, RIGHT = np.zeros((20, 40), bool), np.zeros((20, 40), bool)
LEFT[5:16, 5:16], RIGHT[5:16, 25:36] = True, True
SCENE = Scene(
    STATE, None, None, MappingProxyType({"ball": RIGHT, "cube": LEFT}), MappingProxyType({}),
    MappingProxyType({}), MappingProxyType({}), (), "",
)  # fmt: skip
CASE = Case(
    name="case",
    image=np.zeros((20, 40, 3), np.uint8),
    image_hash="0",
    objects=(("ball", BALL), ("cube", CUBE)),
    supports=(),
    landmarks=(),
    prompt="The ball hits the cube.",
)


def test_a_click_in_what_a_guess_took_for_another_thing_disproves_the_guess() -> None:
    assert disproved(STATE, SCENE, "ball", CLICKED) == {"cube"}
    assert disproved(STATE, SCENE, "ball", _at(30, 12)) == set()
    assert disproved(STATE, None, "ball", CLICKED) == set()
    # What a person has clicked is not disproved by another click, and outside says nothing.
    cube = SceneObject(name="cube", grounding=_at(10, 10))
    clicked = STATE.model_copy(update={"objects": (STATE.objects[0], cube)})
    assert disproved(clicked, SCENE, "ball", CLICKED) == set()
    beside = Grounding(points=(*_at(30, 12).points, Click(x=12, y=12, label=0)))
    assert disproved(STATE, SCENE, "ball", beside) == set()


def test_a_disproved_guess_is_no_place_outside_of_what_is_taken() -> None:
    program = PhysicalProgram(scene=STATE)

    def taken(wrong: set[str]) -> list[Any]:
        edits = photo_edits.mask_edits(program, CASE, (), "ball", CLICKED, wrong=wrong)
        value = next(e.value for e in edits if isinstance(e, SetField) and "grounding" in e.path)
        assert isinstance(value, dict)
        points = value["points"]
        assert isinstance(points, list)
        return [(p["x"], p["y"], p["label"]) for p in points if isinstance(p, dict)]

    assert taken(set()) == [(12, 12, 1), (10, 10, 0)]
    assert taken({"cube"}) == [(12, 12, 1)]


def test_a_guess_that_was_taken_back_is_forgotten_by_the_others() -> None:
    ball = replace_points(CLICKED, Click(x=10, y=10, label=0), Click(x=2, y=2, label=0))
    moved = SceneState(
        objects=(
            SceneObject(name="ball", grounding=ball),
            SceneObject(name="cube", grounding=_at(33, 11)),
        )
    )
    assert stale_spots(CASE, STATE) == set()
    stale = stale_spots(CASE, moved)
    assert stale == {(30, 10), (10, 10)}
    assert without_stale(ball, stale) == replace_points(CLICKED, Click(x=2, y=2, label=0))
    assert without_stale(CLICKED, stale) is CLICKED
    # Where a person clicked, nothing is taken back.
    clicked = replace(CASE, objects=(("cube", _at(10, 10)),))
    assert stale_spots(clicked, moved) == set()


def replace_points(grounding: Grounding, *more: Click) -> Grounding:
    return grounding.model_copy(update={"points": (*grounding.points, *more)})
