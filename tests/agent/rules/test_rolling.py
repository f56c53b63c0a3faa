"""What is long, round and lies rolls like a ball, and cannot be knocked over."""

from __future__ import annotations

import math

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.layout import Layout
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene import Cylinder, SceneObject, SceneState, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

LAID = about_axis((1.0, 0.0, 0.0), math.pi / 2)
LOGS = Stage(
    "logs",
    {
        "log": (Cylinder(radius=0.05, height=0.4), (0.0, 2.0, 0.05), "floor"),
        "can": (Cylinder(radius=0.03, height=0.12), (0.6, 2.0, 0.06), "floor"),
    },
    turns={"log": LAID},
)


def first(prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(LOGS.case(prompt), LOGS.reconstruct)


@pytest.mark.parametrize(
    ("shape", "turn", "rolls"),
    [
        (Sphere(radius=0.1), None, True),
        (Cylinder(radius=0.03, height=0.12), LAID, True),
        (Cylinder(radius=0.03, height=0.12), None, False),
        (Cylinder(radius=0.3, height=0.1), LAID, False),
    ],
    ids=["ball", "lying can", "standing can", "wheel on its edge"],
)
def test_what_rolls(shape: Cylinder, turn: tuple[float, ...] | None, rolls: bool) -> None:
    item = SceneObject(name="thing", shape=shape, position=(0, 0, 0.3))
    if turn is not None:
        item = item.model_copy(update={"rotation": turn})
    assert Layout(SceneState(objects=(item,))).rolls("thing") is rolls


def test_a_log_rolls_as_far_as_a_picture_shows() -> None:
    program = first("The log rolls to the left.")
    assert any(s.kind == "rotates" and s.subject == "log" for s in program.contract.statements)
    rollout = simulate(program, {})
    assert all(check.ok for check in measure(program, rollout) if check.demanded)
    index = rollout.index("log")
    assert 0.1 < rollout.positions[0, index, 0] - rollout.positions[-1, index, 0] < 3.0


def test_a_can_that_lies_is_not_asked_to_topple() -> None:
    program = first("The log rolls to the right and hits the can.")
    assert all(check.ok for check in measure(program, simulate(program, {})) if check.demanded)
    hit = first("The can falls over and hits the log, which rolls away.")
    told = {s.kind for s in hit.contract.statements if getattr(s, "subject", "") == "log"}
    assert "topples" not in told
    assert "rotates" in told
