"""A hundred single wordings: all of each is read, and means what a person means by it.

Nothing is simulated here. What no one can read, or what is nonsense, is listed as such.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.words import claim
from physagent_studio.program import PhysicalProgram
from tests.agent.rules.scenes import STAGES

ROWS = yaml.safe_load((Path(__file__).parent / "wordings.yaml").read_text(encoding="utf-8"))


def program_of(stage_name: str, prompt: str) -> PhysicalProgram:
    stage = STAGES[stage_name]
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def demands(program: PhysicalProgram) -> set[str]:
    contract = program.contract
    return {claim(s, program) for s in contract.statements if s.id not in contract.serving}


@pytest.mark.parametrize("row", ROWS, ids=[f"{row['stage']}-{n}" for n, row in enumerate(ROWS)])
def test_what_a_wording_demands(row: dict[str, Any]) -> None:
    program = program_of(row["stage"], row["prompt"])
    assert demands(program) == set(row["demands"]), row["prompt"]
    assert not program.contract.untested, row["prompt"]
    assert not program.contract.not_understood, row["prompt"]


def test_there_are_a_hundred() -> None:
    assert len({row["prompt"] for row in ROWS}) >= 100


@pytest.mark.parametrize(
    ("stage", "typed", "meant"),
    [
        ("field", "The bal rolls slowly to the rigth.", "The ball rolls slowly to the right."),
        ("desk", "The red cube is puhsed off the tabel.", "The red cube is pushed off the table."),
        ("lane", "The bowlling ball hitts the left pin.", "The bowling ball hits the left pin."),
        ("wind", "The baloon drifts to teh left.", "The balloon drifts to the left."),
        ("slope", "The car rolls downn the ramp quikcly.", "The car rolls down the ramp quickly."),
        (
            "ice",
            "The red stone rolls past the grey rock.",
            "The red stone rolls past the gray rock.",
        ),
    ],
)
def test_a_slip_of_the_keyboard_changes_nothing(stage: str, typed: str, meant: str) -> None:
    assert demands(program_of(stage, typed)) == demands(program_of(stage, meant))


@pytest.mark.parametrize(
    ("stage", "prompt", "words"),
    [
        ("field", "The ball turns into a dragon.", ("dragon",)),
        ("desk", "The cup sings a song.", ("sings",)),
        ("ice", "The ice is melting.", ("melting",)),
        ("court", "The basketball hits the crate twice.", ("twice",)),
        ("ice", "The red stone stops halfway.", ("halfway",)),
        ("ice", "The red stone bumps the yellow stone and takes its place.", ("place",)),
        ("desk", "The red cube moves near the cup.", ("blue cup",)),
    ],
)
def test_what_is_not_read_is_said(stage: str, prompt: str, words: tuple[str, ...]) -> None:
    contract = program_of(stage, prompt).contract
    told = (*contract.not_understood, *(clause.text for clause in contract.untested))
    assert all(any(word in one for one in told) for word in words), told
