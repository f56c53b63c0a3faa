"""How fast the verbs let things go: by their senses, their manner and the things' sizes."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.knowledge import pace_of
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import ApplyForce, OnContact
from physagent_studio.program.contract import Speeds
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES


def program_of(stage: str, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(STAGES[stage].case(prompt), STAGES[stage].reconstruct)


def paces_of(stage: str, prompt: str) -> dict[str, Speeds]:
    return {pace.subject: pace for pace in program_of(stage, prompt).contract.paces}


def test_what_rolls_by_itself_has_the_pace_of_rolling() -> None:
    pace, known = paces_of("field", "The ball rolls to the left.")["ball"], pace_of("roll")
    assert known is not None
    assert pace.verb == "roll"
    assert 0 < pace.low < pace.high <= known.plain.metres.high


def test_what_is_pushed_until_it_hits_goes_as_it_stands() -> None:
    """It is pushed at its foot for all of its way, and held there as the two meet."""
    program = program_of("desk", "The red cube is pushed to the left until it hits the blue cup.")
    assert [pace.verb for pace in program.contract.paces if pace.subject == "red_cube"] == ["push"]
    push, slow = (a for a in program.event.actions if isinstance(a, ApplyForce))
    assert push.point is not None
    assert push.point == slow.point
    assert isinstance(slow.when, OnContact)
    checks = measure(program, simulate(program, {}))
    assert all(check.ok for check in checks if check.id.startswith("view.footing."))
    assert any(check.id == "view.footing.red_cube" for check in checks)


def test_what_hits_by_itself_is_sent_off_by_a_blow() -> None:
    program = program_of("desk", "The red cube slides to the left and hits the blue cup.")
    assert [getattr(action, "point", None) for action in program.event.actions] == [None]


def test_slowly_is_slower_and_fast_is_faster() -> None:
    high = [
        paces_of("field", f"The ball rolls{manner} to the left.")["ball"].high
        for manner in (" slowly", "", " fast")
    ]
    assert high == sorted(high)
    assert high[0] < high[2]


def test_what_is_larger_may_go_faster() -> None:
    """By lengths of its own: an apple rolls less fast than a bowling ball."""
    apple = paces_of("fruit", "The left apple rolls to the right.")["left_apple"]
    bowl = paces_of("lane", "The bowling ball rolls to the right.")["bowling_ball"]
    assert apple.high < bowl.high


def test_a_speed_that_is_told_is_the_pace() -> None:
    pace = paces_of("field", "The ball rolls to the left at 2 m/s.")["ball"]
    assert pace.low == pytest.approx(1.0)
    assert pace.high == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("stage", "prompt", "name"),
    [
        ("air", "The melon falls onto the stool.", "melon"),
        ("desk", "The red cube falls off the table.", "red_cube"),
        ("slope", "The toy car rolls down the ramp.", "toy_car"),
        ("lane", "The bowling ball rolls toward the middle pin and hits it.", "middle_pin"),
        ("shelf", "The green ball jumps over the domino.", "green_ball"),
    ],
)
def test_what_falls_flies_or_is_struck_has_none(stage: str, prompt: str, name: str) -> None:
    assert name not in paces_of(stage, prompt)


@pytest.mark.parametrize(
    ("stage", "prompt"),
    [
        ("field", "The ball rolls to the left."),
        ("field", "The ball rolls slowly to the right."),
        ("ice", "The red stone slides to the right."),
        ("lane", "The bowling ball rolls toward the middle pin and hits it."),
    ],
)
def test_the_first_program_keeps_to_the_pace(stage: str, prompt: str) -> None:
    program = program_of(stage, prompt)
    assert program.contract.paces
    checks = measure(program, simulate(program, {}))
    amounts = [check for check in checks if check.id.startswith("view.amount.")]
    assert amounts
    assert all(check.ok for check in amounts), [check.text for check in amounts]


def test_a_program_without_paces_has_the_hash_that_it_always_had() -> None:
    program = program_of("air", "The melon falls onto the stool.")
    assert program.contract.paces == ()
    some = Speeds(subject="melon", verb="roll", high=1.0)
    paced = program.contract.model_copy(update={"paces": (some,)})
    assert program.model_copy(update={"contract": paced}).hash != program.hash
