"""Checklist: what the sentence demands, what physics does, what a viewer sees, and what is found in
the scene, each with what was measured for it; the same of two rounds, and of many runs."""

from __future__ import annotations

import re
from typing import Any

from physagent_studio.contract import INSTEAD, describe
from physagent_studio.errors import InputError
from physagent_studio.program import PhysicalProgram, Statement
from physagent_studio.program.contract import spoken_of
from physagent_studio.program.text.diff import diff
from physagent_studio.records import Check, Round
from physagent_studio.studio.panels.words import AS_WORDS, edit_row, figure, spoken
from physagent_studio.sweep.robustness import Robustness
from physagent_studio.workbench import Snapshot
from physagent_studio.workbench.probing import RUNS, made_by

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
    _folded(rows, program)
    return rows


def _folded(rows: list[dict[str, Any]], program: PhysicalProgram) -> None:
    """Folds what only serves another demand under it: each row names its `parts` by their ids."""
    stated = {one.id: one for one in program.contract.statements}
    serving = {row["id"] for row in rows if row["part"]}
    for row in rows:
        row["folded"] = row["part"] and row["id"] in stated
        row["parts"] = [name for name in _parts_of(row["id"], stated) if name in serving]


def _parts_of(name: str, stated: dict[str, Statement]) -> tuple[str, ...]:
    """What a statement speaks of; where that is one other alone, what this one speaks of."""
    found = spoken_of(stated[name]) if name in stated else ()
    deeper = _parts_of(found[0], stated) if len(found) == 1 else ()
    return deeper or found


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


SECTIONS = {
    "clip": "the clip",
    "scene.camera": "the camera",
    "scene.roll": "tilt of the camera",
    "scene.flags": "what was assumed",
    "event.prompt": "the sentence",
    "contract.not_understood": "what was not understood",
}
"""Parts of a program that are no list, where their own name says too little."""


def comparison_of(other: Round, snapshot: Snapshot) -> dict[str, Any]:
    """What was measured in a round and in what is on view, and the lines that lead there."""
    theirs = _once(other.assessment.checks if other.assessment else ())
    mine = _once(snapshot.checks)
    stated = {
        one.id: describe(one, program)
        for program in (other.program, snapshot.program)
        for one in program.contract.statements
    }
    rows = []
    for key in dict.fromkeys((*mine, *theirs)):
        a, b = mine.get(key), theirs.get(key)
        one = a or b
        assert one is not None
        rows.append(
            {
                "text": viewed(one)[0]
                if one.kind == "view"
                else stated.get(key, one.text.partition(": ")[0]),
                "here": None if a is None else {"ok": a.ok, "measured": _measured(a)},
                "there": None if b is None else {"ok": b.ok, "measured": _measured(b)},
            }
        )
    return {
        "id": other.id,
        "number": other.number,
        "rows": rows,
        "diff": _lines(other.program, snapshot.program)[:400],
    }


def _measured(check: Check) -> str:
    return viewed(check)[1] if check.kind == "view" else figure(check)


def _lines(before: PhysicalProgram, after: PhysicalProgram) -> list[dict[str, str]]:
    """What leads from one program to the other, a heading for each thing and a line each way."""
    found = []
    for hunk in diff(before, after):
        found.append({"kind": "at", "text": _heading(hunk.id)})
        for edit in hunk.edits:
            row = edit_row(edit, before)
            if edit.op == "set":
                ends = (("del", row["before"]), ("add", f"{row['after']} {row['unit']}".strip()))
                what = row["what"].rpartition(" · ")[2]
                found += [{"kind": kind, "text": f"{what}: {text}"} for kind, text in ends]
            elif edit.op == "add":
                found.append({"kind": "add", "text": row["after"]})
            elif edit.op == "remove":
                found.append({"kind": "del", "text": row["what"]})
    return found


def _heading(path: str) -> str:
    """What a hunk is about, as a person calls it: push red ball; the clip; order of actions."""
    head, _, last = path.rpartition(".")
    name = SECTIONS.get(path) or last.replace("_", " ")
    return f"order of {head.rpartition('.')[2]}" if last == "order" else name


def _once(checks: tuple[Check, ...]) -> dict[str, Check]:
    """By id: all demands, and of the checks on the physics those that are broken."""
    return {one.id: one for one, _ in merged(checks) if not (one.always_on and one.ok)}


def sturdiness_of(snapshot: Snapshot) -> dict[str, Any] | None:
    """In how many runs it holds and what breaks it first; None where nothing holds to be tried."""
    if snapshot.rollout is None or any(one.demanded and not one.ok for one in snapshot.checks):
        return None
    found = snapshot.probed.sturdiness if snapshot.probed else None
    if found is None:
        return {"runs": RUNS, "holds": None}
    told = {"runs": len(found.runs), "holds": found.holds}
    return told | ({"reason": _breaking(found, snapshot.program)} if found.why else {})


def _breaking(found: Robustness, program: PhysicalProgram) -> str:
    """`red_ball touches block fails, most of all where the friction of red_ball is lower`."""
    assert found.why is not None
    number, apart = found.why
    way = "higher" if apart > 0 else "lower"
    broken = "the run breaks off" if found.first is None else f"“{_said(found.first, program)}”"
    return f"{broken}, most of all where the {number.label} is {way}"


def _said(check: Check, program: PhysicalProgram) -> str:
    stated = (describe(one, program) for one in program.contract.statements if one.id == check.id)
    return next(stated, viewed(check)[0])


def credit_of(shown: Round | None, snapshot: Snapshot) -> dict[str, Any] | None:
    """The changes that made the round on view and what each is to thank for, percent.

    None where no accepted proposal of several changes made it; rows without shares where nobody
    has asked for them yet.
    """
    if shown is None or snapshot.has_draft or not shown.passed:
        return None
    try:
        _, hunks = made_by(shown, snapshot.state)
    except InputError:
        return None
    if len(hunks) < 2:
        return None
    known = snapshot.probed.credit if snapshot.probed else None
    if known is None:
        return {"known": False, "rows": []}
    found = known[1]
    shares = found.shapley or (None,) * len(hunks)
    rows = [
        {
            "summary": hunk.summary,
            "percent": None if share is None else round(100 * share),
            "needed": needed,
        }
        for hunk, share, needed in zip(known[0], shares, found.needed, strict=True)
    ]
    return {"known": True, "rows": rows, "before": found.before, "after": found.after,
            "exact": found.exact}  # fmt: skip
