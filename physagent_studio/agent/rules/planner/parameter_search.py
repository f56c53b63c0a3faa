"""Search along one knob, and over two or three together, on the margins of `trials`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from physagent_studio.agent.rules.planner.parameters import Knob
from physagent_studio.agent.rules.planner.trials import Candidate, Score, Search, better
from physagent_studio.program.edits import Edit

# --- one factor ----------------------------------------------------------------------------------


def along_one(
    search: Search, knob: Knob, signs: Sequence[float], first: tuple[Edit, ...] = (), runs: int = 8
) -> Candidate | None:
    """Goes along one knob: probes, follows the better side by secants, closes in.

    signs: directions that may be tried (+1, −1). Returns the best candidate, or None.
    """
    line = _Line(search, knob, first, search.runs + runs)
    for sign in signs:
        line.try_at(sign)
        if line.holds:
            return line.settled()
    if not line.improves:
        # Farther out, on the side that is less bad; on both where nothing tells them apart.
        for sign in line.likelier(signs):
            line.try_at(3.0 * sign)
            if line.holds:
                return line.settled()
    if not line.improves:
        return line.best
    line.follow()
    return line.settled() if line.holds else line.best


@dataclass
class _Line:
    """The candidates along one knob; `at` is where the best one lies, in strides."""

    search: Search
    knob: Knob
    first: tuple[Edit, ...]
    until: int
    best: Candidate | None = None
    at: float = 0.0
    seen: dict[float, Candidate] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.base = self.search.start().score
        self.score, self.at = self.base, 0.0

    @property
    def holds(self) -> bool:
        return self.best is not None and self.best.score.holds

    @property
    def improves(self) -> bool:
        return self.best is not None and self.best.score < self.base

    @property
    def spent(self) -> bool:
        return self.search.runs >= self.until or self.search.exhausted

    def try_at(self, steps: float) -> Candidate | None:
        """Runs one more; remembers it where it is the best."""
        if self.spent:
            return None
        found = self.search.turn(((self.knob, self.knob.shifted(steps)),), self.first)
        if found is not None:
            self.seen[steps] = found
        if found is not None and (self.best is None or better(found, self.best)):
            self.best, self.at = found, steps
        return found

    def likelier(self, signs: Sequence[float]) -> Sequence[float]:
        """The signs on which the first try did least harm."""
        tried = {sign: self.seen[sign].score for sign in signs if sign in self.seen}
        if len(tried) < 2 or len(set(tried.values())) < 2:
            return signs
        return (min(tried, key=lambda sign: tried[sign]),)

    def follow(self) -> None:
        """Outwards while it gets better, then halving what is left on either side of the best."""
        before, shortfall = 0.0, self.base.shortfall
        while not self.spent and not self.holds and abs(self.at) < 16:
            assert self.best is not None
            here, now = self.at, self.best.score.shortfall
            step = _secant(before, shortfall, here, now)
            self.try_at(step)
            if self.at == here:
                break
            before, shortfall = here, now
        while not self.spent and not self.holds:
            here, known = self.at, len(self.seen)
            for end in self._ends():
                if not self.holds and abs(end - here) > 0.1:
                    self.try_at((here + end) / 2)
                if self.at != here:
                    break
            near = max(abs(end - here) for end in self._ends()) <= 0.1
            # What cannot be run, or was turned down, leaves nothing to close in on.
            if self.at == here and (near or len(self.seen) == known):
                break

    def _ends(self) -> tuple[float, float]:
        """What was tried next to the best, nearer to the start and farther away."""
        inner = max(self._beside(inner=True), key=abs, default=0.0)
        farther = self.at + max(abs(self.at) / 2, 0.4) * (1.0 if self.at > 0 else -1.0)
        return inner, min(self._beside(inner=False), key=abs, default=farther)

    def settled(self) -> Candidate:
        """What holds, made sturdy, or smaller where it is sturdy already, in a few more runs."""
        settle_runs = 3  # count, 1..10: on making sturdy, or smaller, what already holds
        self.until = self.search.runs + (1 if self.search.dear else settle_runs)
        while not self.spent:
            target = self._sturdier() if self._weak else self._smaller()
            if target is None or target in self.seen:
                break
            if self.try_at(target) is None:
                break
        assert self.best is not None
        return self.best

    @property
    def _weak(self) -> bool:
        return self.best is not None and self.best.weakness > 0

    def _smaller(self) -> float | None:
        """Half way back to where it does not hold; None where the change is small."""
        if abs(self.at) <= 1.0:
            return None
        failing = [s for s in self._beside(inner=True) if not self.seen[s].score.holds]
        edge = max(failing, key=abs, default=0.0)
        return (edge + self.at) / 2 if abs(self.at - edge) > 0.5 else None

    def _sturdier(self) -> float:
        """The middle of where it holds; farther out where no end of that is known."""
        inner = [s for s in self._beside(inner=True) if not self.seen[s].score.holds]
        outer = [s for s in self._beside(inner=False) if not self.seen[s].score.holds]
        low = max(inner, key=abs, default=0.0)
        if outer:
            return (low + min(outer, key=abs)) / 2
        return self.at + max(0.6 * abs(self.at - low), 0.3) * (1.0 if self.at > 0 else -1.0)

    def _beside(self, *, inner: bool) -> list[float]:
        """Places on the same side of the line, nearer to the start or farther away."""
        same = [s for s in self.seen if s * self.at > 0]
        return [s for s in same if (abs(s) < abs(self.at)) == inner and s != self.at]


def _secant(x0: float, y0: float, x1: float, y1: float) -> float:
    """Where a shortfall that fell from y0 to y1 would vanish, and a little on; at most doubled."""
    reach = x1 - x0
    guess = x1 + 1.15 * reach * y1 / (y0 - y1) if y0 - y1 > 1e-09 else x1 + reach
    limit = x1 + 2 * reach
    return min(guess, limit) if reach > 0 else max(guess, limit)


# --- two or three factors -------------------------------------------------------------------------


def cross_entropy(
    search: Search,
    knobs: Sequence[Knob],
    seed: int,
    *,
    bias: Callable[[Knob], Sequence[float]] = lambda knob: (1.0, -1.0),
    population: int = 12,
    rounds: int = 5,
    spread: float = 2.5,
) -> Candidate | None:
    """A small seeded cross-entropy search over a few knobs; spread: of the first draw, strides.

    Samples are normal around the best quarter of the last ones (Rubinstein 1999). A whole
    population is drawn before any of it has run.
    """
    rng = np.random.default_rng(seed)
    mean, wide = np.zeros(len(knobs)), np.full(len(knobs), spread)
    best: Candidate | None = None
    for _ in range(rounds):
        if search.exhausted:
            return best
        drawn = mean + wide * rng.standard_normal((population, len(knobs)))
        steps = [
            np.array([_allowed(s, bias(k)) for s, k in zip(row, knobs, strict=True)])
            for row in drawn
        ]
        found = [
            search.turn([(k, k.shifted(float(s))) for k, s in zip(knobs, row, strict=True)])
            for row in steps
        ]
        pairs = [(one, row) for one, row in zip(found, steps, strict=True) if one is not None]
        for one, _ in pairs:
            best = one if best is None or better(one, best) else best
        if best is None or best.score.holds or not pairs:
            return best
        samples: list[tuple[Score, np.ndarray]] = [(one.score, row) for one, row in pairs]
        samples.sort(key=lambda row: row[0])
        elite = np.array([steps for _, steps in samples[: max(population // 4, 2)]])
        mean = 0.7 * elite.mean(axis=0) + 0.3 * mean
        wide = np.maximum(0.7 * elite.std(axis=0) + 0.3 * wide, 0.15)
    return best


def _allowed(steps: float, signs: Sequence[float]) -> float:
    """Mirrors a step into the side that is allowed."""
    if len(signs) == 1:
        return abs(steps) * signs[0]
    return float(steps)
