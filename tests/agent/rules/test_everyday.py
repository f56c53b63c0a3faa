"""Sentences about everyday places, as different people type them, and what each demands.

Nothing is simulated here. What nothing can test is `untold`: shown as such, never dropped.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.words import claim, describe
from physagent_studio.program import PhysicalProgram
from tests.agent.rules.everyday_scenes import EVERYDAY

ROWS = yaml.safe_load((Path(__file__).parent / "everyday.yaml").read_text(encoding="utf-8"))


@cache
def program_of(stage_name: str, prompt: str) -> PhysicalProgram:
    stage = EVERYDAY[stage_name]
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def demanded(program: PhysicalProgram) -> list[Any]:
    contract = program.contract
    return [s for s in contract.statements if s.id not in contract.serving]


@pytest.mark.parametrize("row", ROWS, ids=[f"{row['stage']}-{n}" for n, row in enumerate(ROWS)])
def test_what_a_sentence_demands(row: dict[str, Any]) -> None:
    program = program_of(row["stage"], row["prompt"])
    assert {claim(s, program) for s in demanded(program)} == set(row["demands"]), row["prompt"]
    contract = program.contract
    told = [*contract.not_understood, *(clause.text for clause in contract.untested)]
    assert told == row.get("untold", []), row["prompt"]


@pytest.mark.parametrize(("seconds", "frames"), [(None, 81), (2.0, 51), (10.0, 251)])
def test_a_clip_of_a_length_that_is_asked_for(seconds: float | None, frames: int) -> None:
    stage = EVERYDAY["kitchen"]
    case = replace(stage.case("The teapot wobbles, then falls over."), seconds=seconds)
    program = RuleGenerator().first(case, stage.reconstruct)
    assert program.clip.frames == frames
    # It wobbles in its first half, however long that is.
    (until,) = {s.to_step for s in program.contract.statements if s.kind == "sways"}
    assert until == program.clip.steps // 2


@pytest.mark.parametrize(
    ("stage", "prompt", "bound"),
    [
        ("kitchen", "The mug slides about 20 cm to the left.", "left (by at least 0.16 m)"),
        ("kitchen", "The mug slides half a metre to the left.", "left (by at least 0.67 m)"),
        ("kitchen", "The mug slides a little.", "does not move (by at least 0.13 m)"),
        ("kitchen", "The mug slides to the egg at 0.5 m/s.", "top speed (0.3 to 0.75 m/s)"),
        ("kitchen", "The teapot turns by 90 degrees.", "turn (by at least 136°)"),
        ("kitchen", "The spoon spins half a turn.", "turns (by at least 144°)"),
        ("kitchen", "After 2 seconds the mug tips over.", "until frame 40"),
        ("kitchen", "The mug slides towards the egg and stops 5 cm before it.", "(within 0.09 m)"),
        ("office", "The pen does three full turns.", "turns (by at least 1020°)"),
    ],
)  # fmt: skip
def test_numbers_are_bounds(stage: str, prompt: str, bound: str) -> None:
    program = program_of(stage, prompt)
    assert any(bound in describe(s, program) for s in demanded(program)), prompt
    assert not program.contract.untested


def test_what_is_larger_is_known_by_its_size() -> None:
    told = {}
    for word in ("taller", "shorter", "bigger"):
        program = program_of("boxes", f"The {word} box falls over.")
        told[word] = {claim(s, program) for s in demanded(program)}
    assert told["taller"] == {"box_b topples"}
    assert told["shorter"] == told["bigger"] == {"box_a topples"}


def test_what_comes_next_waits() -> None:
    program = program_of("kitchen", "First the mug tips over, then the teapot tips over.")
    starts = {action.name: action.start_step for action in program.event.actions}
    assert starts["teapot"] >= starts["mug"] + 50


def test_what_is_told_in_numbers_is_what_the_program_begins_with() -> None:
    program = program_of("office", "The coffee cup slides to the right at 0.5 m/s.")
    (action,) = program.event.actions
    assert action.model_dump()["force"]["magnitude"] == 0.5


def test_a_row_that_one_topples_passes_it_on() -> None:
    """The first one reaches the next, and not the last."""
    prompt = "The first domino is pushed and topples the others in sequence."
    program = program_of("dominoes", prompt)
    told = {claim(s, program) for s in demanded(program)}
    one_by_one = ", then ".join(f"domino_{n} topples" for n in (1, 2, 3, 4, 5))
    assert f"{one_by_one}, one after another" in told
    assert "domino_1 touches domino_5" not in told


def test_speeding_up_is_no_rise() -> None:
    program = program_of("toys", "The toy truck speeds up.")
    assert not any("up" in claim(s, program) for s in demanded(program))


@pytest.mark.parametrize(
    ("rest", "mover"),
    [
        ("it rolls to the right", "marble"),
        ("it slides away", "marble"),
        ("it keeps moving to the right", "stapler"),
        ("it slides back", "stapler"),
    ],
)
def test_it_is_what_was_struck_unless_it_goes_on_or_back(rest: str, mover: str) -> None:
    program = program_of("office", f"The stapler hits the marble and {rest}.")
    moved = [claim(s, program) for s in demanded(program) if s.kind in ("moves", "reverses")]
    assert any(text.startswith(mover) for text in moved), moved
