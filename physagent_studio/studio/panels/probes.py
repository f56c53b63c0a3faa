"""How sturdy what is on view is, and which changes brought it about, in words and shares."""

from __future__ import annotations

from typing import Any

from physagent_studio.contract import describe
from physagent_studio.errors import InputError
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Check, Round
from physagent_studio.studio.panels.checklist import viewed
from physagent_studio.sweep.robustness import Robustness
from physagent_studio.workbench import Snapshot
from physagent_studio.workbench.probing import RUNS, made_by


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
