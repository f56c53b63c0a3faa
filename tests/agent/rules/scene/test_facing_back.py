"""Which way seats, animals and their likenesses face, and so where forward and backward are."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.scene.facing import before_its_back, likely_front, long_axis
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.program.scene.forms import Inflated
from physagent_studio.program.scene.state import Wheels
from tests.agent.rules.scenes import Stage

BACKREST = ((-0.2, -0.2, 0.45), (-0.15, 0.2, 0.45), (-0.2, 0.0, -0.45), (0.2, 0.2, 0.0),
            (0.2, -0.2, 0.0), (0.2, 0.0, -0.45))  # fmt: skip


def _stage(name: str, shape: Inflated) -> Stage:
    return Stage("room", {name: (shape, (0.0, 3.0, shape.size[2] / 2), "floor")})


def _seat(side: int) -> Inflated:
    hull = tuple((side * x, y, z) for x, y, z in BACKREST)
    return Inflated(size=(0.4, 0.4, 0.9), hull=hull)


@pytest.mark.parametrize("side", [1, -1])
def test_a_seat_faces_away_from_its_highest_side_and_falls_backwards_that_way(side: int) -> None:
    stage = _stage("chair", _seat(side))
    layout = Layout(RuleGenerator().first(stage.case("The chair falls."), stage.reconstruct).scene)
    ahead = before_its_back(layout, "chair")
    assert ahead is not None
    assert ahead @ (side, 0, 0) == pytest.approx(1)
    for words in ("The chair tips over backwards.", "The chair falls over onto its back."):
        program = RuleGenerator().first(stage.case(words), stage.reconstruct)
        moved = [s.direction for s in program.contract.statements if s.kind == "moves"]
        assert set(moved) == {"left" if side > 0 else "right"}


def test_what_is_as_high_on_both_sides_does_not_tell() -> None:
    even = tuple((x, y, 0.45 if abs(z) > 0.4 else z) for x, y, z in BACKREST)
    both = (*even, *((-x, y, z) for x, y, z in even))
    stage = _stage("chair", Inflated(size=(0.4, 0.4, 0.9), hull=both))
    layout = Layout(RuleGenerator().first(stage.case("The chair falls."), stage.reconstruct).scene)
    assert before_its_back(layout, "chair") is None


@pytest.mark.parametrize("name", ["pig", "pig_figurine", "cow"])
def test_an_animal_that_is_longer_than_high_is_seen_from_its_side(name: str) -> None:
    stage = _stage(name, Inflated(size=(0.35, 0.3, 0.27)))
    layout = Layout(
        RuleGenerator().first(stage.case(f"The {name} falls."), stage.reconstruct).scene
    )
    axis, shown = long_axis(layout, name)
    front = likely_front(layout, name)
    assert shown
    assert abs(axis[0]) == pytest.approx(1)
    assert front is not None
    assert np.abs(front) @ (1, 0, 0) == pytest.approx(1)


def test_casters_do_not_say_which_way_an_office_chair_faces() -> None:
    stage = _stage("office_chair", _seat(1))
    scene = RuleGenerator().first(stage.case("The office chair falls."), stage.reconstruct).scene
    wheels = Wheels(heading=90.0)
    items = tuple(o.model_copy(update={"wheels": wheels}) for o in scene.objects)
    front = likely_front(Layout(scene.model_copy(update={"objects": items})), "office_chair")
    assert front == pytest.approx((1, 0, 0))


def test_what_is_seen_turned_lies_as_its_plan_does() -> None:
    shape = Inflated(size=(0.3, 0.3, 0.2), turn=45.0, hull=((0.15, 0.15, 0.1), (-0.15, -0.15, -0.1),
                     (0.1, 0.15, 0.0), (-0.1, -0.15, 0.0)))  # fmt: skip
    stage = _stage("cow", shape)
    scene = RuleGenerator().first(stage.case("The cow falls."), stage.reconstruct).scene
    axis, shown = long_axis(Layout(scene), "cow")
    assert shown
    assert abs(axis @ (1, 1, 0)) > 1.3
