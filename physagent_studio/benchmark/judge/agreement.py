"""Scores of the methods, and how far the judge agrees with itself when the order is swapped."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.benchmark.judge.judging import Judgement

RESAMPLES, SEED = 2000, 0
"""Of the bootstrap over clips for the interval of a mean score (Efron 1979)."""


@dataclass(frozen=True, slots=True)
class Score:
    """A method's mean score, 0 … 1, with its 95 % interval over clips."""

    method: str
    mean: float
    low: float
    high: float
    clips: int


@dataclass(frozen=True, slots=True)
class Agreement:
    """Of pairs judged in both orders: the judge against itself.

    same: share with the same verdict. kappa: that beyond chance (Cohen 1960), 1 for always, nan
    where every verdict is the same. difference: mean absolute difference of a clip's two scores.
    first: share of decided verdicts for the clip shown first, .5 without a bias.
    """

    pairs: int
    same: float
    kappa: float
    difference: float
    first: float


def scores(judgements: Sequence[Judgement]) -> list[Score]:
    """Mean scores of the methods, the highest first."""
    given: dict[str, dict[str, list[float]]] = {}
    for one in judgements:
        for method, score in ((one.first, one.first_score), (one.second, one.second_score)):
            given.setdefault(method, {}).setdefault(one.clip, []).append(score)
    rng = np.random.default_rng(SEED)
    out = []
    for method in sorted(given):
        means = np.array([np.mean(values) for _, values in sorted(given[method].items())])
        drawn = means[rng.integers(0, len(means), (RESAMPLES, len(means)))].mean(1)
        low, high = np.quantile(drawn, (0.025, 0.975))
        out.append(Score(method, float(means.mean()), float(low), float(high), len(means)))
    return sorted(out, key=lambda score: -score.mean)


def agreement(judgements: Sequence[Judgement]) -> Agreement | None:
    """The judge against itself; None where no pair was judged in both orders."""
    known = {(one.clip, one.first, one.second): one for one in judgements}
    both = [
        (one, known[clip, second, first])
        for (clip, first, second), one in known.items()
        if first < second and (clip, second, first) in known
    ]
    if not both:
        return None
    same = float(np.mean([a.preferred == b.preferred for a, b in both]))
    # Verdicts as `one`, `other` or neither, so that pairs of different methods count alike.
    words = [(_side(a, a), _side(a, b)) for a, b in both]
    shares = [Counter(column) for column in zip(*words, strict=True)]
    chance = sum(shares[0][word] * shares[1][word] for word in shares[0]) / len(both) ** 2
    kappa = (same - chance) / (1 - chance) if chance < 1 else float("nan")
    gaps = [
        abs(x - y)
        for a, b in both
        for x, y in ((a.first_score, b.second_score), (a.second_score, b.first_score))
    ]
    decided = [item for pair in both for item in pair if item.preferred]
    first = float(np.mean([d.preferred == d.first for d in decided])) if decided else 0.5
    return Agreement(len(both), same, kappa, float(np.mean(gaps)), first)


def _side(pair: Judgement, said: Judgement) -> str:
    return {pair.first: "one", pair.second: "other"}.get(said.preferred, "")


def summary(judgements: Sequence[Judgement]) -> list[str]:
    """The figures as lines of Markdown."""
    lines = ["| method | score | 95 % | clips |", "|---|---|---|---|"]
    lines += [
        f"| {s.method} | {s.mean:.3f} | {s.low:.3f} … {s.high:.3f} | {s.clips} |"
        for s in scores(judgements)
    ]
    found = agreement(judgements)
    if found is not None:
        lines += [
            "",
            f"{found.pairs} pairs were judged in both orders: the same verdict in {found.same:.0%}"
            f" (kappa {found.kappa:.2f}), scores differ by {found.difference:.3f}, the clip shown "
            f"first was preferred in {found.first:.0%}.",
        ]
    return lines
