"""Who hits a stack or a row hits one of it, unless each of them is said."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.words import claim
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Slab, Sphere
from tests.agent.rules.everyday_scenes import EVERYDAY
from tests.agent.rules.scenes import Stage
from tests.agent.rules.varied_scenes import VARIED

FLAT = Box(size=(0.1, 0.1, 0.06))
TOWER = Stage(
    "tower",
    {
        "ball": (Sphere(radius=0.06), (-0.6, 2.5, 0.06), "floor"),
        "red_block": (FLAT, (0.2, 2.5, 0.09), "wooden_block"),
        "wooden_block": (FLAT, (0.2, 2.5, 0.03), "floor"),
    },
)
EITHER = {"ball touches red_block or wooden_block", "ball touches wooden_block or red_block"}


def demanded(stage: Stage, prompt: str) -> tuple[set[str], PhysicalProgram]:
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    contract = program.contract
    told = (s for s in contract.statements if s.id not in contract.serving)
    return {claim(s, program) for s in told}, program


@pytest.mark.parametrize(
    "prompt",
    [
        "The ball touches the blocks.",
        "The ball hits the stack.",
        "The ball bumps into the stack of blocks.",
        "The ball rolls into the tower.",
        "The ball rolls into the tower, which collapses.",
        "The blocks are hit by the ball.",
    ],
)
def test_one_of_a_stack_is_enough(prompt: str) -> None:
    told, program = demanded(TOWER, prompt)
    assert told & EITHER, told
    assert not any(claim.startswith("ball touches") for claim in told - EITHER)
    assert not program.contract.untested


@pytest.mark.parametrize(
    "said", ["each of the blocks", "every block", "all the blocks", "both blocks", "the two blocks"]
)
def test_each_of_them_is_each_of_them(said: str) -> None:
    told, _ = demanded(TOWER, f"The ball touches {said}.")
    assert told == {"ball touches red_block", "ball touches wooden_block"}


def test_a_row_is_hit_where_its_first_one_is() -> None:
    row = "marble touches " + " or ".join(f"domino_{k}" for k in range(1, 6))
    for said in ("bumps into the row of dominoes", "hits the dominoes"):
        told, program = demanded(EVERYDAY["dominoes"], f"The marble {said}.")
        assert told == {row}
        assert not program.contract.untested
    told, _ = demanded(VARIED["cups"], "The ping pong ball hits the left and the right cup.")
    assert told == {"ping_pong_ball touches left_cup", "ping_pong_ball touches right_cup"}


def test_what_is_thrown_at_a_stack_goes_there() -> None:
    told, _ = demanded(TOWER, "The ball is thrown at the tower.")
    assert any(text.startswith("ball moves towards") for text in told)


@pytest.mark.parametrize(
    "prompt",
    [
        "The ball rolls into the blocks and the stack tumbles down.",
        "The ball rolls towards the tower and the tower falls down.",
        "The ball crashes into the tower of blocks and the red block falls down.",
    ],
)
def test_the_blow_that_brings_it_down_is_demanded_where_it_is_left_unsaid(prompt: str) -> None:
    told, program = demanded(TOWER, prompt)
    assert told & EITHER, told
    # It comes before the fall, nothing else makes them fall, and the lowest one may stay.
    assert any("before red_block falls" in claim for claim in told), told
    assert {action.name for action in program.event.actions} == {"ball"}
    assert not any("wooden_block tilts" in claim for claim in told)


@pytest.mark.parametrize("which", ["left", "right"])
def test_what_goes_towards_some_hits_those_that_fall_over(which: str) -> None:
    told, program = demanded(
        VARIED["cups"], f"The ball rolls towards the cups and only the {which} one falls over."
    )
    assert f"ping_pong_ball touches {which}_cup" in told
    assert {action.name for action in program.event.actions} == {"ping_pong_ball"}
    # Towards one of them, and another one falls: that is no blow.
    told, _ = demanded(
        VARIED["cups"], "The ball rolls towards the left cup and the right cup falls over."
    )
    assert not any("touches" in claim for claim in told)


def test_all_of_a_kind_are_meant_where_one_bears_its_name_alone() -> None:
    things = {"ball": TOWER.objects["ball"], "pin": (FLAT, (0.2, 2.5, 0.03), "floor"),
              "right_pin": (FLAT, (0.6, 2.5, 0.03), "floor")}  # fmt: skip
    stage = Stage("pins", things)
    told, program = demanded(stage, "The ball rolls towards the pins and the right pin falls over.")
    assert "ball touches right_pin" in told
    assert {action.name for action in program.event.actions} == {"ball"}
    told, _ = demanded(stage, "The pins fall over.")
    assert {"pin topples", "right_pin topples"} <= told
    told, _ = demanded(stage, "The pin falls over.")
    assert not any("right_pin topples" in claim for claim in told)


ON_A_TABLE = Stage(
    "on_a_table",
    {
        "blue_crate": (Box(size=(0.2, 0.2, 0.1)), (0.0, 2.5, 0.81), "table"),
        "red_crate": (Box(size=(0.16, 0.16, 0.1)), (0.0, 2.5, 0.91), "blue_crate"),
        "green_crate": (Box(size=(0.12, 0.12, 0.1)), (0.0, 2.5, 1.01), "red_crate"),
    },
    {"table": Slab(position=(0.0, 2.5, 0.38), size=(1.6, 0.9, 0.76))},
)


@pytest.mark.parametrize(
    "prompt",
    [
        "The stack of crates collapses.",
        "The tower tumbles down.",
        "The crates come crashing down.",
        "The pile of crates falls apart.",
        "The crates collapse.",
        "The tower of crates is knocked over.",
    ],
)
def test_what_a_stack_on_a_table_stands_on_need_not_fall(prompt: str) -> None:
    program = RuleGenerator().first(ON_A_TABLE.case(prompt), ON_A_TABLE.reconstruct)
    falling = {s.subject for s in program.contract.statements if s.kind == "falls"}
    assert falling == {"red_crate", "green_crate"}
    assert not program.contract.untested
