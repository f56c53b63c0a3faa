"""Small words that turn a sentence round: left lying, halfway off, where it was, without more."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.contract.words import claim
from physagent_studio.language import hints, inventory, read
from physagent_studio.program import Grounding, PhysicalProgram
from physagent_studio.program.scene.state import Box, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, TABLE, Stage

PILE = Stage(
    "pile",
    {
        "low_book": (Box(size=(0.25, 0.18, 0.04)), (0.0, 2.5, 0.77), "table"),
        "top_book": (Box(size=(0.25, 0.18, 0.04)), (0.0, 2.5, 0.81), "low_book"),
    },
    {"table": TABLE},
)
CUP = Stage(
    "cup",
    {
        "ball": (Sphere(radius=0.05), (-0.3, 2.5, 0.05), "floor"),
        "cup": (Box(size=(0.08, 0.08, 0.1)), (0.2, 2.5, 0.05), "floor"),
    },
)
ALOFT = Stage(
    "aloft",
    {
        "melon": (Sphere(radius=0.1), (0.0, 2.5, 1.0), "air"),
        "stool": (Box(size=(0.3, 0.3, 0.4)), (0.0, 2.5, 0.2), "floor"),
    },
)


def first(prompt: str, stage: Stage) -> PhysicalProgram:
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def demands(prompt: str, stage: Stage) -> set[str]:
    program = first(prompt, stage)
    return {claim(s, program) for s in program.contract.statements}


def way(prompt: str, stage: Stage, name: str) -> np.ndarray:
    """The path (steps, 3) of a thing from where it was, m."""
    run = simulate(first(prompt, stage), {})
    path = run.positions[:, run.objects.index(name)]
    return path - path[0]


@pytest.mark.parametrize(
    "prompt",
    [
        "Slide the red cube to the left and leave it on the table.",
        "The red cube is pushed to the left, leaving it on the table.",
    ],
)
def test_what_is_left_there_stays_there(prompt: str) -> None:
    said = demands(prompt, STAGES["desk"])
    assert "red_cube rests on table at the end" in said
    assert not any("leaves" in one for one in said)


@pytest.mark.parametrize(
    "prompt",
    [
        "The top book slides halfway off the stack and stays there.",
        "The top book slides halfway off the low book.",
    ],
)
def test_halfway_off_juts_out_and_stays_up(prompt: str) -> None:
    program = first(prompt, PILE)
    run = simulate(program, {})
    assert [
        c.text for c in measure(program, run) if c.demanded and not c.always_on and not c.ok
    ] == []
    assert not program.contract.untested
    path = run.positions[:, run.objects.index("top_book")]
    assert 0.05 < np.linalg.norm((path[-1] - path[0])[:2]) < 0.125
    assert path[-1, 2] == pytest.approx(path[0, 2], abs=0.005)


@pytest.mark.parametrize(
    "prompt",
    [
        "The ball is kicked high into the air and lands where it was.",
        "The ball is kicked into the air and comes back down in the same place.",
    ],
)
def test_lands_where_it_was(prompt: str) -> None:
    moved = way(prompt, STAGES["field"], "ball")
    assert moved[:, 2].max() > 0.2
    assert np.abs(moved[:, :2]).max() < 0.05
    (kick, land) = read(prompt, inventory([("ball", Grounding())])).frames
    assert "spot" not in str(land.places)
    assert kick.sense == "kick"


def test_against_it_without_knocking_it_over_may_touch_it() -> None:
    said = demands("The ball rolls until it rests against the cup without knocking it over.", CUP)
    assert "cup does not topple" in said
    assert "ball does not touch cup" not in said
    assert "ball does not touch cup" in demands(
        "The ball rolls past the cup without knocking it over.", CUP
    )


def test_what_lands_on_a_thing_stays_on_it_afterwards() -> None:
    said = demands("The melon lands on the stool and stays on top of it.", ALOFT)
    assert "melon rests on stool at the end" in said
    assert "melon stays in place" not in said


def test_what_hangs_falls_and_does_not_tip_over_before_it_rolls() -> None:
    actions = first("The melon falls, hits the stool and rolls to the right.", ALOFT).event.actions
    assert not any(action.id.startswith("tip_") for action in actions)


def test_away_from_an_edge_is_square_to_it() -> None:
    edge = {"table_edge": ("line", ((0.6, 2.1, 0.75), (0.6, 2.9, 0.75)))}
    cube = {"cube": (Box(size=(0.1, 0.1, 0.1)), (0.5, 2.2, 0.8), "table")}
    moved = way(
        "The cube slides away from the table edge.",
        Stage("t", cube, {"table": TABLE}, edge),
        "cube",
    )
    assert moved[-1, 0] < -0.03
    assert abs(moved[-1, 1]) < 0.01


@pytest.mark.parametrize(
    ("prompt", "lands"),
    [
        ("The pumpkin drops, bounces off the stool and rolls away.", True),
        ("The pumpkin falls onto the stool.", True),
        ("The pumpkin lands on the stool.", True),
        ("The pumpkin falls over.", False),
        ("The pumpkin falls onto its side.", False),
        ("The pumpkin falls on the floor behind the stool.", False),
        ("The pumpkin falls into pieces.", False),
        ("The stool tips over while the pumpkin stays still.", False),
    ],
)
def test_what_drops_or_comes_down_onto_a_thing_is_in_the_air_before(
    prompt: str, lands: bool
) -> None:
    assert ("pumpkin" in hints(prompt, ("pumpkin", "stool")).landing) == lands


def test_further_left_is_to_the_left() -> None:
    (_, down) = read(
        "Somebody lifts the basket and sets it down further left.",
        inventory([("basket", Grounding())]),
    ).frames
    assert down.direction == "left"


def test_by_itself_names_nothing_else() -> None:
    things = inventory([("scooter", Grounding()), ("trash_can", Grounding())])
    frames = read("The scooter tips over onto its side all by itself.", things).frames
    assert [frame.patient for frame in frames] == [("scooter",)]


def test_parts_of_a_thing_that_nobody_marked_leave_its_sentence_readable() -> None:
    tree = Stage("t", {"tree": (Box(size=(0.5, 0.5, 1.5)), (0.0, 3.0, 0.75), "floor")})
    program = first("A light breeze rustles the leaves while the trunk stays still.", tree)
    assert program.contract.untested
