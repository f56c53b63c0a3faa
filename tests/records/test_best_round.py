"""Which round is shown as the result."""

from __future__ import annotations

import pytest

from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Assessment, Check, Round
from physagent_studio.records.loop_state import best_of


def _round(number: int, moves: bool, margin: float, passed: bool = False) -> Round:
    told = {"measured": None, "threshold": None, "unit": ""}
    checks = (
        Check(id="view.something", text="", ok=moves, margin=1.0 if moves else -1.0, **told),
        Check(id="s1", text="", ok=margin >= 0, margin=margin, **told),
    )
    judged = Assessment(stage="simulation", passed=passed, checks=checks)
    return Round(
        id=f"r{number}", number=number, parent=None, program=PhysicalProgram(), author="planner",
        rollout="key", assessment=judged,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("rounds", "best"),
    [
        # At rest it misses by less, and yet nothing is to be seen in it.
        ([_round(1, moves=True, margin=-3.0), _round(2, moves=False, margin=-0.1)], "r1"),
        ([_round(1, moves=True, margin=-3.0), _round(2, moves=True, margin=-0.1)], "r2"),
        ([_round(1, moves=False, margin=-3.0), _round(2, moves=False, margin=-0.1)], "r2"),
        # A person has said that a round at rest is what was meant.
        ([_round(1, moves=True, margin=-3.0), _round(2, False, 0.0, passed=True)], "r2"),
    ],
)
def test_a_round_in_which_something_happens_goes_first(rounds: list[Round], best: str) -> None:
    found = best_of(rounds)
    assert found is not None
    assert found.id == best
