"""What a model's verdict and the measured facts make of a stage, together."""

import math

from physagent_studio.agent.vlm.forms import StageOneReply, StageTwoReply
from physagent_studio.contract.view import subject_of, view_code
from physagent_studio.records import (
    CRITERIA,
    Assessment,
    Check,
    Criterion,
    Finding,
    Mismatch,
    RolloutEvidence,
    SceneEvidence,
)

AUTHOR = "vlm"
MOST_MARGIN = 10.0


def scene_assessment(reply: StageOneReply, findings: tuple[Finding, ...]) -> Assessment:
    """Passes only where the model and the measured findings agree that it does."""
    failing = [item for item in findings if not item.ok]
    contradiction = ""
    if reply.passed and failing:
        texts = "; ".join(item.text for item in failing[:3])
        contradiction = f"the model passes the reconstruction, but it was measured: {texts}"
    seen = tuple(
        Mismatch(code=item.code, text=item.text, subject=item.subject) for item in reply.mismatches
    )
    return Assessment(
        stage="reconstruction",
        passed=reply.passed and not failing,
        checks=tuple(_check(item) for item in findings),
        criteria=_criteria(reply),
        diagnosis=(*seen, *map(_finding_mismatch, failing), *_flag(contradiction)),
        author=AUTHOR,
        contradiction=contradiction,
    )


def rollout_assessment(reply: StageTwoReply, evidence: RolloutEvidence) -> Assessment:
    """Passes only where the model and the measured contract agree that it does."""
    failing = _failing(evidence.checks)
    contradiction = _contradiction(reply, evidence, failing)
    texts = {clause.id: clause.text for clause in evidence.program.contract.clauses}
    per_frame = evidence.rollout.steps_per_frame
    seen = tuple(
        Mismatch(
            code=item.code,
            text=item.text,
            subject=item.subject,
            other=item.other or "",
            step=None if item.frame is None else item.frame * per_frame,
        )
        for item in reply.mismatches
    )
    measured = tuple(_check_mismatch(check, evidence) for check in failing)
    return Assessment(
        stage="simulation",
        passed=reply.passed and not failing,
        checks=evidence.checks,
        criteria=_criteria(reply),
        clauses=tuple(
            Criterion(name=texts[item.clause], ok=item.ok, reason=item.reason)
            for item in reply.clauses
        ),
        diagnosis=(*seen, *measured, *_flag(contradiction)),
        untested=tuple(clause.text for clause in evidence.program.contract.untested),
        author=AUTHOR,
        contradiction=contradiction,
    )


def _criteria(reply: StageOneReply | StageTwoReply) -> tuple[Criterion, ...]:
    said = reply.aspects().items()
    return tuple(Criterion(name=name, ok=one.ok, reason=one.reason) for name, one in said)


def _contradiction(
    reply: StageTwoReply, evidence: RolloutEvidence, failing: tuple[Check, ...]
) -> str:
    if reply.passed and failing:
        texts = "; ".join(check.text for check in failing[:3])
        return f"the model passes the event, but it was measured: {texts}"
    demanded = [check for check in evidence.checks if check.demanded and not check.always_on]
    if not reply.passed and demanded and not failing:
        wrong = [item.reason for item in reply.clauses if not item.ok]
        wrong += [item.text for item in reply.mismatches]
        said = "; ".join(wrong[:3]) or "a criterion"
        return f"every measured statement holds, but the model denies the event: {said}"
    return ""


def _failing(checks: tuple[Check, ...]) -> tuple[Check, ...]:
    return tuple(check for check in checks if check.demanded and not check.ok)


def _flag(contradiction: str) -> tuple[Mismatch, ...]:
    return (Mismatch(code="contradiction", text=contradiction),) if contradiction else ()


_CODES = {
    "moves": "falls_short", "falls": "falls_short", "contacts": "no_contact",
    "topples": "not_toppled", "stays": "moved", "upright": "toppled", "stops": "overshoots",
    "stops_before": "overshoots", "rests_on": "misses", "reaches": "falls_short",
    "leaves": "falls_short", "lands_in": "misses", "passes_over": "misses",
    "speed_between": "too_fast", "descends_slowly": "too_fast", "before": "too_late",
    "covers": "falls_short", "side_of": "misses", "in_turn": "too_late", "together": "too_late",
    "blow_up": "blow_up",
}  # fmt: skip
_DENIED = {"contacts": "unwanted_contact", "topples": "toppled", "moves": "moved"}


def _check_mismatch(check: Check, evidence: RolloutEvidence) -> Mismatch:
    """The figures of a failed check; the code of the kind of thing that went wrong."""
    statements = evidence.program.contract.statements
    statement = next((one for one in statements if one.id == check.id), None)
    negated = statement is not None and statement.negated
    code = (_DENIED if negated else _CODES).get(check.kind, "fails")
    subject = str(getattr(statement, "subject", "") or "")
    if check.kind == "view":
        code, subject = view_code(check), subject_of(check, evidence.rollout)
    figures = {"margin": check.margin}
    if check.measured is not None:
        figures["measured"] = check.measured
    if check.threshold is not None:
        figures["threshold"] = check.threshold
    return Mismatch(
        code=code,
        text=check.text,
        subject=subject,
        other=str(getattr(statement, "other", "") or ""),
        check=check.id,
        figures=figures,
        step=check.step,
    )


def _check(item: Finding) -> Check:
    scale = max(abs(item.threshold), 1e-9)
    distance = min(abs(item.measured - item.threshold) / scale, MOST_MARGIN)
    # Not a number where nothing could be measured.
    size = distance if math.isfinite(distance) else MOST_MARGIN
    return Check(
        id=".".join(part for part in (item.kind, item.subject, item.name) if part),
        text=item.text,
        ok=item.ok,
        measured=item.measured if math.isfinite(item.measured) else None,
        threshold=item.threshold,
        unit=item.unit,
        margin=size if item.ok else -max(size, 1e-6),
        kind=item.kind,
    )


_FINDINGS = {
    "points": "wrong_points", "mask": "wrong_mask", "camera": "wrong_camera",
    "geometry": "wrong_shape", "placement": "wrong_place", "support": "wrong_support",
}  # fmt: skip


def _finding_mismatch(item: Finding) -> Mismatch:
    return Mismatch(
        code=_FINDINGS[item.kind],
        text=item.text,
        subject=item.subject,
        figures={"measured": item.measured} if math.isfinite(item.measured) else {},
    )


def no_scene_verdict(evidence: SceneEvidence, why: str) -> Assessment:
    """Stage 1 failed for want of a verdict; what was measured is kept."""
    failing = [item for item in evidence.scene.findings if not item.ok]
    return Assessment(
        stage="reconstruction",
        passed=False,
        checks=tuple(_check(item) for item in evidence.scene.findings),
        diagnosis=(_no_verdict(why), *map(_finding_mismatch, failing)),
        author=AUTHOR,
    )


def no_rollout_verdict(evidence: RolloutEvidence, why: str) -> Assessment:
    """Stage 2 failed for want of a verdict; what was measured is kept."""
    failing = _failing(evidence.checks)
    reason = f"no verdict: {why}"
    return Assessment(
        stage="simulation",
        passed=False,
        checks=evidence.checks,
        criteria=tuple(Criterion(name=name, ok=False, reason=reason) for name in CRITERIA),
        diagnosis=(_no_verdict(why), *(_check_mismatch(c, evidence) for c in failing)),
        untested=tuple(clause.text for clause in evidence.program.contract.untested),
        author=AUTHOR,
    )


def _no_verdict(why: str) -> Mismatch:
    return Mismatch(code="no_verdict", text=f"no verdict: {why}")
