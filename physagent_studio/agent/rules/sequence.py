"""What comes first ("then", "finally", "the tall one first"), and which of two is the other."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_studio.agent.rules.reading import EventFrame
from physagent_studio.agent.rules.specs import Spec, before

PUNCTUAL = (
    "topples", "flips", "passes_over", "bounces", "leaves", "breaks", "contacts", "falls",
    "reverses",
)  # fmt: skip
"""Statements that become true at one moment, the most telling first."""


def moments_of(specs: Sequence[Spec]) -> list[Spec]:
    """Of the demands of a clause those with a moment of their own, the most telling first."""
    found = [
        s
        for s in specs
        if s.kind in PUNCTUAL and not s.fields.get("negated") and "to_step" not in s.fields
    ]
    return sorted(found, key=lambda s: PUNCTUAL.index(s.kind))


def afterwards(earlier: Sequence[Spec], later: Sequence[Spec]) -> Spec | None:
    """That what an earlier clause tells comes before what this one does; None where it cannot be
    told apart."""
    subjects = {s.fields["subject"] for s in (*earlier, *later) if "subject" in s.fields}
    told = [s for s in moments_of(earlier) if len(subjects) > 1 or s.kind != "falls"]
    after = [s for s in moments_of(later) if len(subjects) > 1 or s.kind != "falls"]
    turned = [s for s in earlier if s.kind == "rotates" and not any(_moves(m) for m in earlier)]
    first = next(iter((*told, *turned)), None)
    second = next((s for s in after if s != first), None)
    if len(subjects) > 1:
        # One thing goes on moving; of two, the one that goes first can be told.
        first = first or next((s for s in earlier if _moves(s)), None)
        second = second or next((s for s in later if _moves(s)), None)
    if first is None or second is None or first == second:
        return None
    return before(first, second)


def _moves(spec: Spec) -> bool:
    return spec.kind == "moves" and not spec.fields.get("negated")


def ranked(frame: EventFrame, groups: Sequence[Sequence[Spec]]) -> list[Spec]:
    """ "…, the tall one first and the short one last"."""
    told = {name: _event(group) for name, group in zip(frame.patient, groups, strict=False)}
    found: list[Spec] = []
    for name, event in told.items():
        for other, its in told.items():
            if other == name or event is None or its is None:
                continue
            leads = name in frame.first and other not in frame.first
            closes = other in frame.last and name not in (*frame.last, *frame.first)
            if leads or closes:
                found.append(before(event, its))
    return found


def _event(group: Sequence[Spec]) -> Spec | None:
    return next(iter(moments_of(group)), next((s for s in group if _moves(s)), None))


def matched(
    before_it: EventFrame, frame: EventFrame, first: Sequence[Sequence[Spec]],
    second: Sequence[Sequence[Spec]],
) -> list[tuple[Spec, ...]]:  # fmt: skip
    """ "One of them falls and rolls on": the same one; "…, the other stays": another one.

    first, second: the demands of either clause, one group for each of the things. Each tuple is
    one way in which both can be so.
    """
    rows = range(len(first))
    pairs = [(i, j) for i in rows for j in rows if (i != j) == frame.rest]
    return [(*first[i], *second[j]) for i, j in pairs if before_it.any_one]
