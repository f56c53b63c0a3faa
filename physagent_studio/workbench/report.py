"""What a finished loop amounts to, as plain data."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from physagent_studio.contract import Facts
from physagent_studio.contract.view import pacing_of
from physagent_studio.records import Check, Doubt, LoopState, Round, doubts_of
from physagent_studio.session import Session


def report_of(state: LoopState, session: Session, seconds: float) -> dict[str, Any]:
    """The JSON object of `run --json`."""
    best = state.best or state.current
    assessment = best.assessment if best else None
    checks = assessment.checks if assessment else ()
    return {
        "realised": state.outcome == "realised",
        "outcome": state.outcome,
        "rounds": len(state.path()),
        "session": session.id,
        "seconds": round(seconds, 3),
        "simulations": sum(item.simulations for item in state.path()),
        "contract": [
            _row(check, best) for check in checks if check.demanded and not check.always_on
        ],
        "physics": [
            {"statement": check.text, "ok": check.ok}
            for check in checks
            if check.always_on and check.kind != "view"
        ],
        "view": [_row(check, best) for check in checks if check.kind == "view"],
        "pacing": _pacing(best, session),
        "diagnosis": [item.text for item in assessment.diagnosis] if assessment else [],
        "doubts": [asdict(one) | {"text": one.text} for one in _doubts(best, session)],
        "untested": [item.text for item in best.program.contract.untested] if best else [],
        "not_understood": list(best.program.contract.not_understood) if best else [],
        "learned": [asdict(use) for use in session.scene(best.scene).learned]
        if best and best.scene
        else [],
        "program": best.program.hash if best else None,
    }


def _doubts(item: Round | None, session: Session) -> tuple[Doubt, ...]:
    """What is doubted of a round: its masks, its camera, words that nobody understood."""
    if item is None:
        return ()
    scene = session.scene(item.scene) if item.scene else None
    return doubts_of(scene, item.program.contract.not_understood)


def _row(check: Check, item: Round | None) -> dict[str, Any]:
    return {
        "check": check.id,
        "statement": check.text,
        "clause": _clause(item, check.clause),
        "measured": check.measured,
        "threshold": check.threshold,
        "unit": check.unit,
        "margin": check.margin,
        "ok": check.ok,
    }


def _pacing(item: Round | None, session: Session) -> dict[str, Any] | None:
    """When the clip shows a motion, how fast, and what leaves the picture; see `Pacing`."""
    if item is None or item.rollout is None:
        return None
    found = pacing_of(Facts.of(item.program, session.rollout(item.rollout)))
    return None if found is None else asdict(found) | {"crossings": dict(found.crossings)}


def _clause(item: Round | None, clause_id: str | None) -> str | None:
    if item is None or clause_id is None:
        return None
    clauses = {clause.id: clause.text for clause in item.program.contract.clauses}
    return clauses.get(clause_id)
