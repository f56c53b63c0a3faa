"""What rolls or slides and then falls over does one after the other, and lies still."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.measure import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Cylinder
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage


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


@pytest.mark.parametrize("ratio", [0.4, 1.0, 1.7])
@pytest.mark.parametrize("round_", [True, False])
def test_the_wide_are_lifted_at_the_rear_and_tip_over_as_the_slender_do(ratio, round_) -> None:
    high, wide = 0.3, 0.3 * ratio
    body = Cylinder(radius=wide / 2, height=high) if round_ else Box(size=(wide, wide, high))
    yard = Stage("yard", {"crate": (body, (0.0, 3.0, high / 2), "floor")})
    program = RuleGenerator().first(yard.case("The crate tips over to the left."), yard.reconstruct)
    demanded = [c for c in measure(program, simulate(program, {})) if c.demanded]
    assert all(check.ok for check in demanded if not check.always_on), demanded
