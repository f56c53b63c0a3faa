"""What the answers of a study amount to: exact binomial shares (Clopper and Pearson 1934)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from scipy.stats import binomtest

from physagent_studio.benchmark.study.answers import Answer

CONFIDENCE = 0.95
HELD = 0.75
"""Share of the catch trials that a rater has to answer rightly to be counted."""


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
            ends = test.proportion_ci(CONFIDENCE, "exact")
            figures = (float(ends.low), float(ends.high), float(test.pvalue))
            out.append(Pair(one, other, wins, len(mine), *figures))
    return out


def summary(answers: Sequence[Answer]) -> list[str]:
    """The figures as lines of Markdown."""
    good, left_out = counted(answers)
    lines = [f"{len(good)} answers of {len({a.rater for a in good})} raters count."]
    if left_out:
        lines.append(f"Left out, for they chose blank sides: {', '.join(left_out)}.")
    if not good:
        return lines
    side = binomtest(sum(a.choice == "left" for a in good), len(good))
    lines += [f"The left side was chosen in {side.statistic:.0%} (p = {side.pvalue:.2g}).", ""]
    lines += ["| chosen | over | share | 95 % | answers | p |", "|---|---|---|---|---|---|"]
    return lines + [
        f"| {p.one} | {p.other} | {p.share:.3f} | {p.low:.3f} … {p.high:.3f} | {p.count} "
        f"| {p.p:.2g} |"
        for p in pairs(good)
    ]
