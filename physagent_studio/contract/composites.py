"""Measures of statements about other statements: counts, alternatives, order in time."""

import itertools

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.track import Outcome, bounded, opposite, unmeasurable
from physagent_studio.program import contract


def composed(statement: contract.Composite, parts: list[Outcome], facts: Facts) -> Outcome:
    """The outcome of a composite from those of its parts, in their order."""
    match statement:
        case contract.Before():
            return _before(parts[0], parts[1], statement.within, facts)
        case contract.CountOf():
            return _count(parts, statement.low, statement.high)
        case contract.InTurn():
            return _in_turn(parts, statement.apart, statement.ordered, facts)
        case contract.Together():
            return _together(parts, statement.within, facts)
        case contract.AllOf():
            return _all(parts)
        case contract.AnyOf():
            return _any(parts)


def _all(parts: list[Outcome]) -> Outcome:
    least = min(parts, key=lambda one: one.margin)
    steps = [one.step for one in parts if one.step is not None]
    step = max(steps, default=None) if least.holds else least.step
    measurable = any(not one.holds and one.measurable for one in parts) or least.measurable
    return Outcome(least.margin, step=step, note=least.note, measurable=measurable)


def _any(parts: list[Outcome]) -> Outcome:
    most = max(parts, key=lambda one: one.margin)
    steps = [one.step for one in parts if one.holds and one.step is not None]
    step = min(steps, default=most.step)
    measurable = most.holds or all(one.measurable for one in parts)
    return Outcome(most.margin, step=step, note=most.note, measurable=measurable)


def _count(parts: list[Outcome], low: int, high: int) -> Outcome:
    """The margin of the part that would have to turn first for the count to be wrong."""
    margins = sorted((one.margin for one in parts), reverse=True)
    enough = 1.0 if low == 0 else margins[low - 1] if low <= len(margins) else -1.0
    not_more = opposite(margins[high]) if high < len(margins) else 1.0
    count = sum(one.holds for one in parts)
    steps = [one.step for one in parts if one.step is not None]
    measurable = all(one.measurable for one in parts)
    margin = min(enough, not_more) if measurable else min(enough, not_more, -1e-9)
    note = f"{count} of {len(parts)}"
    return Outcome(
        margin,
        float(count),
        float(low if enough <= not_more else high),
        step=max(steps, default=None),
        note=note,
        lasting=True,
        measurable=measurable,
    )


def _before(first: Outcome, second: Outcome, within: float | None, facts: Facts) -> Outcome:
    """Seconds from the first to the second, over the clip; a part that fails comes before all."""
    seconds = max(facts.rollout.steps * facts.dt, facts.dt)
    failing = [one for one in (first, second) if not one.holds]
    if failing:
        which = "the first" if not first.holds else "the second"
        return _never(failing, f"{which} does not happen")
    if first.step is None or second.step is None:
        return unmeasurable("when one of them happened is not known")
    lead = (second.step - first.step) * facts.dt
    margin = (lead - facts.dt / 2) / seconds
    if within is not None:
        margin = min(margin, (within - lead) / max(within, facts.dt))
    note = f"{abs(lead):.2f} s {'earlier' if lead > 0 else 'later'}" if lead else "at the same time"
    return Outcome(margin, lead, 0.0, "s", "", step=second.step, note=note)


def _never(failing: list[Outcome], note: str) -> Outcome:
    """What has an order in time does not all happen."""
    margin = bounded(sum(one.margin for one in failing)) - 1.0
    measurable = all(one.measurable for one in failing)
    return Outcome(margin, note=note, measurable=measurable, step=failing[0].step)


def _moments(parts: list[Outcome], facts: Facts) -> list[float] | Outcome:
    """When each part was decided, s; or why that cannot be told."""
    failing = [one for one in parts if not one.holds]
    if failing:
        return _never(failing, f"{len(failing)} of {len(parts)} do not happen")
    found = [one.step * facts.dt for one in parts if one.step is not None]
    return found if len(found) == len(parts) else unmeasurable("when one of them happened is open")


def _in_turn(parts: list[Outcome], apart: float, ordered: bool, facts: Facts) -> Outcome:
    """Seconds between two that follow each other, the least of them."""
    moments = _moments(parts, facts)
    if isinstance(moments, Outcome):
        return moments
    pairs = itertools.pairwise(moments if ordered else sorted(moments))
    gaps = [later - earlier for earlier, later in pairs]
    least, last = min(gaps), round(max(moments) / facts.dt)
    margin = bounded((least - apart) / max(apart, facts.dt))
    note = f"two are {abs(least):.2f} s apart" if least >= 0 else "two are the other way round"
    return Outcome(margin, least, apart, "s", "", last, note)


def _together(parts: list[Outcome], within: float, facts: Facts) -> Outcome:
    """Seconds from the first of them to the last."""
    moments = _moments(parts, facts)
    if isinstance(moments, Outcome):
        return moments
    lead = max(moments) - min(moments)
    last = round(max(moments) / facts.dt)
    note = f"{lead:.2f} s from the first to the last"
    return Outcome((within - lead) / max(within, facts.dt), lead, within, "s", "", last, note)
