"""Who does it and to what: the one that falls, what is pushed, what is too high to get over."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RulePlanner
from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene.state import Box, Cylinder, Sphere
from tests.agent.rules.planner.test_planner import situation_of
from tests.agent.rules.scenes import STAGES, Stage
from tests.agent.rules.test_as_told import claims, first, untested

BLOCKS = Stage(
    "blocks",
    {
        "ball": (Sphere(radius=0.06), (-0.6, 2.5, 0.06), "floor"),
        "lower_block": (Box(size=(0.15, 0.15, 0.12)), (0.0, 2.5, 0.06), "floor"),
        "upper_block": (Box(size=(0.14, 0.14, 0.12)), (0.0, 2.5, 0.18), "lower_block"),
        "bucket": (Cylinder(radius=0.12, height=0.25), (0.7, 2.5, 0.125), "floor"),
    },
    turns={"lower_block": about_up(0.05)},
)


def test_which_goes_first_is_no_thing_that_is_struck() -> None:
    program = first(STAGES["fruit"], "Both apples roll to the knife, the left one first.")
    assert not any("touches" in one for one in claims(program))
    assert untested(program) == ["the left one first"]


def test_what_tips_back_and_forth_rocks() -> None:
    program = first(STAGES["yard"], "The trash can tips back and forth and stays standing.")
    assert {"trash_can sways", "trash_can does not topple"} <= claims(program)


def test_a_swing_that_is_counted_is_a_noun() -> None:
    program = first(BLOCKS, "On the second swing the ball hits the bucket.")
    assert claims(program) == {"ball touches bucket"}
    assert program.contract.not_understood == ("swing",)


def test_springing_onto_a_thing_is_a_leap() -> None:
    program = first(STAGES["yard"], "The trash can springs onto the scooter.")
    assert "trash_can rests on scooter at the end" in claims(program)


def test_what_falls_takes_others_down() -> None:
    program = first(STAGES["yard"], "The scooter falls over and takes the trash can with it.")
    assert "trash_can topples" in claims(program)


def test_the_one_that_falls_is_the_one_that_is_hit() -> None:
    prompt = "The ball hits the two blocks, and only the upper block falls down."
    demanded = claims(first(BLOCKS, prompt))
    assert "ball touches upper_block" in demanded
    assert "ball does not fall" not in demanded


def test_what_is_pushed_until_it_lies_there() -> None:
    prompt = "The ball pushes the lower block until it lies next to the bucket."
    assert "lower_block stops near bucket" in claims(first(BLOCKS, prompt))


def test_what_is_too_high_is_said_and_not_demanded() -> None:
    program = first(STAGES["court"], "The basketball rolls over the crate.")
    assert not any("crate" in one for one in claims(program))
    (said,) = untested(program)
    assert said.startswith("the basketball cannot get over the crate")


def test_nothing_is_searched_for_where_nothing_is_told() -> None:
    proposal = RulePlanner().propose(situation_of("desk", "The red cube stands up."))
    assert not proposal.hunks
    assert proposal.simulations == 0


def test_falling_first_is_told_apart_from_what_follows() -> None:
    prompt = "The scooter falls over first and then the trash can falls over."
    program = first(STAGES["yard"], prompt)
    assert program.contract.not_understood == ()
    assert "scooter topples, before trash_can topples" in claims(program)


@pytest.mark.parametrize(
    ("stage", "prompt", "demanded"),
    [
        (STAGES["court"], "The basketball rolls right and is stopped by the crate.",
         "basketball stops near crate"),
        (STAGES["court"], "The basketball rolls to the crate and bounces off.",
         "basketball touches crate"),
        (BLOCKS, "The bucket falls on the ball.", "bucket falls"),
        (STAGES["desk"], "The blue cup spins and slows down until it stands still.",
         "blue_cup rests on table at the end"),
    ],
)  # fmt: skip
def test_what_one_clause_says_of_the_other(stage: Stage, prompt: str, demanded: str) -> None:
    assert demanded in claims(first(stage, prompt))


def test_what_does_not_move_at_first_may_move_then() -> None:
    program = first(STAGES["desk"], "The red cube does not move at first, then it slides left.")
    (still,) = (s for s in program.contract.statements if s.kind == "stays")
    assert still.to_step is not None
