"""From which tilt a thing has fallen over, by its own form."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.scene.sides import lying_from
from physagent_studio.program.scene.state import (
    Box,
    Cylinder,
    Floor,
    Frustum,
    SceneObject,
    SceneState,
    Shape,
    Sphere,
    Support,
)
from tests.agent.rules.scenes import Stage

TOP = Frustum(bottom_radius=0.001, top_radius=0.05, height=0.04)
BOWL = Frustum(bottom_radius=0.03, top_radius=0.08, height=0.05)


def _alone(shape: Shape) -> Layout:
    item = SceneObject(name="thing", shape=shape, position=(0, 3, 0.1), support="floor")
    floor = Support(name="floor", shape=Floor())
    return Layout(SceneState(objects=(item,), supports=(floor,)))


@pytest.mark.parametrize(
    ("shape", "tilt"),
    [
        (Box(size=(0.01, 0.03, 0.05)), 60.0),
        (Cylinder(radius=0.03, height=0.2), 60.0),
        (Frustum(bottom_radius=0.05, top_radius=0.001, height=0.1), 60.0),
        (Sphere(radius=0.05), 60.0),
        (TOP, 35.1),
        (BOWL, 40.5),
    ],
)
def test_a_thing_lies_on_its_own_side(shape: Shape, tilt: float) -> None:
    assert lying_from(_alone(shape), "thing", 60.0) == pytest.approx(tilt, abs=0.5)


@pytest.mark.parametrize(
    ("prompt", "most"),
    [
        ("The crate tips over onto its side.", 125.0),
        ("The crate falls on its back.", 125.0),
        ("The crate tips over.", None),
        ("The dog falls on its side.", 125.0),
        ("The dog falls on its back.", None),
    ],
)
def test_only_what_stands_tall_lies_on_its_back_without_being_upside_down(prompt, most) -> None:
    things = {
        "crate": (Box(size=(0.4, 0.4, 0.8)), (0.5, 3.0, 0.4), "floor"),
        "dog": (Box(size=(0.8, 0.2, 0.5)), (-0.5, 3.0, 0.25), "floor"),
    }
    stage = Stage("yard", things)
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    assert [s.most for s in program.contract.statements if s.kind == "topples"] == [most]


@pytest.mark.parametrize(
    "prompt",
    [
        "The spinning top spins, then it falls over and lies on its side.",
        "The spinning top tips over onto its side.",
        "The spinning top wobbles and topples over.",
    ],
)
def test_a_top_is_asked_for_no_more_than_its_flank(prompt: str) -> None:
    stage = Stage("toys", {"spinning_top": (TOP, (0, 2.5, 0.02), "floor")})
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    asked = [s.tilt for s in program.contract.statements if s.kind == "topples" and not s.negated]
    assert asked
    assert all(tilt <= 39.0 for tilt in asked)
