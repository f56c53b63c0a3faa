"""What is long, round and lies rolls like a ball, and cannot be knocked over."""

from __future__ import annotations

import math

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.scene.steps import steps_below
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene.state import (
    Box,
    Cylinder,
    SceneObject,
    SceneState,
    Slab,
    Sphere,
)
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


STAIRS = Stage(
    "stairs",
    {"ball": (Sphere(radius=0.06), (-0.3, 2.0, 0.51), "upper_step")},
    {
        f"{name}_step": Slab(position=(0.3 * k, 2.0, height / 2), size=(0.3, 0.6, height))
        for k, name, height in ((1, "lower", 0.15), (0, "middle", 0.3), (-1, "upper", 0.45))
    },
)


@pytest.mark.parametrize(
    "prompt", ["The ball rolls down the steps.", "The ball bounces down the stairs."]
)
def test_down_the_steps_is_where_they_go_down(prompt: str) -> None:
    program = RuleGenerator().first(STAIRS.case(prompt), STAIRS.reconstruct)
    assert not program.contract.untested
    rollout = simulate(program, {})
    assert all(check.ok for check in measure(program, rollout) if check.demanded)
    track = rollout.positions[:, rollout.index("ball")]
    assert track[-1, 0] > 0.4
    assert abs(track[:, 1] - 2.0).max() < 0.2
    assert steps_below(Layout(program.scene), "ball") == ("middle_step", "lower_step")


@pytest.mark.parametrize(
    ("shape", "turn", "flat"),
    [
        (Box(size=(0.3, 0.2, 0.04)), None, True),
        (Box(size=(0.3, 0.04, 0.2)), None, False),
        (Box(size=(0.1, 0.1, 0.1)), None, True),
        (Cylinder(radius=0.3, height=0.1), LAID, False),
        (Cylinder(radius=0.03, height=0.2), None, False),
    ],
    ids=["book", "book on its edge", "cube", "wheel on its edge", "bottle"],
)
def test_what_lies_flat_already(shape: Box, turn: tuple[float, ...] | None, flat: bool) -> None:
    item = SceneObject(name="thing", shape=shape, position=(0, 0, 0.3))
    if turn is not None:
        item = item.model_copy(update={"rotation": turn})
    assert Layout(SceneState(objects=(item,))).lies_flat("thing") is flat
