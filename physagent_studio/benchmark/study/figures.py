"""What the answers of a study amount to: shares with intervals, strengths, raters and sides.

A pair's share is exact binomial (Clopper and Pearson 1934). A strength is fitted for each method so
that answers follow Bradley and Terry (1952), with the intervals of the normal approximation at the
maximum.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import log_expit
from scipy.stats import binomtest, norm

from physagent_studio.arrays import FloatArray
from physagent_studio.benchmark.study.answers import Answer

CONFIDENCE = 0.95
HELD = 0.75
"""Share of the catch trials that a rater has to answer rightly to be counted."""
PRIOR = 0.05
"""Weight of the pull of strengths to 0, in answers: who always wins has none without it."""


@dataclass(frozen=True, slots=True)
class Pair:
    """How often `one` was chosen over `other`: the interval of its share, p of no preference."""

    one: str
    other: str
    wins: int
    count: int
    low: float
    high: float
    p: float

    @property
    def share(self) -> float:
        """Part of the answers that chose `one`."""
        return self.wins / self.count


@dataclass(frozen=True, slots=True)
class Strength:
    """A method's Bradley-Terry strength, natural logarithm, mean 0 over the methods."""

    method: str
    value: float
    low: float
    high: float


def counted(answers: Sequence[Answer]) -> tuple[list[Answer], list[str]]:
    """The answers to true pairs by raters who saw what was blank, and the raters left out."""
    left_out = []
    for rater in sorted({answer.rater for answer in answers}):
        caught = [answer for answer in answers if answer.rater == rater and answer.catch]
        if caught and sum(bool(a.chosen) for a in caught) < HELD * len(caught):
            left_out.append(rater)
    return [a for a in answers if not a.catch and a.rater not in left_out], left_out


def pairs(answers: Sequence[Answer]) -> list[Pair]:
    """Every pair of methods that was asked for."""
    out = []
    methods = sorted({name for a in answers for name in (a.left, a.right)})
    for one, other in itertools.combinations(methods, 2):
        mine = [a for a in answers if {a.left, a.right} == {one, other}]
        if mine:
            wins = sum(a.chosen == one for a in mine)
            test = binomtest(wins, len(mine))
            bounds = test.proportion_ci(CONFIDENCE, "exact")
            pair = (one, other, wins, len(mine), bounds.low, bounds.high, test.pvalue)
            out.append(Pair(pair[0], pair[1], pair[2], pair[3], *(float(v) for v in pair[4:])))
    return out


def strengths(answers: Sequence[Answer]) -> list[Strength]:
    """Bradley-Terry strengths of all methods, the strongest first."""
    methods = sorted({name for a in answers for name in (a.left, a.right)})
    if len(methods) < 2:
        return []
    number = {name: k for k, name in enumerate(methods)}
    won = np.array([number[a.chosen] for a in answers])
    lost = np.array([number[a.other] for a in answers])

    def cost(values: FloatArray) -> float:
        pull = PRIOR * np.square(values).sum() / 2
        return float(pull - log_expit(values[won] - values[lost]).sum())

    found = minimize(cost, np.zeros(len(methods)), method="BFGS").x
    found = found - found.mean()
    spread = norm.ppf((1 + CONFIDENCE) / 2) * np.sqrt(np.diag(_covariance(found, won, lost)))
    rows = [
        Strength(name, float(v), float(v - s), float(v + s))
        for name, v, s in zip(methods, found, spread, strict=True)
    ]
    return sorted(rows, key=lambda row: -row.value)


def _covariance(values: FloatArray, won: np.ndarray, lost: np.ndarray) -> FloatArray:
    """(M, M) of strengths whose mean is 0: the pseudo-inverse of the information."""
    chance = 1 / (1 + np.exp(values[lost] - values[won]))
    weight = chance * (1 - chance)
    information = np.zeros((len(values), len(values)))
    for one, other, sign in ((won, won, 1), (lost, lost, 1), (won, lost, -1), (lost, won, -1)):
        np.add.at(information, (one, other), sign * weight)
    return np.asarray(np.linalg.pinv(information), np.float64)


def summary(answers: Sequence[Answer]) -> list[str]:
    """The figures as lines of Markdown."""
    good, left_out = counted(answers)
    raters = {answer.rater for answer in good}
    lines = [f"{len(good)} answers of {len(raters)} raters count."]
    if left_out:
        lines.append(f"Left out, for they chose blank sides: {', '.join(left_out)}.")
    if not good:
        return lines
    side = binomtest(sum(a.choice == "left" for a in good), len(good))
    lines += [f"The left side was chosen in {side.statistic:.0%} (p = {side.pvalue:.2g}).", ""]
    lines += ["| chosen | over | share | 95 % | answers | p |", "|---|---|---|---|---|---|"]
    lines += [
        f"| {p.one} | {p.other} | {p.share:.3f} | {p.low:.3f} … {p.high:.3f} | {p.count} "
        f"| {p.p:.2g} |"
        for p in pairs(good)
    ]
    lines += ["", "| method | Bradley-Terry strength | 95 % |", "|---|---|---|"]
    return lines + [
        f"| {row.method} | {row.value:+.2f} | {row.low:+.2f} … {row.high:+.2f} |"
        for row in strengths(good)
    ]
