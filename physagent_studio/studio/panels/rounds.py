"""Rounds: the history as a tree, and everything about the round on view."""

from __future__ import annotations

import re
from typing import Any

from physagent_studio.agent.by_hand import turn_of
from physagent_studio.agent.loop import EASING
from physagent_studio.agent.rules.planner.wording import apart_from_pace
from physagent_studio.language.tokens.spelling import instead_of
from physagent_studio.program import AddItem, PhysicalProgram
from physagent_studio.program.timing import PACE
from physagent_studio.records import LoopState, Proposal, Round, doubts_of
from physagent_studio.records.loop_state import best_of
from physagent_studio.studio.panels.checklist import (
    checklist_of,
    comparison_of,
    credit_of,
    demands_of,
    sturdiness_of,
)
from physagent_studio.studio.panels.fields import SPOKEN, fields_of
from physagent_studio.studio.panels.words import (
    all_spoken,
    criterion_row,
    edit_row,
    number,
    place,
    plain,
    speaker,
    unseen,
)
from physagent_studio.studio.site import strip_of
from physagent_studio.workbench import Snapshot

DECIDED = {
    "accept": "accepted",
    "accept_hunks": "accepted in part",
    "override": "overridden",
    "edit": "edited, then accepted",
    "reject": "rejected",
    "hint": "hint given",
    "skip": "skipped",
    "stop": "stopped",
}
OUTCOMES = {
    "realised": "The event happens.",
    "budget": "All rounds are used up; the best one is kept.",
    "stopped": "Stopped.",
    "stuck": "The planner has no further idea. A hint or an edit of yours can help.",
    "running": "",
}


HISTORY = 100
"""Rows of the history that are listed at once; nobody reads more, and each has to be drawn."""
RECENT = 200
"""Rounds of the path of which the best is marked: twice the largest budget."""


def _spoken(factor: str) -> str:
    """What a proposal changes, as a person calls it."""
    return SPOKEN.get(factor, factor.replace("_", " "))


LOOSE_BELOW = 0.8
"""Overlap (IoU) of a shape with its mask below which the fit is said to be doubtful."""


def state_of(snapshot: Snapshot, compared: Round | None = None) -> dict[str, Any]:
    """All that the panel shows."""
    loop = snapshot.state
    shown = _find(loop, snapshot.shown_round)
    scene = snapshot.program.scene
    found = {
        **_history(loop, snapshot.shown_round),
        "turn": "" if snapshot.read_only else turn_of(loop) or "",
        "readOnly": snapshot.read_only,
        "draft": snapshot.has_draft,
        "shown": None if shown is None else _details(shown, snapshot),
        "sturdiness": sturdiness_of(snapshot),
        "credit": credit_of(shown, snapshot),
        "checks": checklist_of(snapshot.checks, snapshot.program, shown, draft=snapshot.has_draft),
        "notUnderstood": [
            f"“{word}” ({instead_of(word)})" for word in snapshot.program.contract.not_understood
        ],
        "untested": [clause.text for clause in snapshot.program.contract.untested],
        "proposal": _proposal(loop, snapshot),
        "fields": fields_of(snapshot.program),
        "names": {
            "objects": [one.name for one in scene.objects],
            "places": list(scene.names),
            "statements": [one.id for one in snapshot.program.contract.statements],
            "round": [
                one.name for one in scene.objects if one.shape and one.shape.kind == "sphere"
            ],
            "leaving": list(snapshot.program.contract.leaving),
            "paces": [plain(one) for one in snapshot.program.contract.paces],
        },
        "guessed": [one.name for one in scene.objects if one.grounding.proposed],
        "doubts": _doubts(snapshot),
        "loose": _loose(snapshot),
        "photo": _photo(snapshot),
        "hints": list(loop.hints),
        "pinned": list(loop.pinned),
        "kept": [{"path": path, "what": place(path)} for path in loop.pinned],
        "compare": None if compared is None else comparison_of(compared, snapshot),
    }
    return all_spoken(found, speaker(snapshot.program))


def _doubts(snapshot: Snapshot) -> list[dict[str, Any]]:
    """What is doubted of the scene on view, with what each thing is grounded on."""
    groundings = {one.name: one.grounding for one in snapshot.program.scene.objects}
    return [
        {
            "kind": doubt.kind,
            "name": doubt.name,
            "percent": round(100 * doubt.probability),
            "grounding": plain(groundings[doubt.name]) if doubt.kind == "mask" else None,
        }
        for doubt in doubts_of(snapshot.scene)
        if doubt.kind != "mask" or doubt.name in groundings
    ]


def _loose(snapshot: Snapshot) -> list[dict[str, Any]]:
    """Things whose shape covers less of what was cut out than one should see."""
    found = () if snapshot.scene is None else snapshot.scene.findings
    return [
        {"name": one.subject, "percent": round(100 * one.measured)}
        for one in found
        if one.name == "reprojection" and one.measured < LOOSE_BELOW
    ]


def _photo(snapshot: Snapshot) -> dict[str, Any] | None:
    """The picture and where its horizon is taken to be, to choose another camera by."""
    case, camera = snapshot.case, snapshot.program.scene.camera
    if case is None or case.image is None or camera is None:
        return None
    height, width = case.image.shape[:2]
    row = round(camera.horizon, 1)
    return {"url": f"/photo/{case.image_hash}.jpg", "size": [width, height], "horizon": row}


def _find(loop: LoopState, wanted: str | None) -> Round | None:
    return next((item for item in loop.rounds if item.id == wanted), None)


def verdict_of(item: Round) -> str:
    """One word for a round: ok, failed, or open while the event was not judged."""
    if item.assessment is None:
        return "open"
    if item.assessment.stage == "reconstruction":
        # A scene that matches is no event yet.
        return "open" if item.scene_holds else "failed"
    return "ok" if item.passed else "failed"


def _history(loop: LoopState, shown: str | None) -> dict[str, Any]:
    """The rows around the round on view, and how many come before and after them.

    Only of these the whole round is read: there may be ten thousand.
    """
    tree = _tree(loop)
    middle = next((at for at, (item, _) in enumerate(tree) if item.id == (shown or loop.head)), 0)
    start = max(0, min(middle - HISTORY // 2, len(tree) - HISTORY))
    end = min(start + HISTORY, len(tree))
    path = loop.path()
    on_path, best = {item.id for item in path}, best_of(path[-RECENT:])
    return {
        "rounds": [_row(item, n, loop, shown, on_path, best) for item, n in tree[start:end]],
        "before": _beyond(start, tree[start - 1][0]) if start else None,
        "after": _beyond(len(tree) - end, tree[end][0]) if end < len(tree) else None,
    }


def _beyond(count: int, nearest: Round) -> dict[str, Any]:
    """Rounds that are not listed; looking at the nearest of them lists those around it."""
    return {"count": count, "id": nearest.id}


def _tree(loop: LoopState) -> list[tuple[Round, int]]:
    """Rounds in tree order; their depth grows where a branch leaves its parent's first line."""
    children: dict[str | None, list[Round]] = {}
    known = {item.id for item in loop.rounds}
    for item in loop.rounds:
        children.setdefault(item.parent if item.parent in known else None, []).append(item)
    rows: list[tuple[Round, int]] = []
    waiting = [(item, 0) for item in reversed(children.get(None, []))]
    while waiting:
        item, depth = waiting.pop()
        rows.append((item, depth))
        branches = children.get(item.id, [])
        # The first child goes on in the same column, the others branch off.
        waiting += [(child, depth + 1) for child in reversed(branches[1:])]
        waiting += [(child, depth) for child in branches[:1]]
    return rows


def _row(
    item: Round,
    depth: int,
    loop: LoopState,
    shown: str | None,
    on_path: set[str],
    best: Round | None,
) -> dict[str, Any]:
    assessment = item.assessment
    demands = demands_of(() if assessment is None else assessment.checks)
    waits = turn_of(loop) == "verifier"
    return {
        "id": item.id,
        "number": item.number,
        "depth": depth,
        # What a person is still to judge has no verdict yet, whatever was measured.
        "verdict": "open" if item.id == loop.head and waits else verdict_of(item),
        "overruled": item.ruling is not None,
        "stage": "" if assessment is None else assessment.stage,
        "realised": sum(check.ok for check in demands),
        "checks": len(demands),
        "unseen": unseen(() if assessment is None else assessment.checks),
        "factor": _spoken(item.proposal.factor) if item.proposal else "",
        "decided": decided_words(item),
        "by": item.decision.author if item.decision else "",
        "head": item.id == loop.head,
        "shown": item.id == shown,
        "onPath": item.id in on_path,
        "best": best is not None and item.id == best.id,
    }


def decided_words(item: Round) -> str:
    """What became of the proposal of a round; "" while nothing was decided."""
    decision = item.decision
    if decision is None:
        return ""
    if is_gentler(item.proposal) and decision.kind in ("skip", "reject", "stop"):
        return "kept as it was"
    return DECIDED.get(decision.kind, decision.kind)


def is_gentler(proposal: Proposal | None) -> bool:
    """Whether a proposal repairs nothing: it makes what happens already happen more gently."""
    return proposal is not None and proposal.factor == EASING


def _details(item: Round, snapshot: Snapshot) -> dict[str, Any]:
    assessment, override = item.assessment, item.ruling
    clip = item.program.clip
    return {
        "id": item.id,
        "number": item.number,
        "verdict": verdict_of(item),
        "stage": "" if assessment is None else assessment.stage,
        "machine": None if assessment is None else assessment.passed,
        "judge": "" if assessment is None or assessment.author == "rules" else "the model",
        "contradiction": "" if assessment is None else assessment.contradiction,
        "clauses": [] if assessment is None else [plain(one) for one in assessment.clauses],
        "strip": strip_of(item),
        "criteria": []
        if assessment is None
        else [criterion_row(one, seen_only=_seen_only(item)) for one in assessment.criteria],
        "diagnosis": []
        if assessment is None
        else [
            {
                "text": one.text,
                "frame": None if one.step is None else one.step // clip.steps_per_frame,
            }
            for one in assessment.diagnosis
            if one.code != "contradiction"
        ],
        "findings": _findings(item, snapshot),
        "override": None if override is None else plain(override),
        "unseen": unseen(() if assessment is None else assessment.checks),
        "changes": _changes(item, snapshot.state),
    }


def _seen_only(item: Round) -> bool:
    """Whether nothing of a round fails but what a viewer sees."""
    failing = [c for c in (item.assessment.checks if item.assessment else ()) if not c.ok]
    return all(one.kind == "view" for one in failing if one.demanded)


def _changes(item: Round, loop: LoopState) -> list[dict[str, Any]]:
    """What the decision that made a round changed of the round before."""
    before = _find(loop, item.parent)
    if item.origin is None or before is None:
        return []
    paced, others = apart_from_pace(item.origin.edits)
    rows = [edit_row(edit, before.program) for edit in others]
    added = [edit.item for edit in others if isinstance(edit, AddItem)]
    names = iter(str(one.get("id", "")) if isinstance(one, dict) else "" for one in added)
    told = [row | {"added": next(names) if row["op"] == "add" else ""} for row in rows]
    if not paced:
        return told
    was, now = (number(one.clip.time_factor) for one in (before.program, item.program))
    pace = {"op": "set", "path": "clip", "what": "pace", "before": was, "after": now}
    return [pace | {"unit": "× real time", "added": ""}, *told]


def _findings(item: Round, snapshot: Snapshot) -> list[dict[str, Any]]:
    """What stage 1 measured in the reconstruction; only of interest where it failed."""
    if snapshot.scene is None or item.assessment is None:
        return []
    if item.assessment.stage != "reconstruction":
        return []
    return [
        {"ok": one.ok, "text": one.text, "subject": one.subject} for one in snapshot.scene.findings
    ]


def _proposal(loop: LoopState, snapshot: Snapshot) -> dict[str, Any] | None:
    head = loop.current
    if head is None or head.proposal is None or snapshot.read_only or loop.phase != "decide":
        return None
    proposal, preview = head.proposal, head.preview
    return {
        "id": proposal.id,
        "factor": _spoken(proposal.factor),
        "gentler": is_gentler(proposal),
        "rationale": proposal.rationale,
        "confidence": round(proposal.confidence * 100),
        "verified": proposal.touches_verified,
        "question": proposal.question,
        "understood": proposal.understood,
        "meant": [{"text": text, "say": say} for text, say in proposal.meant],
        "about": asked_about(proposal, head),
        "simulations": proposal.simulations,
        "hunks": _hunks(proposal, head.program),
        "preview": None
        if preview is None or not (preview.checks or preview.problem)
        else {
            "passed": preview.passed,
            "problem": preview.problem,
            "ok": sum(check.ok for check in preview.checks),
            "of": len(preview.checks),
        },
    }


def asked_about(proposal: Proposal, head: Round) -> dict[str, str] | None:
    """The thing that a question about the photo names: a mark there answers it best."""
    if head.assessment is None or head.assessment.stage != "reconstruction":
        return None
    scene = head.program.scene
    things = [("object", one) for one in scene.objects]
    things += [("support", one) for one in scene.supports]
    found = [
        (place.start(), {"kind": kind, "name": one.name})
        for kind, one in things
        if one.grounding.shows_something
        for place in re.finditer(rf"\b{re.escape(one.name)}\b", proposal.question)
    ]
    # What is named last is what the question ends with.
    return max(found, key=lambda row: row[0])[1] if found else None


def _hunks(proposal: Proposal, program: PhysicalProgram) -> list[dict[str, Any]]:
    return [
        {
            "id": hunk.id,
            "summary": hunk.summary,
            # What sets a pace together is said once, in the summary.
            "rows": []
            if any(getattr(edit, "path", "") in PACE for edit in hunk.edits)
            else [edit_row(edit, program) for edit in hunk.edits],
            "edits": [plain(edit) for edit in hunk.edits],
        }
        for hunk in proposal.hunks
    ]
