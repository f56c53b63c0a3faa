"""What the run panel says of a loop that has ended."""

from __future__ import annotations

import pytest

from physagent_studio.program import Contract, PhysicalProgram
from physagent_studio.records import LoopState
from physagent_studio.session.standing import IN_DOUBT
from physagent_studio.studio.panels.run import state_of
from physagent_studio.workbench import Snapshot


@pytest.mark.parametrize(
    ("strange", "said"),
    [((), "The event happens."), (("glimmers",), f"The event happens, {IN_DOUBT}.")],
)
def test_a_word_that_was_not_understood_is_no_plain_success(
    strange: tuple[str, ...], said: str
) -> None:
    program = PhysicalProgram(contract=Contract(not_understood=strange))
    done = LoopState(phase="done", outcome="realised")
    found = state_of(Snapshot(revision=1, program=program, state=done))
    assert (found["outcome"], found["inDoubt"]) == (said, bool(strange))
