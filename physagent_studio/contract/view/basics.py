"""What all view checks share: who they are about, what is said of it, and how a check is made."""

from __future__ import annotations

from collections.abc import Iterable

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.outcome import bounded
from physagent_studio.contract.picture import Sight, sight_of
from physagent_studio.program.actions import FixObject
from physagent_studio.program.contract import Statement
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records.judgement import Check
from physagent_studio.records.rollout import Rollout

INSIDE = 0.5
"""Least part of a subject's outline that is in the frame."""
NOTICED = 0.0006
"""Least step from frame to frame that is seen as motion, parts of the width: half a pixel."""
STILL = frozenset(("stays", "upright", "rests_on"))
MOVING = frozenset(("moves", "falls", "topples", "leaves", "rotates", "flips", "sways", "breaks"))
STOPPING = frozenset(("stops", "stops_before", "covers", "rests_on"))
DROPPING = frozenset(("falls", "leaves", "descends_slowly", "lands_in"))
TIMED = frozenset(
    ("contacts", "falls", "moves", "passes_over", "flips", "rotates", "path_bends", "reverses")
)


VIEW_CODES = {
    "inside": "framing", "pace": "pace", "fills": "pace", "meeting": "pace", "in_time": "pace",
    "ends": "not_stopped", "something": "not_visible", "calm": "stirs", "wheels": "heading",
    "amount": "pace", "gone": "falls_short", "apart": "not_broken",
}  # fmt: skip
"""Code of a failed view check, by its rule: the second word of its id."""


def view_code(check: Check) -> str:
    """The stable word that planners know a failed view check by."""
    return VIEW_CODES.get(check.id.split(".")[1], "unlike_the_photo")


def view_check(
    rule: str, subject: str, text: str, margin: float, *, measured: float | None = None,
    threshold: float | None = None, unit: str = "", step: int | None = None,
) -> Check:  # fmt: skip
    """A check of kind `view`; `{answer}` in its text becomes yes or no."""
    ok = margin >= 0
    return Check(
        id=f"view.{rule}.{subject}"[:64] if subject else f"view.{rule}",
        text=text.format(answer="yes" if ok else "no"),
        ok=ok,
        measured=measured,
        threshold=threshold,
        unit=unit,
        margin=bounded(margin),
        step=step,
        kind="view",
        always_on=True,
    )


def subject_of(check: Check, rollout: Rollout) -> str:
    """The object that a view check is about; "" where it is about the whole."""
    told = check.id.split(".", 2)[2] if check.id.count(".") > 1 else ""
    return max((n for n in rollout.objects if told.startswith(n)), key=len, default="")


def acting_objects(program: PhysicalProgram) -> frozenset[str]:
    """Objects that the contract or the schedule says something happens to."""
    named = {
        str(getattr(s, "subject", ""))
        for s in program.contract.statements
        if s.kind not in STILL and not s.negated
    }
    moved = {a.name for a in program.event.actions if not isinstance(a, FixObject)}
    return frozenset(named | moved)


def nothing_happens(program: PhysicalProgram) -> bool:
    """Whether all that is demanded is that things stay as they are."""
    statements = program.contract.statements
    return bool(statements) and all(
        s.kind in STILL or (s.negated and s.kind in MOVING) for s in statements
    )


def said(program: PhysicalProgram, name: str, kinds: Iterable[str]) -> list[Statement]:
    """What the contract says of an object, of these kinds and not denied."""
    return [
        s
        for s in program.contract.statements
        if s.kind in kinds and not s.negated and getattr(s, "subject", "") == name
    ]


def sight_in(facts: Facts, name: str) -> Sight:
    """One object in the picture of a scene that has a camera."""
    found = sight_of(facts, name)
    assert found is not None, "there is a camera"
    return found
