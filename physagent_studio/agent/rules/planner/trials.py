"""Search on the margins: candidate programs are run, counted, and compared.

The objective is lexicographic: how many demanded checks fail, then the sum of their negative
margins. A search starts from the present program and prefers the smallest change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import TypeVar

from physagent_studio.agent.previews import tried
from physagent_studio.agent.roles import Situation
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
    foreseen_runs: int = 12  # count, 1..16: of what is asked for next, begun where cores are free
    dreamt_runs: int = 30  # count, 4..64: how far a search is played through for that
    # ratio, 0.5..1: of the least shortfall so far, that a guess has that gets better
    guessed_ratio: float = 0.9


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


Found = TypeVar("Found")


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
    _changed: dict[str, tuple[PhysicalProgram, str] | None] = field(default_factory=dict)
    _rejected: frozenset[str] | None = None
    _foreseen: Callable[[], Sequence[PhysicalProgram]] = tuple
    _rises: bool = False

    @property
    def exhausted(self) -> bool:
        """Whether no run is left."""
        return self.runs >= self.limit

    def start(self) -> Candidate:
        """The present program with the checks that the verifier has seen."""
        checks = self.situation.assessment.checks
        program = self.situation.program
        return Candidate(program, (), score_of(checks), checks)

    def carry_out(self, plan: Callable[[Search], Found]) -> Found:
        """What the plan finds, a function of nothing but the answers that it gets.

        Where cores have nothing to do, what it is likely to ask for next is begun there.
        """
        if self.situation.ahead is None:
            return plan(self)
        self._turned_down()
        self._foreseen = partial(_coming, replace(self, _known=dict(self._known)), self, plan)
        try:
            return plan(self)
        finally:
            self._foreseen = tuple
            self.situation.ahead.give_up()

    def turn(
        self, values: Sequence[tuple[Knob, float]], first: tuple[Edit, ...] = ()
    ) -> Candidate | None:
        """Runs the program with knobs turned; None where it cannot be run or may not."""
        edits = (*first, *(edit for knob, value in values for edit in knob.edits(value)))
        return self.run(edits, tuple(values))

    def run(
        self, edits: tuple[Edit, ...], turned: tuple[tuple[Knob, float], ...] = ()
    ) -> Candidate | None:
        """Runs the program with edits applied, unless it was run before or they touch a pin."""
        if (changed := self._change(edits)) is None:
            return None
        program, key = changed
        if key in self._known:
            return self._known[key]
        if self.exhausted or key in self.situation.memory.tried or key in self._turned_down():
            return None
        self.runs += 1
        found = self._found(program, key, edits, turned)
        self._known[key] = found
        self._note(found)
        return found

    def _note(self, found: Candidate | None) -> None:
        """Remembers what is best, and whether the last one was."""
        self._rises = found is not None and (self.best is None or better(found, self.best))
        if self._rises:
            self.best = found

    def _change(self, edits: tuple[Edit, ...]) -> tuple[PhysicalProgram, str] | None:
        """The program with edits applied and its hash; None where they may not be, or make none."""
        asked = repr(edits)
        if asked not in self._changed:
            self._changed[asked] = None
            if edits and may_change(self.situation, edits):
                with suppress(StudioError):
                    program = apply(self.situation.program, edits)
                    self._changed[asked] = program, program.hash
        return self._changed[asked]

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

    def _found(
        self,
        program: PhysicalProgram,
        key: str,
        edits: tuple[Edit, ...],
        turned: tuple[tuple[Knob, float], ...],
    ) -> Candidate | None:
        """What a program that nobody has run does; None where it cannot run. key: its hash."""
        ahead, try_out = self.situation.ahead, self.situation.try_out
        trial = tried(partial(ahead.take, then=self._foreseen) if ahead else try_out, program)
        if trial is None:
            return None
        checks = trial.checks
        return Candidate(program, edits, score_of(checks), checks, turned, trial.rollout)


def better(one: Candidate, other: Candidate) -> bool:
    """Whether the first is to be kept: sturdier, then smaller, where both hold."""
    if one.score.holds and other.score.holds:
        return (one.weakness, one.change) < (other.weakness, other.change)
    return one.score < other.score


# --- what is asked for next -----------------------------------------------------------------------


class _FarEnoughError(Exception):
    """A search was played through as far as it is of use."""


@dataclass
class _Dream(Search):
    """A search that is played through: what has been run answers, what has not is guessed.

    A guess is that nothing changes, or where `hopes` that each is a little better than the best.
    coming: the edits of what was guessed, in the order in which it was asked for.
    """

    hopes: bool = False
    answers: dict[str, Candidate | None] = field(default_factory=dict)
    coming: list[tuple[Edit, ...]] = field(default_factory=list)
    _guessed: dict[str, Candidate] = field(default_factory=dict)

    def run(
        self, edits: tuple[Edit, ...], turned: tuple[tuple[Knob, float], ...] = ()
    ) -> Candidate | None:
        """See `Search.run`; a turned number is guessed at without making the program."""
        asked = repr(edits)
        if not turned or asked in self._changed:
            return super().run(edits, turned)
        if asked not in self._guessed and not self.exhausted:
            self.runs += 1
            found = self._guessed[asked] = self._guess(self.situation.program, edits, turned)
            self._note(found)
        return self._guessed.get(asked)

    def _found(
        self,
        program: PhysicalProgram,
        key: str,
        edits: tuple[Edit, ...],
        turned: tuple[tuple[Knob, float], ...],
    ) -> Candidate | None:
        known = key in self.answers
        return self.answers[key] if known else self._guess(program, edits, turned)

    def _guess(
        self,
        program: PhysicalProgram,
        edits: tuple[Edit, ...],
        turned: tuple[tuple[Knob, float], ...],
    ) -> Candidate:
        if len(self.coming) > TRIAL.dreamt_runs:
            raise _FarEnoughError
        self.coming.append(edits)
        guess = self.start()
        score = guess.score
        if self.hopes:
            score = min(score, self.best.score) if self.best is not None else score
            score = Score(score.failing, TRIAL.guessed_ratio * score.shortfall)
        return replace(guess, program=program, edits=edits, turned=turned, score=score)


def _coming(
    begun: Search, now: Search, plan: Callable[[Search], object]
) -> Sequence[PhysicalProgram]:
    """What a plan asks for from here on, likeliest first.

    Along one number each step follows from the answers to those before: what has got better goes
    on to do so, and what has not does not. After one such guess comes what is asked for whatever
    the answers are, such as the first steps along the next number.
    """
    same, hoped = (_dreamt(begun, now, plan, hopes) for hopes in (False, True))
    lead, sure = hoped if now._rises else same, {*map(repr, same)} & {*map(repr, hoped)}
    first = 2 if now._rises else 1
    likeliest = lead[:first] + sorted(lead[first:], key=lambda edits: repr(edits) not in sure)
    changed = (begun._change(edits) for edits in likeliest[: TRIAL.foreseen_runs + 1])
    return [one[0] for one in changed if one is not None]


def _dreamt(
    begun: Search, now: Search, plan: Callable[[Search], object], hopes: bool
) -> list[tuple[Edit, ...]]:
    """What a plan asks for if the answers that it waits for are all alike, see `_Dream`."""
    own = {f.name: getattr(begun, f.name) for f in fields(Search)}
    dream = _Dream(**own, answers=now._known, hopes=hopes)
    dream._known = dict(begun._known)
    # What goes wrong here is no answer to what is waited for; it will go wrong in earnest as well.
    with suppress(_FarEnoughError, StudioError):
        plan(dream)
    return dream.coming
