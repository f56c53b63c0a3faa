"""Checklist: what the sentence demands, what physics does, what a viewer sees, and what is found in
the scene; each with what was measured for it."""

from __future__ import annotations

import re
from typing import Any

from physagent_studio.contract import INSTEAD, describe
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Check, Round
from physagent_studio.studio.panels.words import AS_WORDS, figure, spoken

SEEN = frozenset({"points", "mask", "camera", "geometry", "placement", "support"})
"""Kinds of what is found in the reconstruction: their sentences hold the figures already."""
ANSWER = re.compile(r": (?:yes|no)(, |$)")
STEP = re.compile(r"(?<=: )step \d+: | at step \d+")
HELD_AGAINST = re.compile(r" ([≤≥]) ([^,]+)")


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


def group_of(check: Check) -> str:
    """Where a check stands: with the `view`, with `physics`, or with what is a `demand`."""
    if check.kind == "view":
        return "view"
    return "physics" if check.always_on else "demand"


def viewed(check: Check) -> tuple[str, str]:
    """What a check of the view or the physics says, and its figures, as one says them."""
    plain = STEP.sub("", ANSWER.sub(lambda m: ": " if m[1] else "", check.text))
    text, _, figures = plain.partition(": ")
    if figures:
        return text, HELD_AGAINST.sub(lambda m: f" ({in_words(m[1], m[2])})", figures)
    bound = HELD_AGAINST.search(text)
    if bound is None:
        return text, ""
    return text[: bound.start()], "" if check.ok else f"{INSTEAD[bound[1]]} {bound[2]}"


def in_words(sign: str, value: str) -> str:
    """`≤`, `4 %` → `at most 4 %`."""
    return f"{AS_WORDS[sign]} {value}"


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
    text, measured = stated or check.text, "" if check.kind in SEEN else figure(check, stated)
    if check.kind == "view" or check.always_on:
        text, measured = viewed(check)
        measured = spoken(measured, program)
    row: dict[str, Any] = {
        "id": check.id,
        "ok": check.ok,
        "text": text,
        "clause": clauses.get(check.clause or "", ""),
        "measured": measured,
        "found": found,
        "part": not check.demanded,
        "seen": check.kind in SEEN,
        "frame": None if check.step is None else check.step // program.clip.steps_per_frame,
        "always": check.always_on,
        "group": group_of(check),
        # As the diagnosis repeats it.
        "told": check.text if check.kind == "view" else "",
    }
    if predicted is not None:
        row["predicted"] = {"ok": predicted.ok, "measured": figure(predicted)}
    return row
