"""The loop over a lane with pins, without a photo, kept in memory; a person may act in it."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import pytest

from physagent_studio.agent.crew import Bench, Crew
from physagent_studio.agent.loop import advance, decide, replace_round
from physagent_studio.agent.memory import memory_of
from physagent_studio.agent.roles import Generator, Situation
from physagent_studio.agent.rules import RuleGenerator, RulePlanner, RuleVerifier
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram, SetField, apply
from physagent_studio.records import (
    Case,
    Check,
    Decision,
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


@lru_cache(maxsize=128)
def _run(program: str) -> Rollout:
    """A run; the same search begins most tests, and asks for the same runs."""
    return simulate(PhysicalProgram.model_validate_json(program), {})


@lru_cache(maxsize=128)
def _checks(program: str, rollout: Rollout) -> tuple[Check, ...]:
    return measure(PhysicalProgram.model_validate_json(program), rollout)


class Weak:
    """The rules' own program, far too weak and a little off."""

    def first(self, case: Case, reconstruct: Callable[..., Scene]) -> PhysicalProgram:
        program = RuleGenerator().first(case, reconstruct)
        return apply(program, [SetField(path=SPEED, value=0.3), SetField(path=AIM, value=6.0)])


class Loop:
    """The loop over a scene without a photo, kept in memory."""

    def __init__(self, generator: Generator, state: LoopState | None = None) -> None:
        self.scenes: dict[str, Scene] = {}
        self.rollouts: dict[str, Rollout] = {}
        self.crew = Crew(generator, RuleVerifier(), RulePlanner(limit=20))
        self.state = state or LoopState(policy="ask", budget=10)
        self.bench = Bench(
            case=STAGE.case(PROMPT),
            reconstruct=lambda state, before: STAGE.reconstruct(state),
            simulate=lambda program, scene: _run(program.model_dump_json()),
            measure=lambda program, rollout, scene: _checks(program.model_dump_json(), rollout),
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
