"""What rolls or slides and then falls over does one after the other, and lies still."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.program import PhysicalProgram
from tests.agent.rules.scenes import STAGES


def _first(prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(STAGES["shelf"].case(prompt), STAGES["shelf"].reconstruct)


@pytest.mark.parametrize(
    "prompt",
    [
        "The domino slides to the left, slows down and falls over.",
        "The domino moves to the left, loses speed and topples.",
    ],
)
def test_it_is_tipped_when_it_has_gone(prompt: str) -> None:
    program = _first(prompt)
    push, *_, tip = program.event.actions
    assert (push.id, tip.id) == ("push_domino", "tip_domino")
    assert tip.start_step >= push.start_step + getattr(push, "duration", 0)
    kinds = {statement.kind for statement in program.contract.statements}
    assert {"topples", "stops"} <= kinds
    assert not program.contract.untested


def test_what_slows_down_and_goes_on_is_not_told() -> None:
    assert _first("The domino slides to the left and slows down.").contract.untested
