"""A person for a chosen role: the loop waits where that role is to act, every time."""

from __future__ import annotations

import pytest

from physagent_studio.agent.by_hand import turn_of, waits_for, without_schedule
from physagent_studio.agent.loop import add_round, advance
from physagent_studio.agent.memory import memory_of
from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.program import PhysicalProgram, SetField, apply
from physagent_studio.records import Decision, LoopState, Override, Proposal
from physagent_studio.records.loop_state import RoleName
from physagent_studio.workbench.deciding import forked, overruled, with_role
from tests.agent.lane import AIM, SPEED, Loop, Weak


def by(role: RoleName, generator: object = None) -> Loop:
    """The loop, every proposal accepted by itself, with one role played by a person."""
    state = LoopState(policy="auto", budget=10, by_hand=(role,))
    return Loop(generator or Weak(), state)  # type: ignore[arg-type]


def gives(loop: Loop, passed: bool, words: str = "") -> None:
    """A verdict of the person, and what follows from it."""
    override = Override(passed=passed, author="person", at="", words=words)
    loop.state = overruled(loop.state, override)
    loop.go_on()


class Forbidden:
    """A role of the agent that must not be asked."""

    def first(self, *_: object) -> PhysicalProgram:
        pytest.fail("the agent wrote the program")

    def propose(self, situation: Situation) -> Proposal:
        pytest.fail("the agent proposed")


def test_the_generator_is_not_asked_and_the_draft_is_run_as_mine() -> None:
    loop = by("generator", Forbidden())
    assert (loop.state.phase, loop.state.rounds) == ("generate", ())
    assert waits_for(loop.state) == "your first program"
    written = RuleGenerator().first(
        loop.bench.case, lambda state: loop.bench.reconstruct(state, None)
    )
    assert without_schedule(written).event.actions == ()
    loop.state = loop.state.model_copy(update={"draft": written})
    loop.go_on()
    first = loop.state.rounds[0]
    assert (first.author, first.program.event) == ("person", written.event)
    assert loop.state.outcome == "realised"


def test_a_person_verifies_every_stage_of_every_round() -> None:
    loop = by("verifier")
    seen = []
    for _ in range(12):
        current = loop.state.current
        if loop.state.phase == "done":
            break
        assert current is not None
        assert current.assessment is not None
        assert turn_of(loop.state) == "verifier"
        assert current.ruling is None
        seen.append((current.number, current.assessment.stage))
        measured = all(check.ok for check in current.assessment.checks if check.demanded)
        gives(loop, measured)
    assert seen[:4] == [
        (1, "reconstruction"),
        (1, "simulation"),
        (2, "reconstruction"),
        (2, "simulation"),
    ]
    assert loop.state.outcome == "realised"
    assert all(item.ruling is not None for item in loop.state.rounds)


def test_my_no_to_a_measured_pass_is_obeyed_and_my_words_are_known() -> None:
    loop = by("verifier", RuleGenerator())
    gives(loop, True)
    assert loop.state.current is not None
    assert loop.state.current.assessment is not None
    assert loop.state.current.assessment.passed
    gives(loop, False, "it should be faster")
    assert loop.state.rounds[0].passed is False
    assert loop.state.rounds[0].proposal is not None
    assert "faster" in loop.state.rounds[0].proposal.rationale


def test_my_yes_to_a_measured_failure_ends_it() -> None:
    loop = by("verifier")
    gives(loop, True)
    gives(loop, True, "close enough")
    assert (loop.state.outcome, len(loop.state.rounds)) == ("realised", 1)


def test_a_scene_that_i_refuse_is_never_simulated() -> None:
    loop = by("verifier")
    gives(loop, False, "the ball is too small")
    current = loop.state.current
    assert current is not None
    assert current.proposal is not None
    assert "the ball is too small" in current.proposal.question
    assert (loop.rollouts, current.simulations) == ({}, 0)


def test_what_i_say_of_the_scene_decides_what_counts_as_verified() -> None:
    loop = by("verifier")
    gives(loop, False, "the ball is too small")
    assert memory_of(loop.state).verified == ()
    loop.state = overruled(loop.state, Override(passed=True, author="person", at=""))
    assert "scene.objects.bowling_ball.position" in memory_of(loop.state).verified


def test_the_planner_is_not_asked_and_my_edits_are_the_next_round() -> None:
    loop = by("planner")
    loop.crew = type(loop.crew)(loop.crew.generator, loop.crew.verifier, Forbidden())
    assert waits_for(loop.state) == "your repair"
    runs = len(loop.rollouts)
    loop.go_on()
    assert len(loop.rollouts) == runs
    mine = apply(loop.program, [SetField(path=SPEED, value=4.0), SetField(path=AIM, value=0.0)])
    origin = Decision(kind="override", author="person", at="", reason="by hand")
    loop.state = add_round(loop.state, mine, "person", origin)
    loop.go_on()
    assert loop.state.rounds[-1].author == "person"
    assert (loop.state.phase, loop.state.outcome) in (("propose", "running"), ("done", "realised"))
    assert all(item.proposal is None for item in loop.state.rounds)


def test_a_role_that_is_given_back_is_played_by_the_agent_again() -> None:
    loop = by("planner")
    loop.state = with_role(loop.state, "planner", on=False)
    loop.go_on()
    assert loop.state.rounds[0].proposal is not None
    waiting = by("verifier")
    taken_back = with_role(waiting.state, "verifier", on=False)
    assert advance(taken_back, waiting.crew, waiting.bench).phase == "simulate"


def test_the_roles_survive_storing_and_going_back_to_a_round() -> None:
    loop = by("verifier")
    stored = LoopState.model_validate_json(loop.state.model_dump_json())
    assert (stored.by_hand, stored.phase) == (("verifier",), "judge")
    assert forked(stored, "r1").phase == "judge"


def test_a_scene_that_i_accept_although_it_fails_is_run_and_not_called_realised() -> None:
    loop = by("verifier")
    current = loop.state.current
    assert current is not None
    assert current.assessment is not None
    failed = current.model_copy(
        update={"assessment": current.assessment.model_copy(update={"passed": False})}
    )
    loop.state = loop.state.model_copy(
        update={"rounds": (failed,), "by_hand": (), "phase": "decide"}
    )
    after = overruled(loop.state, Override(passed=True, author="person", at=""))
    assert (after.phase, after.outcome) == ("simulate", "running")
    assert after.rounds[0].passed is False
