"""A person takes over in the middle, and what the agent proposes from then on respects it."""

from __future__ import annotations

import pytest

from physagent_studio.agent.memory import lessons_of, memory_of
from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.planner.factors import relevant_knobs
from physagent_studio.program import SetField, apply, value_at
from physagent_studio.records import (
    Lesson,
    Proposal,
)
from tests.agent.lane import AIM, FORCE, SPEED, Loop, Weak


def paths(proposal: Proposal) -> set[str]:
    return {edit.path for edit in proposal.edits}


@pytest.fixture
def loop() -> Loop:
    found = Loop(Weak())
    assert found.proposal.hunks
    return found


@pytest.fixture
def passed() -> Loop:
    found = Loop(RuleGenerator())
    assert found.state.outcome == "realised"
    return found


def test_a_rejected_proposal_does_not_come_back(loop: Loop) -> None:
    first = loop.proposal
    loop.says("reject", "I want another way than speed")
    assert loop.proposal.edits != first.edits
    assert memory_of(loop.state).rejected[0][1] == "I want another way than speed"
    loop.says("reject")
    assert loop.proposal.edits != first.edits


def test_a_reason_sets_the_sign(loop: Loop) -> None:
    loop.says("reject", "it must be slower")
    for edit in loop.proposal.edits:
        if isinstance(edit, SetField) and edit.path == SPEED:
            assert isinstance(edit.value, float)
            assert edit.value <= value_at(loop.program, SPEED)  # type: ignore[operator]


def test_a_number_that_a_person_set_is_left_as_it_is(loop: Loop) -> None:
    loop.says("override", "", SetField(path=SPEED, value=2.5))
    assert loop.state.phase == "decide", "the aim is still off"
    assert value_at(loop.program, SPEED) == 2.5
    assert SPEED not in paths(loop.proposal) or loop.proposal.touches_verified
    assert SPEED in memory_of(loop.state).verified
    assert AIM in paths(loop.proposal)


def test_a_pinned_fact_is_never_touched(loop: Loop) -> None:
    loop.state = loop.state.model_copy(update={"pinned": (SPEED,)})
    loop.says("hint", "try the aim")
    for _ in range(2):
        if loop.state.phase != "decide" or not loop.proposal.hunks:
            break
        assert SPEED not in paths(loop.proposal)
        assert FORCE not in paths(loop.proposal)
        loop.says("accept", "", *loop.proposal.edits)  # type: ignore[arg-type]
        assert value_at(loop.program, SPEED) == 0.3


def test_words_of_degree_against_a_pass_turn_that_number(passed: Loop) -> None:
    before = value_at(passed.program, SPEED)
    passed.overrules("it should be faster")
    assert passed.proposal.factor == "magnitude"
    after = value_at(apply(passed.program, passed.proposal.edits), SPEED)
    assert after > before  # type: ignore[operator]
    passed.says("accept", "", *passed.proposal.edits)  # type: ignore[arg-type]
    assert value_at(passed.program, SPEED) == after


def test_an_event_against_a_pass_becomes_a_demand(passed: Loop) -> None:
    passed.overrules("It must hit the left pin as well.")
    assert passed.proposal.factor == "contract"
    demanded = apply(passed.program, passed.proposal.edits).contract
    assert len(demanded.statements) > len(passed.program.contract.statements)
    added = demanded.statements[-1]
    assert "left_pin" in added.model_dump_json()
    assert demanded.clauses[-1].text == "It must hit the left pin as well."
    passed.says("accept", "", *passed.proposal.edits)  # type: ignore[arg-type]
    current = passed.state.current
    assert current is not None
    assert current.assessment is not None
    assert added.id in {check.id for check in current.assessment.checks}


def test_what_may_be_a_complaint_is_offered_as_a_demand(passed: Loop) -> None:
    passed.overrules("It hits the left pin as well.")
    assert not passed.proposal.hunks
    text, said = passed.proposal.meant[0]
    assert text == "Demand it: It hits the left pin as well."
    passed.says("hint", said)
    assert passed.proposal.factor == "contract"
    assert passed.proposal.understood == "a new demand, “It hits the left pin as well.”"


def test_what_was_decided_is_told_as_lessons(loop: Loop) -> None:
    loop.says("reject", "not like this")
    loop.says("override", "", SetField(path=SPEED, value=2.5))
    told = {lesson.decided: lesson for lesson in lessons_of(loop.state)}
    assert told["reject"].reason == "not like this"
    assert not told["reject"].helped
    assert told["override"].factor == "by hand"


def test_what_helped_before_is_tried_first(loop: Loop) -> None:
    assessment = loop.state.current.assessment  # type: ignore[union-attr]
    assert assessment is not None
    worst = assessment.diagnosis[0].code
    knobs = [knob.factor for knob in relevant_knobs(loop.situation(), verified=False)]
    last = knobs[-1]
    taught = Lesson(
        mismatch=worst, factor=last, decided="accept", failing_before=1, failing_after=0
    )
    loop.state = loop.state.model_copy(update={"lessons": (taught,) * 50})
    again = [knob.factor for knob in relevant_knobs(loop.situation(), verified=False)]
    assert again.index(last) < knobs.index(last)
    assert sorted(again) == sorted(knobs)


def test_words_that_say_nothing_are_answered_by_a_question(passed: Loop) -> None:
    passed.overrules("I do not like it")
    assert not passed.proposal.hunks
    assert passed.proposal.question.endswith("”.") or "?" in passed.proposal.question
