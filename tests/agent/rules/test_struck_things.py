"""What gives way, goes on or spins when it is struck: demands, bodies and how it is set going."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.bodies import Soft
from physagent_studio.program.scene.state import Cylinder, Frustum, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage

PUDDING = Frustum(bottom_radius=0.08, top_radius=0.06, height=0.12)
DESSERT = Stage(
    "dessert",
    {
        "jelly": (PUDDING, (0.0, 2.5, 0.06), "floor"),
        "cherry": (Sphere(radius=0.03), (0.0, 2.5, 0.4), "air"),
    },
)
TOP = Stage("top", {"spinning_top": (Cylinder(radius=0.05, height=0.04), (0, 2.5, 0.02), "floor")})


def program_of(stage: Stage, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


@pytest.mark.parametrize(
    "prompt",
    [
        "The cherry falls on the jelly, and the jelly wobbles.",
        "The jelly is pushed to the right and wobbles.",
    ],
)
def test_a_jelly_that_wobbles_is_soft_and_no_wind_moves_it(prompt: str) -> None:
    program = program_of(DESSERT, prompt)
    jelly = program.scene.object("jelly")
    assert jelly is not None
    assert isinstance(jelly.body, Soft)
    assert jelly.body.young < 1e5
    assert all(action.operator != "ApplyDisturbance" for action in program.event.actions)


def test_what_hangs_falls_before_it_is_pushed_off_what_it_fell_on() -> None:
    program = program_of(DESSERT, "The cherry falls on the jelly, then it rolls away to the left.")
    rollout = simulate(program, {})
    path = rollout.positions[:, rollout.objects.index("cherry")]
    assert path[-1, 2] < 0.1
    assert path[-1, 0] < -0.1


def test_what_slides_on_goes_the_way_of_what_struck_it() -> None:
    said = "The red stone slides to the left and hits the yellow stone, which slides on."
    statements = program_of(STAGES["ice"], said).contract.statements
    ways = [s.direction for s in statements if s.kind == "moves" and s.subject == "yellow_stone"]
    assert "left" in ways


def test_falling_over_is_no_spinning() -> None:
    turns = [
        s for s in program_of(TOP, "The spinning top spins.").contract.statements
        if s.kind == "rotates"
    ]  # fmt: skip
    assert [s.axis for s in turns] == [(0.0, 0.0, 1.0)]


@pytest.mark.parametrize(
    ("prompt", "bends"),
    [
        ("The ball flies in a high arc into the goal.", False),
        ("The ball rolls in an arc to the left.", True),
    ],
)
def test_weight_alone_bends_a_flight(prompt: str, bends: bool) -> None:
    statements = program_of(STAGES["field"], prompt).contract.statements
    assert any(s.kind == "path_bends" for s in statements) is bends


def test_to_land_after_a_hop_is_to_be_down_again() -> None:
    statements = program_of(STAGES["field"], "The ball hops up and lands.").contract.statements
    assert any(s.kind == "reaches" and s.other == "floor" for s in statements)
