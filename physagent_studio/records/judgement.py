"""What is measured, said, proposed and decided: `Check` … `Decision`, as plain data."""

import hashlib
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program.base import Frozen
from physagent_studio.program.edits import Edit, Hunk
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records.case import Image
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.scene import Scene

Stage = Literal["reconstruction", "simulation"]
CRITERIA = ("object trajectory", "contact timing", "force direction", "material response")
"""The paper's four criteria of stage 2."""


class Check(Frozen):
    """One statement measured. margin: signed, ≥ 0 holds, in units of the threshold's scale.

    margin is continuous where the physics is, so that a search can follow it even while the
    statement fails (a miss by 0.31 m has margin −0.31 over its scale). step: when it was decided.
    demanded: False for a statement that only serves a composite; it counts through that alone.
    """

    id: str
    text: str
    ok: bool
    measured: float | None
    threshold: float | None
    unit: str
    margin: float
    step: int | None = None
    clause: str | None = None
    kind: str = ""
    always_on: bool = False
    demanded: bool = True


class Mismatch(Frozen):
    """What went wrong, in words and figures, never the remedy.

    code: stable word for planners, such as `misses`, `too_slow`, `falls_short`, `overshoots`,
    `no_contact`, `unwanted_contact`, `not_toppled`, `toppled`, `moved`, `blow_up`.
    """

    code: str
    text: str
    subject: str = ""
    other: str = ""
    check: str = ""
    figures: dict[str, float] = Field(default_factory=dict)
    step: int | None = None


class Criterion(Frozen):
    """One of the paper's criteria with its verdict and reason."""

    name: str
    ok: bool
    reason: str


class Assessment(Frozen):
    """A verifier's verdict on one stage. `diagnosis` never says what to change.

    clauses: the verdict on each clause of the prompt, where a verifier gives one. contradiction:
    where a verdict and the measured facts disagree, how; such a stage does not pass.
    """

    stage: Stage
    passed: bool
    checks: tuple[Check, ...] = ()
    criteria: tuple[Criterion, ...] = ()
    diagnosis: tuple[Mismatch, ...] = ()
    untested: tuple[str, ...] = ()
    author: str = "rules"
    clauses: tuple[Criterion, ...] = ()
    contradiction: str = ""

    @property
    def score(self) -> float:
        """Sum of capped margins; larger is better, ≥ 0 only when all hold."""
        return sum(min(check.margin, 0.0) for check in self.checks if check.demanded)

    @property
    def seen_to_move(self) -> bool:
        """Whether what the sentence has move does so in the picture; no where nothing shall."""
        return any(check.ok for check in self.checks if check.id == "view.something")

    @property
    def realised(self) -> int:
        """How many checks hold."""
        return sum(check.ok for check in self.checks if check.demanded)


class Proposal(Frozen):
    """The planner's structured edits. `simulations`: candidate runs that its search cost.

    contradiction: of the assessment that it answers, for whoever decides.
    touches_pinned: paths that a person has pinned and that it would change all the same.
    understood: what a person's newest words were taken to ask for. meant: what they could ask for
    where that is open: what stands on a button, and the words that it says; "" leads to the photo.
    """

    id: str
    hunks: tuple[Hunk, ...]
    rationale: str
    factor: str
    confidence: float
    simulations: int = 0
    touches_verified: bool = False
    question: str = ""
    author: str = "rules"
    contradiction: str = ""
    touches_pinned: tuple[str, ...] = ()
    understood: str = ""
    meant: tuple[tuple[str, str], ...] = ()

    @property
    def edits(self) -> tuple[Edit, ...]:
        """All edits in order."""
        return tuple(edit for hunk in self.hunks for edit in hunk.edits)


class Preview(Frozen):
    """What trying a proposal out showed; not a round. rollout: key in the session's files."""

    program: PhysicalProgram | None
    checks: tuple[Check, ...] = ()
    passed: bool = False
    rollout: str | None = None
    problem: str = ""


DecisionKind = Literal[
    "accept", "accept_hunks", "override", "edit", "reject", "hint", "skip", "stop"
]


class Decision(Frozen):
    """What was decided on a proposal, by whom, when and why.

    edits: what is applied to the program (empty for reject, hint, skip and stop).
    at: ISO 8601, UTC. evidence: hash of what the decider was shown.
    """

    kind: DecisionKind
    author: str
    at: str
    reason: str = ""
    hunks: tuple[str, ...] = ()
    edits: tuple[Edit, ...] = ()
    before: str = ""
    after: str = ""
    evidence: str = ""


class Override(Frozen):
    """A person's verdict on a stage, beside the machine's."""

    passed: bool
    author: str
    at: str
    words: str = ""
    stage: Stage = "simulation"


class Round(Frozen):
    """One round, immutable. parent: the round it grew from; None for the first.

    rollout, scene, frames: keys in the session's files (frames: the 27 of stage 2).
    origin: the decision that made its program; decision: the last one on its own proposal;
    rejected: proposals that were turned down here, each with its decision.
    simulations: engine runs of this round, its planner's search included. author: who wrote
    its program.
    """

    id: str
    number: int
    parent: str | None
    program: PhysicalProgram
    author: str
    scene: str | None = None
    rollout: str | None = None
    frames: str | None = None
    assessment: Assessment | None = None
    origin: Decision | None = None
    override: Override | None = None
    proposal: Proposal | None = None
    preview: Preview | None = None
    decision: Decision | None = None
    rejected: tuple[tuple[Proposal, Decision], ...] = ()
    simulations: int = 0

    @property
    def ruling(self) -> Override | None:
        """A person's verdict on the stage that was judged last."""
        a, said = self.assessment, self.override
        return said if a is not None and said is not None and said.stage == a.stage else None

    @property
    def passed(self) -> bool:
        """Whether stage 2 holds, a person's word going first."""
        return self._holds("simulation")

    @property
    def scene_holds(self) -> bool:
        """Whether stage 1 was judged last and holds, a person's word going first."""
        return self._holds("reconstruction")

    def _holds(self, stage: Stage) -> bool:
        if self.assessment is None or self.assessment.stage != stage:
            return False
        return self.ruling.passed if self.ruling else self.assessment.passed

    @property
    def evidence(self) -> str:
        """SHA-256 of what a decision on this round was made from.

        The scene, the rollout and its frames by their content, the measured facts, and what
        the proposal's trial gave.
        """
        digest = hashlib.sha256()
        for part in (self.scene, self.rollout, self.frames, self.assessment, self.preview):
            text = part.model_dump_json() if isinstance(part, Frozen) else part or ""
            digest.update(text.encode() + b"\n")
        return digest.hexdigest()


class MemoryEntry(Frozen):
    """What one round taught: what was edited, why, and what came of it."""

    round: str
    factor: str
    rationale: str
    edits: tuple[Edit, ...]
    decided: str
    reason: str
    margins_before: dict[str, float]
    margins_after: dict[str, float]


class Lesson(Frozen):
    """What one decided change taught, told without the scene that it came from.

    mismatch: code of the worst one before. factor: what was changed. failing_before, _after:
    demanded checks that failed. reason: a person's words, where there were some.
    """

    mismatch: Annotated[str, Field(min_length=1, max_length=60)]
    factor: Annotated[str, Field(min_length=1, max_length=60)]
    decided: DecisionKind
    failing_before: Annotated[int, Field(ge=0, le=10_000)]
    failing_after: Annotated[int, Field(ge=0, le=10_000)] | None = None
    reason: Annotated[str, Field(max_length=500)] = ""

    @property
    def helped(self) -> bool:
        """Whether less failed afterwards; what was turned down did not help."""
        return self.failing_after is not None and self.failing_after < self.failing_before


class Memory(Frozen):
    """What the planner knows of earlier rounds. pinned: paths that the agent never changes.

    verified: paths that a passed stage vouches for; changed last, and only saying so.
    tried: hashes of programs that were already run. hints: a person's words, newest last.
    lessons: of earlier sessions. said: a person's words since the last proposal, with a rejection,
    as a hint or with a verdict; "" where none were said.
    """

    entries: tuple[MemoryEntry, ...] = ()
    pinned: tuple[str, ...] = ()
    verified: tuple[str, ...] = ()
    tried: tuple[str, ...] = ()
    hints: tuple[str, ...] = ()
    rejected: tuple[tuple[Proposal, str], ...] = ()
    lessons: tuple[Lesson, ...] = ()
    said: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class SceneEvidence:
    """Stage 1: the scene with its findings, and its rendered view beside the photo."""

    program: PhysicalProgram
    scene: Scene
    view: Image | None


@dataclass(frozen=True, eq=False, slots=True)
class RolloutEvidence:
    """Stage 2: measured facts and every third frame (x1, x4 … x79 of the paper).

    checks: the contract and the always-on physical checks, measured. frames: 27 images, or
    empty where nothing was rendered.
    """

    program: PhysicalProgram
    scene: Scene
    rollout: Rollout
    checks: tuple[Check, ...]
    frames: tuple[Image, ...] = ()


Evidence = SceneEvidence | RolloutEvidence
