"""What goes back to a side that is said, and on from there."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.contract.words import claim
from physagent_studio.language import inventory, read
from physagent_studio.program import Grounding, PhysicalProgram
from physagent_studio.program.scene.state import Box
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

STREET = Stage(
    "street",
    {
        "car": (Box(size=(4.2, 1.7, 1.4)), (0.5, 12.0, 0.7), "floor"),
        "trolley": (Box(size=(0.9, 0.5, 1.0)), (1.9, 7.0, 0.5), "floor"),
    },
)
THINGS = ("car", "trolley", "bus", "ball", "dog", "cone")


def first(prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(STREET.case(prompt), STREET.reconstruct)


def claims(program: PhysicalProgram) -> list[str]:
    contract = program.contract
    return [claim(s, program) for s in contract.statements if s.id not in contract.serving]


@pytest.mark.parametrize(
    ("prompt", "sense", "direction", "back_first"),
    [
        ("The car rolls back a little to the right.", "move", "right", True),
        ("The trolley goes back to the left.", "move", "left", True),
        ("The bus drives back a bit to the right and stops.", "move", "right", True),
        ("The ball rolls back to the right.", "move", "right", False),
        ("The dog walks back to the left.", "move", "left", False),
        ("The ball hits the cone and rolls back to the right.", "reverse", "backward", False),
        ("The car drives to the left and drives back to the right.", "reverse", "backward", False),
        ("The bus rolls left, halts, and rolls back to the left.", "move", "left", True),
    ],
)
def test_back_to_a_side_is_that_side(
    prompt: str, sense: str, direction: str, back_first: bool
) -> None:
    things = inventory([(name, Grounding()) for name in THINGS], [("road", Grounding())])
    frame = [f for f in read(prompt, things).frames if f.sense != "stop"][-1]
    assert (frame.sense, frame.direction) == (sense, direction)
    assert ("backwards" in frame.manner) == back_first
    assert "back" not in frame.manner


@pytest.mark.parametrize(
    ("prompt", "there", "on"),
    [
        ("The car rolls back a little to the right, stops, and then drives forward.", 0, 1),
        ("The trolley rolls back to the left, halts and then rolls to the right.", 1, 0),
        ("The trolley backs up to the left, stops and drives on to the right.", 1, 0),
    ],
)
def test_what_backs_to_a_side_stops_and_drives_on(prompt: str, there: int, on: int) -> None:
    program = first(prompt)
    name, sides = prompt.split()[1], ("right", "left")
    told = [f"{name} moves to the {sides[there]}", f"{name} turns back"]
    assert claims(program) == [*told, f"{name} moves to the {sides[on]}"]
    assert not program.contract.untested
    checks = measure(program, simulate(program))
    assert all(check.ok for check in checks if check.clause is not None)


def test_a_stop_on_one_way_is_said_to_be_untested() -> None:
    program = first("The car drives to the right, stops, and then drives on.")
    assert [clause.text for clause in program.contract.untested] == ["stops"]
