"""What goes along with another thing: both are sent alike, do not part, and both are demanded."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.language import inventory, read
from physagent_studio.program import Grounding
from physagent_studio.program.scene.state import Box, Cylinder
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage

STREET = Stage(
    "street",
    {
        "man": (Box(size=(0.4, 0.3, 1.7)), (-1.0, 6.0, 0.95), "skateboard"),
        "skateboard": (Box(size=(0.8, 0.2, 0.1)), (-1.0, 6.0, 0.05), "floor"),
    },
)
COFFEE = Stage(
    "coffee",
    {
        "cup": (Cylinder(radius=0.04, height=0.08), (-0.2, 2.5, 0.81), "saucer"),
        "saucer": (Cylinder(radius=0.07, height=0.02), (-0.2, 2.5, 0.76), "table"),
        "book": (Box(size=(0.2, 0.15, 0.03)), (0.2, 2.5, 0.765), "table"),
        "teacup": (Cylinder(radius=0.03, height=0.06), (0.2, 2.5, 0.81), "book"),
    },
    STAGES["desk"].supports,
)


@pytest.mark.parametrize(
    ("stage", "prompt", "both"),
    [
        (STREET, "The man on the skateboard glides to the right.", ("man", "skateboard")),
        (COFFEE, "The cup glides to the right, the saucer along with it.", ("cup", "saucer")),
        (
            COFFEE,
            "The cup glides to the right across the table, saucer along with it, and stops.",
            ("cup", "saucer"),
        ),
        (COFFEE, "The book slides off the table together with the teacup.", ("book", "teacup")),
        (COFFEE, "The cup on the saucer is carried to the left.", ("cup", "saucer")),
    ],
)
def test_both_go_and_do_not_part(stage: Stage, prompt: str, both: tuple[str, str]) -> None:
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    moved = {s.subject for s in program.contract.statements if s.kind == "moves"}
    assert moved >= set(both)
    rollout = simulate(program, {})
    checks = [c for c in measure(program, rollout) if c.demanded and not c.always_on]
    assert all(check.ok for check in checks), checks
    one, other = (rollout.positions[:25, rollout.index(name)] for name in both)
    assert np.linalg.norm((one - one[0]) - (other - other[0]), axis=1).max() < 0.02


@pytest.mark.parametrize(
    ("stage", "prompt", "alone"),
    [
        (COFFEE, "The cup on the saucer slides to the left.", "cup"),
        (COFFEE, "The teacup slides off the book.", "teacup"),
        (STREET, "The man jumps off the skateboard.", "man"),
        (STREET, "The skateboard rolls to the right.", "skateboard"),
    ],
)
def test_what_only_stands_on_a_thing_goes_by_itself(stage: Stage, prompt: str, alone: str) -> None:
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    assert {action.name for action in program.event.actions} == {alone}


@pytest.mark.parametrize(
    "prompt",
    [
        "The cup slides to the left along with the saucer.",
        "Together with the saucer the cup slides to the left.",
        "The cup slides to the left, the saucer together with it.",
    ],
)
def test_company_is_read_wherever_it_is_said(prompt: str) -> None:
    things = [(name, Grounding()) for name in ("cup", "saucer")]
    told = read(prompt, inventory(things, [("table", Grounding())]))
    assert [(f.patient, f.direction) for f in told.frames] == [(("cup", "saucer"), "left")]
    assert not told.not_understood


@pytest.mark.parametrize(
    ("prompt", "below"),
    [
        ("The man on the skateboard glides to the right.", "skateboard"),
        ("The skateboard rolls to the man.", "floor"),
        ("The man walks to the right and steps on the skateboard.", "floor"),
    ],
)
def test_who_the_words_have_on_a_thing_with_wheels_stands_on_it(prompt: str, below: str) -> None:
    things = dict(STREET.objects)
    things["man"] = (*things["man"][:2], "floor")
    stage = Stage("street", things)
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    man = program.scene.object("man")
    assert man is not None
    assert man.support == below
