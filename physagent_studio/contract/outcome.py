"""What measuring one statement gives, before it becomes a `Check`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

LIMIT = 100.0
"""Margins are kept within ± this, so that a sum of them stays meaningful."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The plain (not negated) statement, measured.

    margin: signed, ≥ 0 holds. op: how `value` must compare with `threshold`; "" where the
    statement is a yes or no. step: when it was decided (became true, or failed). note: what an
    English reader wants beside it. lasting: the verdict speaks of the end of the window, so a
    run that ended early cannot give it. measurable: False when there was nothing to measure.
    claim: the statement's words where they depend on what was measured.
    """

    margin: float
    value: float | None = None
    threshold: float | None = None
    unit: str = ""
    op: str = ""
    step: int | None = None
    note: str = ""
    claim: str = ""
    lasting: bool = False
    measurable: bool = True

    @property
    def holds(self) -> bool:
        """Whether the plain statement is true."""
        return self.margin >= 0


def unmeasurable(reason: str, step: int | None = None) -> Outcome:
    """Nothing could be measured: the statement fails, and its opposite as well."""
    return Outcome(margin=-1.0, note=reason, step=step, measurable=False)


def bounded(margin: float) -> float:
    """The margin within ± `LIMIT`."""
    return float(max(-LIMIT, min(LIMIT, margin)))


def opposite(margin: float) -> float:
    """The margin of the opposite; a statement that just holds leaves its opposite just failed."""
    return -margin if margin != 0 else -1e-9


def excess(value: float, threshold: float, floor: float = 1e-3) -> float:
    """Margin of value ≥ threshold, relative to the threshold."""
    return bounded((value - threshold) / max(abs(threshold), floor))


def shortfall(value: float, threshold: float, floor: float = 1e-3) -> float:
    """Margin of value ≤ threshold, relative to the threshold."""
    return bounded((threshold - value) / max(abs(threshold), floor))


def slowness(value: float, threshold: float) -> float:
    """Margin of value ≤ threshold for speeds over many scales, within −1 … 1."""
    total = value + threshold
    return (threshold - value) / total if total > 0 else 1.0


def worst(outcomes: Sequence[Outcome]) -> Outcome:
    """The one with the least margin, the first of equals."""
    return min(outcomes, key=lambda one: one.margin)
