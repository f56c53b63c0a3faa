"""What a finished loop amounts to, as plain data."""

from __future__ import annotations

from typing import Any

from physagent_studio.records import Check, LoopState, Round
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
        "time_factor": best.program.clip.time_factor if best else None,
        "diagnosis": [item.text for item in assessment.diagnosis] if assessment else [],
        "untested": [item.text for item in best.program.contract.untested] if best else [],
        "not_understood": list(best.program.contract.not_understood) if best else [],
        "program": best.program.hash if best else None,
    }


def _row(check: Check, item: Round | None) -> dict[str, Any]:
    return {
        "statement": check.text,
        "clause": _clause(item, check.clause),
        "measured": check.measured,
        "threshold": check.threshold,
        "unit": check.unit,
        "margin": check.margin,
        "ok": check.ok,
    }


def _clause(item: Round | None, clause_id: str | None) -> str | None:
    if item is None or clause_id is None:
        return None
    clauses = {clause.id: clause.text for clause in item.program.contract.clauses}
    return clauses.get(clause_id)
