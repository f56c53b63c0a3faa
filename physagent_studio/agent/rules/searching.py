"""Search on the margins: candidate programs are run, counted, and compared.

The objective is lexicographic: how many demanded checks fail, then the sum of their negative
margins. A search starts from the present program and prefers the smallest change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from physagent_studio.agent.roles import Situation, Trial
from physagent_studio.agent.rules.knobs import Knob
from physagent_studio.agent.rules.seen import seen_checks
from physagent_studio.errors import Cancelled, StudioError
from physagent_studio.program.edits import Edit, apply
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records import Check

LIMIT = 200
"""Most candidate runs of one proposal."""


@dataclass(frozen=True, order=True)
class Score:
    """Smaller is better: failing checks, then how badly they fail, rounded against noise."""

    failing: int
    shortfall: float

    @property
    def holds(self) -> bool:
        """Whether everything demanded holds."""
        return self.failing == 0


WORST = Score(10_000, 1e9)


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

    @property
    def change(self) -> float:
        """Size of the change, in strides."""
        return float(sum(knob.distance(value) for knob, value in self.turned)) + 3.0 * (
            len(self.edits) - len(self.turned)
        )


@dataclass
class Search:
    """Runs candidates of one proposal and remembers them; at most `limit` runs."""

    situation: Situation
    limit: int = LIMIT
    runs: int = 0
    best: Candidate | None = None
    _known: dict[str, Candidate | None] = field(default_factory=dict)

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

    def run(
        self, edits: tuple[Edit, ...], turned: tuple[tuple[Knob, float], ...] = ()
    ) -> Candidate | None:
        """Runs the program with edits applied, unless it was run before."""
        if not edits:
            return None
        try:
            program = apply(self.situation.program, edits)
        except StudioError:
            return None
        key = program.hash
        if key in self._known:
            return self._known[key]
        if self.exhausted or key in self.situation.memory.tried:
            return None
        self.runs += 1
        found = self._tried(program, edits, turned)
        self._known[key] = found
        if found is not None and (self.best is None or _better(found, self.best)):
            self.best = found
        return found

    def _tried(
        self,
        program: PhysicalProgram,
        edits: tuple[Edit, ...],
        turned: tuple[tuple[Knob, float], ...],
    ) -> Candidate | None:
        try:
            trial = self.situation.try_out(program)
        except Cancelled:
            raise
        except StudioError:
            return None
        checks = all_checks(program, trial)
        return Candidate(program, edits, score_of(checks), checks, turned)


def all_checks(program: PhysicalProgram, trial: Trial) -> tuple[Check, ...]:
    """The trial's checks with those of what is visible."""
    return (*trial.checks, *seen_checks(program, trial.rollout, trial.checks))


def _better(one: Candidate, other: Candidate) -> bool:
    if one.score.holds and other.score.holds:
        return one.change < other.change
    return one.score < other.score


# --- one factor ----------------------------------------------------------------------------------


def along_one(
    search: Search, knob: Knob, signs: Sequence[float], first: tuple[Edit, ...] = (), runs: int = 10
) -> Candidate | None:
    """Goes along one knob with growing strides, then closes in on the best: bracket and shrink.

    signs: directions that may be tried (+1, −1).
    """
    budget = search.runs + runs
    best: Candidate | None = None
    at = 0.0
    for sign in signs:
        reach = 1.0
        while search.runs < budget and not search.exhausted:
            found = search.turn(((knob, knob.shifted(sign * reach)),), first)
            if found is not None and (best is None or found.score < best.score):
                best, at = found, sign * reach
            elif found is None or (best is not None and found.score > best.score):
                break
            if best is not None and best.score.holds:
                return smallest(search, knob, best, at, first)
            reach *= 2.0
            if abs(reach) > 16:
                break
    return _closed_in(search, knob, best, at, first, budget)


def _closed_in(
    search: Search,
    knob: Knob,
    best: Candidate | None,
    at: float,
    first: tuple[Edit, ...],
    budget: int,
) -> Candidate | None:
    width = max(abs(at) / 2, 0.5)
    while best is not None and not best.score.holds and search.runs < budget and width > 0.05:
        improved = False
        for offset in (at - width, at + width):
            found = search.turn(((knob, knob.shifted(offset)),), first)
            if found is not None and found.score < best.score:
                best, at, improved = found, offset, True
                break
        if not improved:
            width /= 2
    return best


def smallest(
    search: Search, knob: Knob, best: Candidate, at: float, first: tuple[Edit, ...]
) -> Candidate:
    """The change that still suffices, halving it a few times (bisection)."""
    low, high = 0.0, at
    for _ in range(3):
        middle = (low + high) / 2
        found = search.turn(((knob, knob.shifted(middle)),), first)
        if found is not None and found.score.holds:
            best, high = found, middle
        else:
            low = middle
    return best


# --- two or three factors -------------------------------------------------------------------------


def cross_entropy(
    search: Search,
    knobs: Sequence[Knob],
    seed: int,
    *,
    first: tuple[Edit, ...] = (),
    bias: Callable[[Knob], Sequence[float]] = lambda knob: (1.0, -1.0),
    population: int = 12,
    rounds: int = 5,
) -> Candidate | None:
    """A small seeded cross-entropy search over two or three knobs.

    Samples are normal around the best quarter of the last ones (Rubinstein 1999).
    """
    rng = np.random.default_rng(seed)
    mean, spread = np.zeros(len(knobs)), np.full(len(knobs), 2.5)
    best: Candidate | None = None
    for _ in range(rounds):
        samples: list[tuple[Score, np.ndarray]] = []
        for _ in range(population):
            if search.exhausted:
                return best
            steps = mean + spread * rng.standard_normal(len(knobs))
            steps = np.array([_allowed(s, bias(k)) for s, k in zip(steps, knobs, strict=True)])
            values = tuple((k, k.shifted(float(s))) for k, s in zip(knobs, steps, strict=True))
            found = search.turn(values, first)
            if found is None:
                continue
            samples.append((found.score, steps))
            if best is None or found.score < best.score:
                best = found
            if found.score.holds:
                return found
        if not samples:
            return best
        samples.sort(key=lambda row: row[0])
        elite = np.array([steps for _, steps in samples[: max(population // 4, 2)]])
        mean = 0.7 * elite.mean(axis=0) + 0.3 * mean
        spread = np.maximum(0.7 * elite.std(axis=0) + 0.3 * spread, 0.15)
    return best


def _allowed(steps: float, signs: Sequence[float]) -> float:
    """Mirrors a step into the side that is allowed."""
    if len(signs) == 1:
        return abs(steps) * signs[0]
    return float(steps)
