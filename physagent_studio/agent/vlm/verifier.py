"""`VlmVerifier`: judges from pictures and measured facts; a contradiction is flagged."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from physagent_studio.agent.vlm import facts
from physagent_studio.agent.vlm.dialogue import converse
from physagent_studio.agent.vlm.failures import Invalid, VlmError
from physagent_studio.agent.vlm.forms import StageOneReply, StageTwoReply
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Part, Picture, Turn
from physagent_studio.agent.vlm.pictures import contact_sheet, marked, side_by_side
from physagent_studio.agent.vlm.prompting import prompt, quoted
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import (
    CRITERIA,
    Assessment,
    Check,
    Criterion,
    Evidence,
    Finding,
    Mismatch,
    RolloutEvidence,
    SceneEvidence,
)

AUTHOR = "vlm"
MOST_MARGIN = 10.0


@dataclass(frozen=True, slots=True)
class VlmVerifier:
    """Judges a stage. Where no valid verdict comes, it fails with the reason "no verdict".

    frames: the sampled frames as one labelled contact sheet, or one picture each.
    """

    line: Line
    frames: Literal["sheet", "images"] = "sheet"

    def judge(self, evidence: Evidence, prompt: str) -> Assessment:
        """The verdict on the evidence; raises `Cancelled` alone."""
        if isinstance(evidence, SceneEvidence):
            return self._scene(evidence, prompt)
        return self._rollout(evidence, prompt)

    # --- stage 1 -----------------------------------------------------------------------------

    def _scene(self, evidence: SceneEvidence, sentence: str) -> Assessment:
        findings = evidence.scene.findings
        known = _names(evidence.program)

        def check(reply: StageOneReply) -> StageOneReply:
            _known_names([item.subject for item in reply.mismatches], known | {"camera"})
            return reply

        try:
            reply = converse(
                self.line,
                "verifier.scene",
                _scene_turns(evidence, sentence),
                StageOneReply,
                check,
            )
        except VlmError as error:
            return _no_scene_verdict(evidence, str(error))
        return scene_assessment(reply, findings)

    # --- stage 2 -----------------------------------------------------------------------------

    def _rollout(self, evidence: RolloutEvidence, sentence: str) -> Assessment:
        program = evidence.program
        known = _names(program)
        clauses = [clause.id for clause in program.contract.clauses]

        def check(reply: StageTwoReply) -> StageTwoReply:
            judged = {item.clause for item in reply.clauses}
            missing = [one for one in clauses if one not in judged]
            if missing:
                raise Invalid(f"clauses: {', '.join(missing)} are not judged")
            strange = sorted(judged - set(clauses))
            if strange:
                listed = ", ".join(clauses) or "none"
                raise Invalid(f"clauses: there is no clause {', '.join(strange)} (ids: {listed})")
            _known_names([item.subject for item in reply.mismatches], known)
            _known_names([item.other for item in reply.mismatches if item.other], known)
            return reply

        turns = _rollout_turns(evidence, sentence, self.frames)
        try:
            reply = converse(self.line, "verifier.rollout", turns, StageTwoReply, check)
        except VlmError as error:
            return _no_rollout_verdict(evidence, str(error))
        return rollout_assessment(reply, evidence)


def _names(program: PhysicalProgram) -> set[str]:
    scene = program.scene
    return {item.name for item in (*scene.objects, *scene.supports, *scene.landmarks)}


def _known_names(names: list[str], known: set[str]) -> None:
    strange = sorted(set(names) - known)
    if strange:
        listed = ", ".join(sorted(known)) or "none"
        raise Invalid(f"mismatches: there is no {', '.join(strange)} (names: {listed})")


# --- what is asked ---------------------------------------------------------------------------


def _system(part: str) -> Turn:
    return Turn("system", (prompt("system", part=prompt(part)),))


def _scene_turns(evidence: SceneEvidence, sentence: str) -> tuple[Turn, ...]:
    state, photo, view = evidence.scene.state, evidence.scene.photo, evidence.view
    clicks = [(item.name, click) for item in state.objects for click in item.grounding.points]
    clicks += [(item.name, click) for item in state.supports for click in item.grounding.points]
    points = [
        f"{name}: ({click.x:g}, {click.y:g}){'' if click.label else ' is not on it'}"
        for name, click in clicks
    ]
    task = prompt(
        "stage_one_task",
        sentence=quoted(sentence),
        camera=facts.camera_line(state),
        points="\n".join(points) or "none",
        scene=facts.scene_lines(state),
        findings=facts.finding_lines(evidence.scene.findings),
    )
    parts: list[Part] = [task]
    if photo is not None and view is not None:
        pair = side_by_side(marked(photo, clicks), view, ("photograph", "reconstruction"))
        parts.append(Picture(pair, "the photograph with its points, beside the reconstruction"))
    elif photo is not None:
        parts.append(Picture(marked(photo, clicks), "the photograph with its points"))
    else:
        parts.append("There is no photograph; judge from the figures.")
    return (_system("stage_one"), Turn("user", tuple(parts)))


def _rollout_turns(
    evidence: RolloutEvidence, sentence: str, style: Literal["sheet", "images"]
) -> tuple[Turn, ...]:
    program, rollout = evidence.program, evidence.rollout
    clauses = [f"{clause.id}: {clause.text}" for clause in program.contract.clauses]
    pictures = _pictures(evidence, style)
    seen = f"{len(evidence.frames)} sampled frames follow." if pictures else "No pictures are given"
    task = prompt(
        "stage_two_task",
        sentence=quoted(sentence),
        clauses=quoted("\n".join(clauses) or "none"),
        actions=facts.action_lines(program, rollout),
        checks=facts.check_lines(evidence.checks, program),
        motion=facts.motion_lines(rollout),
        pictures=seen if pictures else f"{seen}; judge from the facts.",
    )
    return (_system("stage_two"), Turn("user", (task, *pictures)))


def _pictures(evidence: RolloutEvidence, style: Literal["sheet", "images"]) -> tuple[Picture, ...]:
    frames, rollout = evidence.frames, evidence.rollout
    if not frames:
        return ()
    every = max(1, round((rollout.frames - 1) / max(1, len(frames) - 1)))
    seconds = rollout.step_seconds * rollout.steps_per_frame
    labels = [f"x{i * every + 1}  {i * every * seconds:.2f} s" for i in range(len(frames))]
    if style == "sheet":
        return (Picture(contact_sheet(frames, labels), "the sampled frames in order"),)
    return tuple(Picture(frame, label) for frame, label in zip(frames, labels, strict=True))


# --- what becomes of it ----------------------------------------------------------------------


def scene_assessment(reply: StageOneReply, findings: tuple[Finding, ...]) -> Assessment:
    """Passes only where the model and the measured findings agree that it does."""
    failing = [item for item in findings if not item.ok]
    contradiction = ""
    if reply.passed and failing:
        texts = "; ".join(item.text for item in failing[:3])
        contradiction = f"the model passes the reconstruction, but it was measured: {texts}"
    aspects = ("points", "shapes", "placement", "supports", "camera")
    criteria = [(name, getattr(reply, name)) for name in aspects]
    seen = tuple(
        Mismatch(code=item.code, text=item.text, subject=item.subject) for item in reply.mismatches
    )
    return Assessment(
        stage="reconstruction",
        passed=reply.passed and not failing,
        checks=tuple(_check(item) for item in findings),
        criteria=tuple(Criterion(name=n, ok=s.ok, reason=s.reason) for n, s in criteria),
        diagnosis=(*seen, *map(_finding_mismatch, failing), *_flag(contradiction)),
        author=AUTHOR,
        contradiction=contradiction,
    )


def rollout_assessment(reply: StageTwoReply, evidence: RolloutEvidence) -> Assessment:
    """Passes only where the model and the measured contract agree that it does."""
    failing = _failing(evidence.checks)
    contradiction = _contradiction(reply, evidence, failing)
    said = [(name, getattr(reply, name.replace(" ", "_"))) for name in CRITERIA]
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
    measured = tuple(_check_mismatch(check, evidence.program) for check in failing)
    return Assessment(
        stage="simulation",
        passed=reply.passed and not failing,
        checks=evidence.checks,
        criteria=tuple(Criterion(name=n, ok=s.ok, reason=s.reason) for n, s in said),
        clauses=tuple(
            Criterion(name=texts[item.clause], ok=item.ok, reason=item.reason)
            for item in reply.clauses
        ),
        diagnosis=(*seen, *measured, *_flag(contradiction)),
        untested=tuple(clause.text for clause in evidence.program.contract.untested),
        author=AUTHOR,
        contradiction=contradiction,
    )


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
    "blow_up": "blow_up",
}  # fmt: skip
_DENIED = {"contacts": "unwanted_contact", "topples": "toppled", "moves": "moved"}


def _check_mismatch(check: Check, program: PhysicalProgram) -> Mismatch:
    """The figures of a failed check; the code of the kind of thing that went wrong."""
    statement = next((one for one in program.contract.statements if one.id == check.id), None)
    negated = statement is not None and statement.negated
    code = (_DENIED if negated else _CODES).get(check.kind, "fails")
    figures = {"margin": check.margin}
    if check.measured is not None:
        figures["measured"] = check.measured
    if check.threshold is not None:
        figures["threshold"] = check.threshold
    return Mismatch(
        code=code,
        text=check.text,
        subject=str(getattr(statement, "subject", "") or ""),
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


def _no_scene_verdict(evidence: SceneEvidence, why: str) -> Assessment:
    failing = [item for item in evidence.scene.findings if not item.ok]
    return Assessment(
        stage="reconstruction",
        passed=False,
        checks=tuple(_check(item) for item in evidence.scene.findings),
        diagnosis=(_no_verdict(why), *map(_finding_mismatch, failing)),
        author=AUTHOR,
    )


def _no_rollout_verdict(evidence: RolloutEvidence, why: str) -> Assessment:
    failing = _failing(evidence.checks)
    reason = f"no verdict: {why}"
    return Assessment(
        stage="simulation",
        passed=False,
        checks=evidence.checks,
        criteria=tuple(Criterion(name=name, ok=False, reason=reason) for name in CRITERIA),
        diagnosis=(_no_verdict(why), *(_check_mismatch(c, evidence.program) for c in failing)),
        untested=tuple(clause.text for clause in evidence.program.contract.untested),
        author=AUTHOR,
    )


def _no_verdict(why: str) -> Mismatch:
    return Mismatch(code="no_verdict", text=f"no verdict: {why}")
