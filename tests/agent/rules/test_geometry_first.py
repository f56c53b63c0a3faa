"""What the first program settles in closed form: free ways, standing room, what is taken away."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.planner.costs import cost_of
from physagent_studio.agent.rules.planner.trials import TRIAL, weakness_of
from physagent_studio.agent.rules.scene.footing import with_hold
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.schedule.paths import arc_length, clearance, free_turn
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.bodies import Granular
from physagent_studio.program.scene.state import Box, Floor, SceneState, Shape, Sphere
from physagent_studio.records import Check
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage


def program_of(stage_name: str, prompt: str) -> PhysicalProgram:
    stage = STAGES[stage_name]
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def failing(program: PhysicalProgram) -> list[str]:
    """What fails of the event itself; how well it is seen is the planner's to mend."""
    checks = measure(program, simulate(program, {}))
    demanded = (check for check in checks if check.demanded and check.kind != "view")
    return [check.text for check in demanded if not check.ok]


def moved(state: SceneState, name: str, spot: tuple[float, float, float]) -> SceneState:
    objects = tuple(
        item.model_copy(update={"position": spot}) if item.name == name else item
        for item in state.objects
    )
    return state.model_copy(update={"objects": objects})


# --- ways along the ground -------------------------------------------------------------------


def test_an_arc_is_as_wide_as_what_stands_in_the_way_needs() -> None:
    state = program_of("lane", "The ball rolls.").scene
    state = moved(state, "middle_pin", (0.2, 3.3, 0.19))
    layout, goal = Layout(state), Layout(state).position("right_pin")
    flat = clearance(layout, "bowling_ball", goal, 24.0, ["middle_pin"])
    turn = free_turn(layout, "bowling_ball", goal, 1.0, ["middle_pin"])
    assert flat < 0.05
    assert turn > 24.0
    assert clearance(layout, "bowling_ball", goal, turn, ["middle_pin"]) > max(flat, 0.03)


def test_a_positive_turn_bends_to_the_left() -> None:
    layout = Layout(program_of("lane", "The ball rolls.").scene)
    goal = layout.position("middle_pin")
    # Bending left it lies to the right of the straight line, nearer to the right pin.
    right = clearance(layout, "bowling_ball", goal, 90.0, ["right_pin"])
    left = clearance(layout, "bowling_ball", goal, -90.0, ["right_pin"])
    assert right < left


@pytest.mark.parametrize(
    ("turn", "length"), [(0.0, 1.0), (180.0, np.pi / 2), (90.0, np.pi / 4 * np.sqrt(2))]
)
def test_the_length_of_an_arc(turn: float, length: float) -> None:
    assert arc_length(1.0, turn) == pytest.approx(length)


@pytest.mark.parametrize(
    ("stage", "prompt"),
    [
        ("ice", "The red stone slides past the yellow stone without touching it."),
        ("slope", "The car is pushed up the ramp."),
        ("air", "The melon misses the stool and hits the ground."),
        ("fruit", "The apples roll off the table one after the other."),
        ("desk", "The cube stops."),
    ],
)
def test_the_first_program_already_makes_the_event(stage: str, prompt: str) -> None:
    assert not failing(program_of(stage, prompt))


# --- standing --------------------------------------------------------------------------------


def test_what_rests_beyond_an_edge_is_moved_just_inside() -> None:
    state = program_of("desk", "The cube stops.").scene
    over = moved(state, "red_cube", (0.61, 2.5, 0.79))
    held = with_hold(over).object("red_cube")
    assert held is not None
    assert held.position == pytest.approx((0.6 - 0.05 * 0.08, 2.5, 0.79))
    assert with_hold(state) is state


def test_what_a_person_placed_stays_there() -> None:
    state = program_of("desk", "The cube stops.").scene
    over = moved(state, "red_cube", (0.61, 2.5, 0.79))
    objects = tuple(item.model_copy(update={"source": "person"}) for item in over.objects)
    given = over.model_copy(update={"objects": objects})
    assert with_hold(given) is given


def test_a_table_that_is_pulled_away_carries_nothing() -> None:
    prompt = "The table is pulled away and the red cube falls to the floor."
    program = program_of("desk", prompt)
    assert program.scene.support("table") is None
    assert any("table" in flag for flag in program.scene.flags)
    assert not program.contract.untested
    assert not failing(program)


def test_the_ground_is_never_taken_away() -> None:
    program = program_of("field", "The grass is pulled away and the ball falls.")
    assert program.scene.support("floor") is not None


# --- budgets and margins ---------------------------------------------------------------------


def test_grains_cost_many_units() -> None:
    program = program_of("field", "The ball rolls.")
    (ball,) = program.scene.objects
    heap = ball.model_copy(update={"body": Granular(grains=120)})
    loose = program.scene.model_copy(update={"objects": (heap,)})
    assert cost_of(program) == 1.0
    assert cost_of(program.model_copy(update={"scene": loose})) > 20


def check(margin: float, *, ok: bool = True) -> Check:
    return Check(
        id="c", text="t", ok=ok, measured=None, threshold=None, unit="", margin=margin, kind="moves"
    )


def test_weakness_is_of_margins_that_are_there_and_small() -> None:
    assert weakness_of([check(1.0), check(TRIAL.sturdy_margin)]) == 0
    assert weakness_of([check(0.0)]) == 0
    assert weakness_of([check(-1.0, ok=False)]) == 0
    assert weakness_of([check(TRIAL.sturdy_margin / 5)]) == pytest.approx(0.8)


@pytest.mark.parametrize("seed", [5, 15, 2, 14])
def test_the_first_of_a_chain_is_fast_enough_for_the_last(seed: int) -> None:
    draw = np.random.default_rng(3).uniform(
        (0.03, 0.03, 0.1, 0.3, 0.15), (0.12, 0.12, 0.4, 0.6, 0.5), (16, 5)
    )
    own, half, height, slim, gap = (float(value) for value in draw[seed])
    struck: Shape = Sphere(radius=half) if seed % 2 else Box(size=(2 * half, 2 * half, 2 * half))
    wide, middle = slim * height, -0.6 + own + gap + half
    last = (middle + half + gap + wide / 2, 3.0, height / 2)
    stage = Stage(
        "chain",
        {
            "white_ball": (Sphere(radius=own), (-0.6, 3.0, own), "floor"),
            "red_thing": (struck, (middle, 3.0, half), "floor"),
            "tall_block": (Box(size=(wide, 1.5 * wide, height)), last, "floor"),
        },
        {"floor": Floor(height=0.0)},
    )
    prompt = "The white ball hits the red thing, and the red thing knocks over the tall block."
    assert not failing(RuleGenerator().first(stage.case(prompt), stage.reconstruct))
