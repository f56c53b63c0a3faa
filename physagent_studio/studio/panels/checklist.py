"""Checklist: what the sentence demands, what was measured for it, what is found in the scene."""

from __future__ import annotations

from typing import Any

from physagent_studio.contract import describe
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Check, Round
from physagent_studio.studio.panels.words import figure

SEEN = frozenset({"points", "mask", "camera", "geometry", "placement", "support"})
"""Kinds of what is found in the reconstruction: their sentences hold the figures already."""


def checklist_of(
    checks: tuple[Check, ...],
    program: PhysicalProgram,
    shown: Round | None = None,
    *,
    draft: bool = False,
) -> list[dict[str, Any]]:
    """The lines of the checklist; with what the proposal of the round on view would make of it."""
    clauses = {clause.id: clause.text for clause in program.contract.clauses}
    predicted: dict[str, Check] = {}
    if shown is not None and shown.preview is not None and not draft:
        predicted = {check.id: check for check in shown.preview.checks}
    stated = {one.id: describe(one, program) for one in program.contract.statements}
    rows = []
    for check, others in merged(checks):
        row = check_row(check, program, clauses, predicted.get(check.id), stated.get(check.id, ""))
        also = (clauses.get(one.clause or "", "") for one in others)
        row["also"] = [text for text in dict.fromkeys(also) if text and text != row["clause"]]
        rows.append(row)
    return rows


def merged(checks: tuple[Check, ...]) -> list[tuple[Check, tuple[Check, ...]]]:
    """Checks in order; one that two clauses ask for alike stands once, with the others behind."""
    groups: dict[tuple[object, ...], list[Check]] = {}
    for check in checks:
        alone = check.always_on or not check.demanded
        key = (check.id,) if alone else (check.kind, check.text, check.ok)
        groups.setdefault(key, []).append(check)
    return [(first, tuple(others)) for first, *others in groups.values()]


def demands_of(checks: tuple[Check, ...]) -> list[Check]:
    """What the sentence demands, each once; what only serves another demand is not counted."""
    wanted = (check for check, _ in merged(checks) if not check.always_on)
    return [check for check in wanted if check.demanded]


def check_row(
    check: Check,
    program: PhysicalProgram,
    clauses: dict[str, str],
    predicted: Check | None = None,
    stated: str = "",
) -> dict[str, Any]:
    """One line of the checklist: the statement in words, and what was measured for it."""
    # What a stage finds in the reconstruction has no statement; then the figure says it all.
    found = check.text.partition(": ")[2] if stated else ""
    row: dict[str, Any] = {
        "id": check.id,
        "ok": check.ok,
        "text": stated or check.text,
        "clause": clauses.get(check.clause or "", ""),
        "measured": "" if check.kind in SEEN else figure(check, stated),
        "found": found,
        "part": not check.demanded,
        "seen": check.kind in SEEN,
        "frame": None if check.step is None else check.step // program.clip.steps_per_frame,
        "always": check.always_on,
    }
    if predicted is not None:
        row["predicted"] = {"ok": predicted.ok, "measured": figure(predicted)}
    return row
