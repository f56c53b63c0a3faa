"""Two rounds side by side: what was measured in each, and what their programs do not share."""

from __future__ import annotations

from typing import Any

from physagent_studio.contract import describe
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.diff import diff
from physagent_studio.records import Check, Round
from physagent_studio.studio.panels.checklist import merged, viewed
from physagent_studio.studio.panels.words import edit_row, figure
from physagent_studio.workbench import Snapshot

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
