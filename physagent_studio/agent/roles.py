"""The three roles of the method and the reviewer, on one page.

A rule-based agent, a language model and a person implement them alike.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.records import (
    Assessment,
    Case,
    Check,
    Decision,
    Evidence,
    Memory,
    Preview,
    Proposal,
    Rollout,
    Scene,
)


@dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """One candidate run of a planner's search: its rollout and its checks, contract first."""

    rollout: Rollout
    checks: tuple[Check, ...]


class Ahead(Protocol):
    """Trials on several cores: while one is waited for, what may be wanted next is begun."""

    def take(
        self, program: PhysicalProgram, then: Callable[[], Sequence[PhysicalProgram]] = ...
    ) -> Trial:
        """What a candidate does, as by `Situation.try_out`.

        then: asked meanwhile for what may be wanted next, likeliest first.
        """
        ...

    def give_up(self) -> None:
        """Nothing of what was begun is wanted any more."""
        ...


@dataclass(frozen=True, eq=False, slots=True)
class Situation:
    """What a planner works from.

    try_out runs a candidate program; it raises `StudioError` for one that cannot run and
    `Cancelled` when the person cancels. ahead: the same on several cores, None where one is all.
    look: reconstructs a changed scene state without a run.
    scene: the reconstruction, None before stage 1.
    """

    case: Case
    program: PhysicalProgram
    scene: Scene
    rollout: Rollout | None
    assessment: Assessment
    memory: Memory
    try_out: Callable[[PhysicalProgram], Trial]
    look: Callable[[SceneState], Scene] | None = None
    ahead: Ahead | None = None


class Generator(Protocol):
    """G: writes the first program from the case.

    It may look at the reconstruction of the scene state that it wrote (distances and sizes are
    needed for mechanics; the result is cached for stage 1), but it never simulates.
    """

    def first(self, case: Case, reconstruct: Callable[[SceneState], Scene]) -> PhysicalProgram: ...


class Verifier(Protocol):
    """V: judges a stage from its evidence against the prompt; never proposes."""

    def judge(self, evidence: Evidence, prompt: str) -> Assessment: ...


class Planner(Protocol):
    """P: proposes edits of just the failed factor."""

    def propose(self, situation: Situation) -> Proposal: ...


class Director(Protocol):
    """Makes an event that holds gentler: proposes lower efforts, or nothing."""

    def ease(self, situation: Situation) -> Proposal: ...


class Reviewer(Protocol):
    """Decides on a proposal; None means that a person is asked, and nobody answering is no."""

    def decide(self, proposal: Proposal, preview: Preview) -> Decision | None: ...
