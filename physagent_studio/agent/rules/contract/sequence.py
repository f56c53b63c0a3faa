"""What comes first ("then", "finally"), and which of two is the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.agent.rules.contract.specs import Spec, before
from physagent_studio.language import EventFrame

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
        if _kind(s) in PUNCTUAL and not s.fields.get("negated") and "to_step" not in s.fields
    ]
    return sorted(found, key=lambda s: PUNCTUAL.index(_kind(s)))


def _kind(spec: Spec) -> str:
    """Its kind, or that of its alternatives: "hits one of the cups"."""
    alike = spec.kind == "any_of" and len({part.kind for part in spec.parts}) == 1
    return spec.parts[0].kind if alike else spec.kind


def afterwards(
    earlier: Sequence[Spec], later: Sequence[Spec], *, goes_on: bool = False
) -> Spec | None:
    """That what an earlier clause tells comes before what this one does; None where it cannot be
    told apart. goes_on: what moves on after it fell over."""
    subjects = {s.fields["subject"] for s in (*earlier, *later) if "subject" in s.fields}
    told = [s for s in moments_of(earlier) if len(subjects) > 1 or s.kind != "falls"]
    after = [s for s in moments_of(later) if len(subjects) > 1 or s.kind != "falls"]
    turned = [s for s in earlier if s.kind == "rotates" and not any(_moves(m) for m in earlier)]
    first = next(iter((*told, *turned)), None)
    second = next((s for s in after if s != first), None)
    if goes_on:
        ways = (s for s in later if _moves(s) and "toward" not in s.fields)
        second = second or next(ways, None)
    if len(subjects) > 1:
        # One thing goes on moving; of two, the one that goes first can be told.
        first = first or next((s for s in earlier if _moves(s)), None)
        second = second or next((s for s in later if _moves(s)), None)
    if first is None or second is None or first == second:
        return None
    return before(first, second)


def _moves(spec: Spec) -> bool:
    return spec.kind == "moves" and not spec.fields.get("negated")


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


OVER = ("topple", "tip_over", "knock_over", "lose_balance", "flip")
_ON_ITS_WAY = ("roll", "slide", "fall", "leave", "move", "slip", "drift")


def over_then_on(earlier: EventFrame, frame: EventFrame) -> bool:
    """ "Tips over and rolls off": of one thing, told one after the other, and so meant."""
    same = earlier.patient == frame.patient and len(frame.patient) == 1
    plain = not (earlier.negated or frame.negated or earlier.any_one or frame.any_one)
    # What flips over an edge flips as it falls; that order is told by the fall itself.
    falls = earlier.sense == "flip" and frame.sense in ("fall", "leave")
    turned = earlier.sense in OVER and frame.sense in _ON_ITS_WAY and not falls
    return same and plain and turned and frame.link == "then"


def farther(specs: Sequence[Spec], least: float) -> list[Spec]:
    """The demands with ways of `least` m at least: what falls over moves by half its height
    without going anywhere."""
    return [
        replace(s, fields={**s.fields, "distance": max(s.fields["distance"], least)})
        if _moves(s) and "distance" in s.fields and "toward" not in s.fields
        else s
        for s in specs
    ]
