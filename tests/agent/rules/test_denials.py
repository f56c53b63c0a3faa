"""What a prompt denies is denied in the contract, and no place of it is silently dropped."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.language import inventory, read
from physagent_studio.program import Grounding, PhysicalProgram
from tests.agent.rules.scenes import STAGES


def program(stage: str, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(STAGES[stage].case(prompt), STAGES[stage].reconstruct)


@pytest.mark.parametrize(
    "prompt",
    [
        "None of the pins falls over.",
        "No pin falls over.",
        "The pins don't fall over.",
        "None of the pins fall over.",
    ],
)
def test_a_quantity_of_nothing_denies(prompt: str) -> None:
    contract = program("lane", prompt).contract
    assert {s.subject for s in contract.statements} == {"left_pin", "middle_pin", "right_pin"}  # type: ignore[union-attr]
    assert all(s.kind == "topples" and s.negated for s in contract.statements)


@pytest.mark.parametrize(
    "prompt",
    [
        "The ball touches none of the pins.",
        "The ball hits no pin.",
        "The ball misses all of the pins.",
    ],
)
def test_an_object_of_nothing_denies(prompt: str) -> None:
    statements = program("lane", prompt).contract.statements
    touches = [s for s in statements if s.kind == "contacts"]
    assert {s.other for s in touches} == {"left_pin", "middle_pin", "right_pin"}
    assert all(s.negated for s in touches)
    # What misses them moves, where nothing else says so.
    assert {s.kind for s in statements} - {"contacts"} <= {"moves"}


@pytest.mark.parametrize(
    ("prompt", "pushed"),
    [
        ("The apples are pushed to the right, while the left apple stays put.", ["right_apple"]),
        ("The apples are pushed and only the right apple moves.", ["right_apple"]),
        ("At first the left apple does not move, then both apples are pushed.", None),
        ("The apples are pushed to the right and stay there.", None),
        ("The apples are pushed. Only the left apple rolls back.", None),
    ],
)
def test_what_stays_is_not_pushed_unless_it_stays_later(
    prompt: str, pushed: list[str] | None
) -> None:
    stock = inventory([(name, Grounding()) for name in ("left_apple", "right_apple")])
    (push,) = (frame for frame in read(prompt, stock).frames if frame.sense == "push")
    assert sorted(push.patient) == (pushed or ["left_apple", "right_apple"])


@pytest.mark.parametrize("rest", ["does not move at all", "does not move in the least"])
def test_at_all_only_stresses(rest: str) -> None:
    statements = program("fruit", f"The left apple rolls away, but the right one {rest}.").contract
    still = [s.subject for s in statements.statements if s.kind == "stays"]
    assert still == ["right_apple"]


@pytest.mark.parametrize("prompt", ["Neither apple moves.", "Neither of the apples moves."])
def test_neither_denies_both(prompt: str) -> None:
    statements = program("fruit", prompt).contract.statements
    assert {(s.kind, s.subject) for s in statements} == {  # type: ignore[union-attr]
        ("stays", "left_apple"),
        ("stays", "right_apple"),
    }


@pytest.mark.parametrize(
    "rest",
    [
        "and nothing else moves",
        "while everything else stays still",
        "and the rest stays where it is",
        "while the others do not move",
    ],
)
def test_all_else_is_what_was_not_spoken_of(rest: str) -> None:
    contract = program("desk", f"The red cube slides to the right {rest}.").contract
    assert not contract.untested
    assert not contract.not_understood
    last = contract.statements[-1]
    assert (last.kind, last.subject) == ("stays", "blue_cup")  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("stage", "prompt", "place"),
    [
        ("desk", "The red cube slides under the table.", "table"),
        ("ice", "The red stone pushes the yellow stone out of the target.", "target"),
    ],
)
def test_a_place_that_nothing_tests_is_said(stage: str, prompt: str, place: str) -> None:
    said = program(stage, prompt).contract
    tested = any(place in s.model_dump_json() for s in said.statements)
    assert tested or any(place in clause.text for clause in said.untested)


@pytest.mark.parametrize(
    ("stage", "prompt"),
    [
        ("desk", "The red cube slides across the table."),
        ("lane", "The bowling ball rolls along the floor toward the left pin."),
        ("slope", "The toy car rolls down the ramp."),
        ("fruit", "The left apple on the table rolls to the right."),
    ],
)
def test_where_it_happens_needs_no_test(stage: str, prompt: str) -> None:
    contract = program(stage, prompt).contract
    assert not contract.not_understood
    assert not contract.untested
