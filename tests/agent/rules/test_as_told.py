"""Events that end as they are told: at an edge, at the foot of a slope, up it, put down again."""

from __future__ import annotations

import math

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.contract.words import claim
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import (
    ApplyForce,
    Directed,
    FixObject,
    OnContact,
    SetAngularVelocity,
)
from physagent_studio.program.scene.state import Box, Ramp, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage

RAMP = Ramp(toe=(0.3, 2.5, 0.0), yaw=math.pi, run=0.6, rise=0.18, width=0.4)
LEAN = math.atan2(0.18, 0.6)
BESIDE_A_RAMP = Stage(
    "beside_a_ramp",
    {
        "crate": (Box(size=(0.1, 0.1, 0.1)), (0.6, 2.5, 0.05), "floor"),
        "ball": (
            Sphere(radius=0.04),
            (-0.1 + 0.041 * math.sin(LEAN), 2.5, 0.12 + 0.041 * math.cos(LEAN)),
            "ramp",
        ),
    },
    {"ramp": RAMP},
)


def first(stage: Stage, prompt: str) -> PhysicalProgram:
    """The first program of a prompt."""
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def claims(program: PhysicalProgram) -> set[str]:
    """What its contract demands, in words."""
    return {claim(one, program) for one in program.contract.statements}


def untested(program: PhysicalProgram) -> list[str]:
    """What it says that nothing tests."""
    return [clause.text for clause in program.contract.untested]


@pytest.mark.parametrize(
    "prompt",
    [
        "The blue cup slides to the edge of the table and stops just before it falls off.",
        "The blue cup is pushed and almost falls off the table.",
        "The blue cup nearly slides off the edge of the table.",
    ],
)
def test_nearly_off_the_table_is_at_its_edge(prompt: str) -> None:
    program = first(STAGES["desk"], prompt)
    assert {
        "blue_cup moves towards table_edge", "blue_cup rests on table at the end",
        "blue_cup does not fall", "blue_cup stops near table_edge",
    } <= claims(program)  # fmt: skip
    assert untested(program) == []
    checks = measure(program, simulate(program, {}))
    assert all(check.ok for check in checks if check.kind != "view")


def test_a_ball_is_braked_at_the_foot_of_a_slope() -> None:
    program = first(BESIDE_A_RAMP, "The ball rolls down the ramp and stops at the bottom.")
    (brake,) = (a for a in program.event.actions if a.id == "brake_ball")
    assert brake.when == OnContact(a="ball", b="floor")
    rollout = simulate(program, {})
    assert all(c.ok for c in measure(program, rollout) if c.kind != "view")
    assert rollout.positions[-1, rollout.objects.index("ball"), 0] < 0.45


def test_a_crate_that_is_pushed_up_a_slope_stays_there() -> None:
    program = first(BESIDE_A_RAMP, "The crate is pushed up the ramp.")
    assert isinstance(program.event.actions[-1], FixObject)
    rollout = simulate(program, {})
    heights = rollout.positions[:, rollout.objects.index("crate"), 2]
    assert heights[-1] > heights.max() - 0.01 > heights[0] + 0.03
    assert all(c.ok for c in measure(program, rollout) if c.kind != "view")


def test_what_turns_upside_down_is_put_down() -> None:
    program = first(STAGES["desk"], "The blue cup turns upside down.")
    rollout = simulate(program, {})
    heights = rollout.positions[:, rollout.objects.index("blue_cup"), 2]
    assert heights.max() > heights[0] + 0.02
    assert heights[-1] == pytest.approx(heights[0], abs=0.005)


def test_a_spin_dies_away_before_it_stops() -> None:
    program = first(STAGES["desk"], "The blue cup spins and comes to rest.")
    spins = [a for a in program.event.actions if isinstance(a, SetAngularVelocity)]
    rates = [abs(a.angular_velocity[2]) for a in spins if isinstance(a.angular_velocity, tuple)]
    assert rates == sorted(rates, reverse=True)
    assert rates[-1] == 0
    assert all(c.ok for c in measure(program, simulate(program, {})) if c.kind != "view")


def test_what_rolls_down_later_is_held_until_then() -> None:
    program = first(BESIDE_A_RAMP, "After one second the ball rolls down the ramp.")
    rollout = simulate(program, {})
    moved = abs(rollout.positions[:, rollout.objects.index("ball"), 0] + 0.1)
    assert moved[100] < 0.02 < 0.3 < moved.max()


def test_a_ball_that_bounces_off_what_it_rolled_to_stays_on_the_ground() -> None:
    program = first(STAGES["court"], "The basketball rolls to the crate and bounces off.")
    forces = [a.force for a in program.event.actions if isinstance(a, ApplyForce)]
    assert all(isinstance(force, Directed) and not force.elevation for force in forces)
    assert forces
