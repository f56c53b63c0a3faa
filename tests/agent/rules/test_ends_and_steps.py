"""Off which end of a slope, down how many steps, away from what: it is demanded, and tried."""

from __future__ import annotations

import math
from typing import Any

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.scene.steps import descents
from physagent_studio.contract import measure
from physagent_studio.contract.words import claim
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Ramp, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import RAMP, STAGES, Stage, _on_ramp
from tests.agent.rules.test_rolling import STAIRS

BALL = Stage("hill", {"ball": (Sphere(radius=0.04), _on_ramp(0.5, 0.0401), "ramp")}, {"ramp": RAMP})
FLIGHT = Stage(
    "flight",
    {"toy": (Box(size=(0.1, 0.1, 0.12)), (-0.75, 2.5, 0.86), "stairs")},
    {"stairs": Ramp(toe=(0.3, 2.5, 0.0), yaw=math.pi, run=0.9, rise=0.8, width=0.8, steps=4)},
)
YARD = Stage(
    "yard",
    {
        "truck": (Box(size=(0.2, 0.1, 0.1)), (-0.5, 2.5, 0.05), "floor"),
        "crate": (Box(size=(0.15, 0.15, 0.15)), (0.2, 2.5, 0.075), "floor"),
    },
)


def first(stage: Stage, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def demands(stage: Stage, prompt: str) -> set[str]:
    program = first(stage, prompt)
    return {claim(s, program) for s in program.contract.statements}


def failed(program: PhysicalProgram) -> list[Any]:
    checks = measure(program, simulate(program, {}))
    return [c.text for c in checks if c.demanded and not c.always_on and not c.ok]


@pytest.mark.parametrize(
    "prompt",
    [
        "The ball rolls backwards off the top of the ramp.",
        "The ball rolls up the ramp and off the top.",
    ],
)
def test_off_the_top_is_over_the_upper_end(prompt: str) -> None:
    program = first(BALL, prompt)
    assert any(s.kind == "passes_over" for s in program.contract.statements)
    assert failed(program) == []
    down = first(BALL, "The ball rolls down the ramp.")
    told = program.model_copy(update={"event": down.event})
    assert any("passes over" in text for text in failed(told))


def test_to_the_top_of_a_ramp_is_up_it() -> None:
    for prompt in ("The ball rolls to the top of the ramp.", "The ball rolls up the ramp."):
        path = simulate(first(BALL, prompt), {}).positions[:, 0, 2]
        assert path.max() > path[0] + 0.02


def test_a_car_may_face_down_as_it_goes_off_the_top() -> None:
    assert "toy_car passes over ramp_upper_end" in demands(
        STAGES["slope"], "The toy car rolls backwards off the top of the ramp."
    )
    assert "toy_car passes over ramp_lower_end" in demands(
        STAGES["slope"], "The toy car rolls off the lower end of the ramp."
    )


@pytest.mark.parametrize(
    ("stage", "prompt"),
    [
        (STAIRS, "The ball hops down one step."),
        (FLIGHT, "The toy hops down one step."),
        (FLIGHT, "The toy jumps down to the next step."),
        (FLIGHT, "The toy jumps down."),
    ],
)
def test_a_hop_down_ends_lower(stage: Stage, prompt: str) -> None:
    program = first(stage, prompt)
    name = program.event.actions[0].name
    depth = descents(Layout(program.scene), name)[0]
    rollout = simulate(program, {})
    height = rollout.positions[:, rollout.index(name), 2]
    assert height[0] - height.min() > 0.7 * depth
    lower = [s for s in program.contract.statements if s.kind == "moves" and s.direction == "down"]
    assert {s.negated for s in lower} >= {False}
    still = program.model_copy(update={"event": program.event.model_copy(update={"actions": ()})})
    assert any("moves down" in text for text in failed(still))


def test_two_steps_are_no_more_and_no_fewer() -> None:
    program = first(FLIGHT, "The toy hops down two steps and stays there.")
    down = {
        s.negated: s.distance
        for s in program.contract.statements
        if s.kind == "moves" and s.direction == "down"
    }
    assert down == {False: pytest.approx(0.32), True: pytest.approx(0.5)}
    assert "toy stops" in {claim(s, program) for s in program.contract.statements}
    assert descents(Layout(program.scene), "toy") == pytest.approx((0.2, 0.4, 0.6, 0.8))


def test_what_it_never_touched_is_left_by_going_away() -> None:
    told = demands(YARD, "The truck backs away from the crate and stops.")
    assert told == {
        "truck moves to the left", "truck does not move towards crate", "truck stops",
    }  # fmt: skip
    assert "truck moves to the left" in demands(YARD, "The truck moves away from the crate.")


def test_to_the_left_thing_is_no_way() -> None:
    told = demands(STAGES["lane"], "The bowling ball rolls to the left pin and stays there.")
    assert {"bowling_ball moves towards left_pin", "bowling_ball stops"} <= told


def test_what_is_pushed_but_stays_put_does_not_move() -> None:
    told = demands(YARD, "The truck hits the crate but the crate stays in place.")
    assert "crate stays in place" in told


def test_what_goes_there_and_comes_back_keeps_to_its_way() -> None:
    program = first(YARD, "The truck drives halfway to the crate, stops, and then reverses.")
    rollout = simulate(program, {})
    path = rollout.positions[:, rollout.objects.index("truck"), :2] - (-0.5, 2.5)
    assert failed(program) == []
    assert 0.25 < path[:, 0].max() < 0.5
    assert abs(path[:, 1]).max() < 0.02
    assert path[-1, 0] < 0.1


def test_to_turn_back_is_to_come_back_a_way_that_is_seen() -> None:
    program = first(YARD, "The truck drives halfway to the crate, stops, and then reverses.")
    back = next(a for a in program.event.actions if a.id.startswith("back"))
    weak = back.force.model_copy(update={"magnitude": 0.02})  # type: ignore[union-attr]
    actions = tuple(
        a.model_copy(update={"force": weak}) if a is back else a for a in program.event.actions
    )
    event = program.event.model_copy(update={"actions": actions})
    less = program.model_copy(update={"event": event})
    assert any("turns back" in text for text in failed(less))
