"""Bounds that a prompt sets beside what happens: how far, how slowly, on what, on the spot."""

from __future__ import annotations

from typing import Any

import pytest

from physagent_studio.agent.rules import RuleGenerator
from tests.agent.rules.scenes import STAGES


def demands(stage: str, prompt: str) -> list[dict[str, Any]]:
    program = RuleGenerator().first(STAGES[stage].case(prompt), STAGES[stage].reconstruct)
    return [s.model_dump(exclude_unset=True) for s in program.contract.statements]


@pytest.mark.parametrize("rest", ["", " without tipping over", ", and does not fall off the table"])
def test_so_far_is_no_farther_whatever_else_is_denied(rest: str) -> None:
    found = demands("desk", f"The cup slides 10 cm to the left{rest}.")
    level = [s for s in found if s["kind"] == "moves" and s.get("direction") != "up"]
    moves = [(s["distance"], s.get("negated", False)) for s in level]
    assert moves == [(0.08, False), (0.15, True)]


def test_what_slowly_comes_to_an_edge_may_fall_as_it_does() -> None:
    off = demands("desk", "The cube slowly slides off the right edge of the table.")
    on = demands("desk", "The cube slowly slides to the left.")
    speeds = [[s.get("level", False) for s in found if s["kind"] == "speed_between"]
              for found in (off, on)]  # fmt: skip
    assert speeds == [[True], [False]]


def test_what_stays_on_a_thing_that_moves_moves_with_it() -> None:
    moved = demands("stack", "The middle box slides to the right while the top box stays on it.")
    still = demands("stack", "The top box stays on the middle box.")
    top = [[s["kind"] for s in found if s.get("subject") == "top_box"] for found in (moved, still)]
    assert top == [["rests_on"], ["stays", "rests_on"]]


def test_on_the_spot_is_not_aside() -> None:
    found = demands("desk", "The cube spins on the spot.")
    assert [(s["kind"], s.get("negated", False)) for s in found] == [
        ("rotates", False),
        ("moves", True),
    ]


def test_onto_a_thing_is_on_top_of_it() -> None:
    found = demands("desk", "The cup slides onto the cube.")
    assert [(s["kind"], s["other"]) for s in found if "other" in s] == [("reaches", "red_cube")]
    beside = demands("desk", "The cup slides into the cube.")
    assert [(s["kind"], s["other"]) for s in beside if "other" in s] == [("contacts", "red_cube")]


def test_straight_down_from_a_table_is_not_over_its_edge() -> None:
    for stage, name, longest in (("air", "melon", 16), ("desk", "cube", 60)):
        found = demands(stage, f"The {name} falls straight down onto the floor.")
        assert {s["to_step"] for s in found if s["kind"] == "moves"} == {longest}
