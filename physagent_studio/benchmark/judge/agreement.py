"""Scores of the methods, and how far the judge agrees with itself when the order is swapped."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.benchmark.judge.judging import Judgement


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


def scores(judgements: Sequence[Judgement]) -> dict[str, tuple[float, float, int]]:
    """Mean score of each method, 0 … 1, its standard error over clips, and their number."""
    given: dict[str, dict[str, list[float]]] = {}
    for one in judgements:
        for method, score in ((one.first, one.first_score), (one.second, one.second_score)):
            given.setdefault(method, {}).setdefault(one.clip, []).append(score)
    out = {}
    for method in sorted(given):
        means = [float(np.mean(values)) for values in given[method].values()]
        error = float(np.std(means, ddof=1) / len(means) ** 0.5) if len(means) > 1 else 0.0
        out[method] = (float(np.mean(means)), error, len(means))
    return out


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
    words = [
        [{a.first: "one", a.second: "other"}.get(x.preferred) for x in (a, b)] for a, b in both
    ]
    shares = [Counter(column) for column in zip(*words, strict=True)]
    chance = sum(shares[0][word] * shares[1][word] for word in shares[0]) / len(both) ** 2
    kappa = (same - chance) / (1 - chance) if chance < 1 else float("nan")
    gaps = [abs(a.first_score - b.second_score) for a, b in both]
    gaps += [abs(a.second_score - b.first_score) for a, b in both]
    decided = [item for pair in both for item in pair if item.preferred]
    first = float(np.mean([d.preferred == d.first for d in decided])) if decided else 0.5
    return Agreement(len(both), same, kappa, float(np.mean(gaps)), first)


def summary(judgements: Sequence[Judgement]) -> list[str]:
    """The figures as lines of Markdown."""
    lines = ["| method | score | ± | clips |", "|---|---|---|---|"]
    for method, (mean, error, count) in scores(judgements).items():
        lines.append(f"| {method} | {mean:.3f} | {error:.3f} | {count} |")
    found = agreement(judgements)
    if found is None:
        return lines
    return [
        *lines,
        "",
        f"{found.pairs} pairs were judged in both orders: the same verdict in {found.same:.0%} "
        f"(kappa {found.kappa:.2f}), scores differ by {found.difference:.3f}, the clip shown first "
        f"was preferred in {found.first:.0%}.",
    ]
