"""Search on the margins: candidate programs are run, counted, and compared.

The objective is lexicographic: how many demanded checks fail, then the sum of their negative
margins. A search starts from the present program and prefers the smallest change.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from physagent_studio.agent.previews import tried
from physagent_studio.agent.roles import Situation, Trial
from physagent_studio.agent.rules.planner.factors import may_change
from physagent_studio.agent.rules.planner.parameters import Knob
from physagent_studio.errors import StudioError
from physagent_studio.program.edits import Edit, apply
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records import Check, Rollout


@dataclass(frozen=True, slots=True)
class TrialSettings:
    """How many programs are tried, and what is sturdy."""

    max_runs: int = 200  # count, 20..1000: of one proposal
    # the statement's measure, 0.01..0.2: from here noise does not matter
    sturdy_margin: float = 0.05


TRIAL = TrialSettings()


@dataclass(frozen=True, order=True)
class Score:
    """Smaller is better: failing checks, then how badly they fail, rounded against noise."""

    failing: int
    shortfall: float

    @property
    def holds(self) -> bool:
        """Whether everything demanded holds."""
        return self.failing == 0


WORST = Score(failing=10_000, shortfall=1e9)


def weakness_of(checks: Iterable[Check]) -> float:
    """How much what holds falls short of sturdy margins; 0 where all of it is sturdy.

    A margin of exactly nothing is that of a count, or of what is not judged: no search moves it.
    """
    held = [c.margin for c in checks if c.demanded and c.ok and not c.always_on]
    short = (TRIAL.sturdy_margin - margin for margin in held if 0 < margin < TRIAL.sturdy_margin)
    return round(sum(short) / TRIAL.sturdy_margin, 4)


def score_of(checks: Iterable[Check]) -> Score:
    """The score of measured checks."""
    failing = [c for c in checks if c.demanded and not c.ok]
    return Score(len(failing), round(sum(min(-c.margin, 20.0) for c in failing), 6))


@dataclass(frozen=True, eq=False)
class Candidate:
    """A program that was run. values: the knobs that were turned, by path."""

    program: PhysicalProgram
    edits: tuple[Edit, ...]
    score: Score
    checks: tuple[Check, ...]
    turned: tuple[tuple[Knob, float], ...] = ()
    rollout: Rollout | None = None

    @property
    def weakness(self) -> float:
        """How far its margins are from sturdy ones; 0 where all are."""
        return weakness_of(self.checks)

    @property
    def change(self) -> float:
        """Size of the change, in strides."""
        return float(sum(knob.distance(value) for knob, value in self.turned)) + 3.0 * (
            len(self.edits) - len(self.turned)
        )


@dataclass
class Search:
    """Runs candidates of one proposal and remembers them; at most `limit` runs.

    dear: a run costs so much that none is spent on niceties.
    """

    situation: Situation
    limit: int = TRIAL.max_runs
    runs: int = 0
    dear: bool = False
    best: Candidate | None = None
    _known: dict[str, Candidate | None] = field(default_factory=dict)
    _ahead: dict[str, Trial | None] = field(default_factory=dict)
    _rejected: frozenset[str] | None = None

    @property
    def exhausted(self) -> bool:
        """Whether no run is left."""
        return self.runs >= self.limit

    def start(self) -> Candidate:
        """The present program with the checks that the verifier has seen."""
        checks = self.situation.assessment.checks
        program = self.situation.program
        return Candidate(program, (), score_of(checks), checks)

    def turn(
        self, values: Sequence[tuple[Knob, float]], first: tuple[Edit, ...] = ()
    ) -> Candidate | None:
        """Runs the program with knobs turned; None where it cannot be run or may not."""
        edits = (*first, *(edit for knob, value in values for edit in knob.edits(value)))
        return self.run(edits, tuple(values))

    def turn_all(self, many: Sequence[tuple[tuple[Knob, float], ...]]) -> list[Candidate | None]:
        """`turn` of each, in order; what has to be run for that is run side by side."""
        if self.situation.try_all is not None:
            wanted = dict[str, PhysicalProgram]()
            for values in many:
                edits = tuple(edit for knob, value in values for edit in knob.edits(value))
                program = self._changed(edits)
                if program is not None and self._is_new(program.hash):
                    wanted[program.hash] = program
            chosen = list(wanted.values())[: self.limit - self.runs]
            trials = self.situation.try_all(chosen)
            self._ahead = {one.hash: trial for one, trial in zip(chosen, trials, strict=True)}
        return [self.turn(values) for values in many]

    def run(
        self, edits: tuple[Edit, ...], turned: tuple[tuple[Knob, float], ...] = ()
    ) -> Candidate | None:
        """Runs the program with edits applied, unless it was run before or they touch a pin."""
        if (program := self._changed(edits)) is None:
            return None
        key = program.hash
        if key in self._known:
            return self._known[key]
        if self.exhausted or not self._is_new(key):
            return None
        self.runs += 1
        found = self._tried(program, edits, turned)
        self._known[key] = found
        if found is not None and (self.best is None or better(found, self.best)):
            self.best = found
        return found

    def _changed(self, edits: tuple[Edit, ...]) -> PhysicalProgram | None:
        """The program with edits applied; None where they may not be, or make none."""
        if not edits or not may_change(self.situation, edits):
            return None
        try:
            return apply(self.situation.program, edits)
        except StudioError:
            return None

    def _is_new(self, key: str) -> bool:
        """Whether nobody has run that program, or turned it down."""
        tried = key in self._known or key in self.situation.memory.tried
        return not tried and key not in self._turned_down()

    def _turned_down(self) -> frozenset[str]:
        """Hashes of the programs that rejected proposals would have made."""
        if self._rejected is None:
            found = set()
            for proposal, _ in self.situation.memory.rejected:
                try:
                    found.add(apply(self.situation.program, proposal.edits).hash)
                except StudioError:
                    continue
            self._rejected = frozenset(found)
        return self._rejected

    def _tried(
        self,
        program: PhysicalProgram,
        edits: tuple[Edit, ...],
        turned: tuple[tuple[Knob, float], ...],
    ) -> Candidate | None:
        if program.hash in self._ahead:
            trial = self._ahead.pop(program.hash)
        else:
            trial = tried(self.situation.try_out, program)
        if trial is None:
            return None
        checks = trial.checks
        return Candidate(program, edits, score_of(checks), checks, turned, trial.rollout)


def better(one: Candidate, other: Candidate) -> bool:
    """Whether the first is to be kept: sturdier, then smaller, where both hold."""
    if one.score.holds and other.score.holds:
        return (one.weakness, one.change) < (other.weakness, other.change)
    return one.score < other.score
