"""What gives way, goes on or spins when it is struck: demands, bodies and how it is set going."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import ApplyForce, Directed
from physagent_studio.program.scene.bodies import Soft
from physagent_studio.program.scene.state import Box, Cylinder, Frustum, Slab, Sphere
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


def test_what_slides_on_and_stops_is_sent_by_the_blow_alone() -> None:
    struck = "hits the yellow stone, and the yellow stone slides on and stops."
    program = program_of(STAGES["ice"], f"The red stone slides to the left, {struck}")
    pushed = [action.name for action in program.event.actions]
    assert pushed
    assert set(pushed) == {"red_stone"}


FRUIT = Stage(
    "fruit",
    {
        "left_melon": (Sphere(radius=0.08), (-0.5, 2.5, 0.1), "board"),
        "right_melon": (Sphere(radius=0.08), (0.3, 2.75, 0.08), "floor"),
    },
    {"board": Slab(position=(-0.5, 2.5, 0.01), size=(0.3, 0.3, 0.02))},
)
PILE = Stage(
    "pile",
    {
        "top_box": (Box(size=(0.1, 0.1, 0.1)), (0.0, 2.5, 0.25), "middle_box"),
        "middle_box": (Box(size=(0.1, 0.1, 0.1)), (0.0, 2.5, 0.15), "bottom_box"),
        "bottom_box": (Box(size=(0.1, 0.1, 0.1)), (0.0, 2.5, 0.05), "floor"),
    },
)


@pytest.mark.parametrize(
    ("prompt", "met"),
    [
        ("The left melon rolls to the right off the board and bumps into the right melon.", True),
        ("The left melon rolls to the right off the board.", False),
    ],
)
def test_off_an_edge_it_is_aimed_at_what_it_shall_meet(prompt: str, met: bool) -> None:
    push = program_of(FRUIT, prompt).event.actions[0]
    assert isinstance(push, ApplyForce)
    assert isinstance(push.force, Directed)
    assert push.force.toward == ("right_melon" if met else None)


def test_a_ball_that_is_hit_is_seen_to_roll_on() -> None:
    prompt = "The left melon rolls to the right and hits the right melon."
    on_floor = {
        "left_melon": (Sphere(radius=0.08), (-0.5, 2.5, 0.08), "floor"),
        "right_melon": (Sphere(radius=0.08), (0.3, 2.5, 0.08), "floor"),
    }
    rollout = simulate(program_of(Stage("melons", on_floor), prompt), {})
    path = rollout.positions[:, rollout.objects.index("right_melon"), 0]
    assert path[-1] - path[0] > 0.16


def test_to_land_next_to_a_thing_is_to_end_near_it() -> None:
    said = "The left melon jumps to the right and lands next to the right melon."
    statements = program_of(FRUIT, said).contract.statements
    near = [s.near for s in statements if s.kind == "stops" and s.subject == "left_melon"]
    assert near == ["right_melon"]


def test_a_stack_comes_down_to_one_side() -> None:
    program = program_of(PILE, "The top box and the middle box are pushed off the stack.")
    ways = {
        (a.force.direction, a.force.toward)
        for a in program.event.actions
        if isinstance(a, ApplyForce) and isinstance(a.force, Directed)
    }
    assert ways == {("right", None)}


def test_falling_over_is_no_spinning() -> None:
    turns = [
        s for s in program_of(TOP, "The spinning top spins.").contract.statements
        if s.kind == "rotates"
    ]  # fmt: skip
    assert [s.axis for s in turns] == [(0.0, 0.0, 1.0)]


def test_what_spins_and_then_falls_over_does_the_one_after_the_other() -> None:
    program = program_of(TOP, "The spinning top spins, then it falls over.")
    spin, tip = program.event.actions
    assert spin.operator == "SetAngularVelocity"
    assert tip.start_step >= spin.start_step + spin.duration
    only = program_of(TOP, "The spinning top falls over.").event.actions
    assert [one.operator for one in only] == [tip.operator]


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
