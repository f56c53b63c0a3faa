"""A person takes over in the middle, and what the agent proposes from then on respects it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from physagent_studio.agent.loop import Bench, Crew, advance, decide, replace_round
from physagent_studio.agent.memory import lessons_of, memory_of
from physagent_studio.agent.roles import Generator, Situation
from physagent_studio.agent.rules import RuleGenerator, RulePlanner, RuleVerifier
from physagent_studio.agent.rules.factors import relevant_knobs
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram, SetField, apply, value_at
from physagent_studio.records import (
    Case,
    Decision,
    Lesson,
    LoopState,
    Override,
    Proposal,
    Rollout,
    Scene,
)
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES

PROMPT = "The bowling ball rolls toward the middle pin, hits it and knocks it over."
FORCE = "event.actions.push_bowling_ball.force"
SPEED, AIM = f"{FORCE}.magnitude", f"{FORCE}.azimuth"
STAGE = STAGES["lane"]


class Weak:
    """The rules' own program, far too weak and a little off."""

    def first(self, case: Case, reconstruct: Callable[..., Scene]) -> PhysicalProgram:
        program = RuleGenerator().first(case, reconstruct)
        return apply(program, [SetField(path=SPEED, value=0.3), SetField(path=AIM, value=6.0)])


class Loop:
    """The loop over a scene without a photo, kept in memory."""

    def __init__(self, generator: Generator) -> None:
        self.scenes: dict[str, Scene] = {}
        self.rollouts: dict[str, Rollout] = {}
        self.crew = Crew(generator, RuleVerifier(), RulePlanner(limit=20))
        self.state = LoopState(policy="ask", budget=10)
        self.bench = Bench(
            case=STAGE.case(PROMPT),
            reconstruct=lambda state, before: STAGE.reconstruct(state),
            simulate=lambda program, scene: simulate(program, {}),
            measure=measure,
            view=lambda scene: None,
            evidence=lambda scene, rollout: (),
            put_scene=self._put_scene,
            get_scene=self.scenes.__getitem__,
            put_rollout=self._put_rollout,
            get_rollout=self.rollouts.__getitem__,
            put_frames=lambda frames: "",
        )
        self.go_on()

    def _put_scene(self, scene: Scene) -> str:
        self.scenes[scene.hash] = scene
        return scene.hash

    def _put_rollout(self, rollout: Rollout) -> str:
        key = f"r{len(self.rollouts)}"
        self.rollouts[key] = rollout
        return key

    def go_on(self) -> None:
        """Until a person has to decide or it is done."""
        while (after := advance(self.state, self.crew, self.bench)) is not self.state:
            self.state = after

    @property
    def proposal(self) -> Proposal:
        current = self.state.current
        assert current is not None
        assert current.proposal is not None, self.state.phase
        return current.proposal

    @property
    def program(self) -> PhysicalProgram:
        assert self.state.current is not None
        return self.state.current.program

    def says(self, kind: str, reason: str = "", *edits: SetField) -> None:
        decision = Decision.model_validate(
            {"kind": kind, "author": "person", "at": "", "reason": reason}
        )
        self.state = decide(self.state, decision.model_copy(update={"edits": edits}))
        self.go_on()

    def situation(self) -> Situation:
        """What the planner is given at the head."""
        current = self.state.current
        assert current is not None
        assert current.assessment is not None
        return Situation(
            case=self.bench.case,
            program=current.program,
            scene=self.scenes[current.scene or ""],
            rollout=None,
            assessment=current.assessment,
            memory=memory_of(self.state),
            try_out=lambda program: pytest.fail("nothing is run"),
        )

    def overrules(self, words: str) -> None:
        """What the workbench does with a verdict of "failed" against a pass."""
        current = self.state.current
        assert current is not None
        assert current.assessment is not None
        assert current.assessment.passed
        override = Override(passed=False, author="person", at="", words=words)
        state = replace_round(self.state, current.model_copy(update={"override": override}))
        self.state = state.model_copy(update={"phase": "propose", "outcome": "running"})
        self.go_on()


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
    passed.overrules("It hits the left pin as well.")
    assert passed.proposal.factor == "contract"
    demanded = apply(passed.program, passed.proposal.edits).contract
    assert len(demanded.statements) > len(passed.program.contract.statements)
    added = demanded.statements[-1]
    assert "left_pin" in added.model_dump_json()
    assert demanded.clauses[-1].text == "It hits the left pin as well."
    passed.says("accept", "", *passed.proposal.edits)  # type: ignore[arg-type]
    current = passed.state.current
    assert current is not None
    assert current.assessment is not None
    assert added.id in {check.id for check in current.assessment.checks}


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
