"""Leaps onto what is higher, wobbles before what follows, and ways one after the other."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Cylinder, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import TABLE, Stage

KITCHEN = Stage(
    "kitchen",
    {
        "jug": (Cylinder(radius=0.06, height=0.22), (0.2, 2.4, 0.86), "table"),
        "orange": (Sphere(radius=0.04), (-0.1, 2.35, 0.79), "table"),
        "tin": (Cylinder(radius=0.05, height=0.12), (-0.4, 2.3, 0.81), "table"),
        "cat": (Box(size=(0.45, 0.15, 0.3)), (1.0, 2.2, 0.15), "floor"),
    },
    {"table": TABLE},
)


def _first(prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(KITCHEN.case(prompt), KITCHEN.reconstruct)


@pytest.mark.parametrize(
    ("prompt", "name", "height"),
    [
        ("The cat leaps up onto the table.", "cat", 0.9),
        ("The orange hops onto the tin.", "orange", 0.91),
    ],
)
def test_what_leaps_onto_a_thing_is_on_top_of_it_in_the_end(
    prompt: str, name: str, height: float
) -> None:
    rollout = simulate(_first(prompt), {})
    end = rollout.positions[-1, rollout.objects.index(name)]
    assert end[2] == pytest.approx(height, abs=0.03)


def test_it_comes_down_where_nothing_stands() -> None:
    program = _first("The cat leaps up onto the table.")
    rollout = simulate(program, {})
    still = [rollout.objects.index(name) for name in ("jug", "orange", "tin")]
    moved = np.abs(rollout.positions[-1, still] - rollout.positions[0, still])
    assert moved.max() < 0.02


def test_what_wobbles_and_then_rolls_off_wobbles_first() -> None:
    program = _first("The jug wobbles, then rolls off the table.")
    ids = [action.id for action in program.event.actions]
    assert ids[0] == "rock_jug"
    assert ids[-2:] == ["tip_jug", "roll_jug"]


def test_left_then_right_are_two_legs() -> None:
    program = _first("The tin slides to the left, then to the right.")
    assert not program.contract.not_understood
    pushed = [action.id for action in program.event.actions if "push" in action.id]
    assert pushed == ["leg_1_push_tin", "leg_2_push_tin"]
    checks = measure(program, simulate(program, {}))
    ways = [check for check in checks if check.text.startswith("tin moves to the")]
    assert len(ways) == 2
    assert all(check.ok for check in ways)


def test_what_stops_at_the_edge_is_still_on_the_table() -> None:
    program = _first("The jug slides to the edge of the table and stops there.")
    told = [c for c in program.contract.statements if c.kind == "rests_on"]
    assert [(c.subject, c.other) for c in told] == [("jug", "table")]
