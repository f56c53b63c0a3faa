"""Hops that get somewhere, blows after which a thing stops, gentle bounces, who follows whom."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.arrays import FloatArray
from physagent_studio.contract.measure import measure
from physagent_studio.language import EventFrame, inventory, read
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Cylinder, Grounding, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

ROOM = Stage(
    "room",
    {
        "monkey": (Box(size=(0.1, 0.1, 0.12)), (-0.5, 3.0, 0.06), "floor"),
        "cardboard_box": (Box(size=(0.2, 0.2, 0.2)), (0.45, 3.0, 0.1), "floor"),
        "apple": (Sphere(radius=0.04), (-0.2, 3.4, 0.04), "floor"),
        "mug": (Cylinder(radius=0.05, height=0.1), (0.2, 3.4, 0.05), "floor"),
        "truck": (Box(size=(0.3, 0.12, 0.12)), (-0.6, 2.5, 0.06), "floor"),
        "ball": (Sphere(radius=0.1), (0.3, 2.5, 0.1), "floor"),
    },
)


def _run(prompt: str, name: str) -> tuple[PhysicalProgram, FloatArray]:
    """The first program, whose demands hold and leave nothing untested, and the way of a thing."""
    program = RuleGenerator().first(ROOM.case(prompt), ROOM.reconstruct)
    assert not program.contract.untested
    assert not program.contract.not_understood
    rollout = simulate(program, {})
    missed = [c for c in measure(program, rollout) if c.demanded and c.kind != "view" and not c.ok]
    assert not missed, [check.text for check in missed]
    return program, np.asarray(rollout.positions[:, rollout.index(name)])


def _frames(prompt: str, names: str) -> tuple[EventFrame, ...]:
    reading = read(prompt, inventory([(n, Grounding()) for n in names.split()]))
    assert not reading.not_understood
    return reading.frames


@pytest.mark.parametrize(
    ("prompt", "leaps"),
    [
        ("The monkey hops over to the cardboard box.", 5),
        ("The monkey leaps to the box.", 5),
        ("The monkey hops three times towards the box.", 3),
    ],
)
def test_it_hops_to_a_thing_and_ends_before_it(prompt: str, leaps: int) -> None:
    program = RuleGenerator().first(ROOM.case(prompt), ROOM.reconstruct)
    path = np.asarray(simulate(program, {}).positions[:, 0])
    assert 0.1 < path[-1, 0] < 0.3
    assert abs(path[-1, 2] - 0.06) < 0.005
    hops = [action for action in program.event.actions if action.id.startswith("hop_")]
    assert len(hops) >= leaps


@pytest.mark.parametrize(
    ("prompt", "name", "least", "most"),
    [
        ("The monkey hops over to the cardboard box.", "monkey", 0.02, 0.15),
        ("The monkey jumps up twice.", "monkey", 0.02, 0.15),
        ("The monkey jumps up three times while the mug stays put.", "monkey", 0.02, 0.15),
        ("The monkey hops once.", "monkey", 0.02, 0.3),
        ("The apple bounces gently twice on the spot and comes to rest.", "apple", 0.03, 0.13),
        ("The ball softly bounces three times.", "ball", 0.05, 0.3),
    ],
)
def test_how_often_and_how_high_is_as_told(
    prompt: str, name: str, least: float, most: float
) -> None:
    _, path = _run(prompt, name)
    assert least < path[:, 2].max() - path[0, 2] < most


@pytest.mark.parametrize(
    ("prompt", "name", "end"),
    [
        ("The red apple rolls to the right, hits the mug and stops there.", "apple", 0.11),
        ("The apple rolls against the mug and comes to rest right there.", "apple", 0.11),
        ("The apple bumps into the mug and stays there.", "apple", 0.11),
    ],
)
def test_it_stops_at_what_it_hit(prompt: str, name: str, end: float) -> None:
    program, path = _run(prompt, name)
    assert abs(path[-1, 0] - end) < 0.06
    near = [s for s in program.contract.statements if getattr(s, "near", None) == "mug"]
    assert near


@pytest.mark.parametrize(
    ("prompt", "way", "aim"),
    [
        ("The truck drives off to the left, then the ball rolls slowly after it.", "left", ""),
        ("The truck rolls to the right and the ball follows it slowly.", "right", ""),
        ("The truck backs out of the picture to the left, the ball chases it slowly.", "left", ""),
        ("The ball slowly rolls after the truck.", None, "truck"),
    ],
)
def test_what_follows_goes_the_same_way_and_later(prompt: str, way: str | None, aim: str) -> None:
    *_, ball = _frames(prompt, "truck ball")
    assert (ball.patient, ball.direction) == (("ball",), way)
    assert "slow" in ball.manner
    assert [place.name for _, place in ball.places] == ([aim] if aim else [])


@pytest.mark.parametrize(
    "prompt",
    [
        "The brick falls to the ground first, and the board falls after it.",
        "The brick falls down, then the board drops after the brick.",
        "The brick tips over, and the board topples after it.",
    ],
)
def test_what_happens_after_a_thing_happens_later(prompt: str) -> None:
    *_, board = _frames(prompt, "brick board")
    assert board.patient == ("board",)
    assert board.sequel
    assert not board.places


def test_the_order_and_the_slowness_are_demanded() -> None:
    told = "The truck drives to the left, then the ball rolls slowly after it."
    program, path = _run(told, "ball")
    kinds = {statement.kind for statement in program.contract.statements}
    assert {"before", "speed_between"} <= kinds
    assert path[-1, 0] < path[0, 0] - 0.1


@pytest.mark.parametrize(
    ("prompt", "kept"),
    [
        ("The vase tips over and breaks while both glasses stay standing.", ()),
        ("The vase tips over while the three books keep standing.", ()),
        ("The vase falls over, but the two cups beside it keep standing.", ()),
    ],
)
def test_of_what_nobody_marked_nothing_is_said_of_another(
    prompt: str, kept: tuple[str, ...]
) -> None:
    reading = read(prompt, inventory([("vase", Grounding())]))
    assert [f.patient for f in reading.frames if f.sense == "stay"] == list(kept)
    assert len(reading.not_understood) == 1


def test_a_plural_is_all_whose_name_ends_in_its_singular() -> None:
    told = "The vase tips over while both glasses stay standing."
    *_, stay = _frames(told, "vase front_glass wine_glass")
    assert stay.patient == ("front_glass", "wine_glass")


def test_what_is_not_understood_is_shown_in_the_words_of_the_person() -> None:
    reading = read("The cup falls thrice and ends up down.", inventory([("cup", Grounding())]))
    assert all("_" not in word for word in reading.not_understood)
    assert (
        "1 times"
        not in read("The cup falls once.", inventory([("cup", Grounding())])).not_understood
    )
