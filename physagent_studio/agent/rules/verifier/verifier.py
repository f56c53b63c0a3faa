"""V: judges the reconstruction and the rollout from measured facts; never proposes."""

from physagent_studio.agent.rules.verifier.diagnosing import mismatches, stage_one_mismatch
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.records import (
    CRITERIA,
    Assessment,
    Check,
    Criterion,
    Evidence,
    Finding,
    RolloutEvidence,
    Scene,
    SceneEvidence,
)


class RuleVerifier:
    """Passes a stage only when everything that is demanded of it holds."""

    def judge(self, evidence: Evidence, prompt: str) -> Assessment:
        """The verdict on one stage; `prompt` is judged through the program's contract."""
        if isinstance(evidence, SceneEvidence):
            return judge_scene(evidence)
        return judge_rollout(evidence)


# --- stage 1 -------------------------------------------------------------------------------------


def judge_scene(evidence: SceneEvidence) -> Assessment:
    """Every finding holds; an estimated camera is reported and not failed."""
    findings = evidence.scene.findings
    scene = evidence.scene
    checks = tuple(_of_finding(f, number, scene) for number, f in enumerate(findings))
    failing = [f for f in findings if not f.ok and not _only_reported(f, scene)]
    return Assessment(
        stage="reconstruction",
        passed=not failing and evidence.scene.state.is_resolved,
        checks=checks,
        diagnosis=tuple(stage_one_mismatch(f) for f in failing),
        untested=tuple(
            f"{'unconfirmed' if f.kind == 'camera' else 'rough'}: {f.text}"
            for f in findings
            if not f.ok and _only_reported(f, scene)
        ),
    )


def shortfall(scene: Scene) -> float:
    """How badly the demanded findings of a scene fail, summed; 0 where stage 1 holds."""
    checks = [_of_finding(f, n, scene) for n, f in enumerate(scene.findings)]
    return sum(min(-c.margin, 10.0) for c in checks if c.demanded and not c.ok)


def _is_estimated(scene: Scene) -> bool:
    """Whether the camera is an estimate that nobody has confirmed."""
    camera = scene.state.camera
    return camera is not None and not camera.confirmed and camera.source in ("estimated", "assumed")


def _only_reported(finding: Finding, scene: Scene) -> bool:
    """What is said aloud but does not stop the event.

    An estimated camera states how uncertain it is, and nothing else in the picture can settle
    it; a camera that somebody gave has to fit. A silhouette that is only rough still has the
    thing in its place. What hardly stands out in a box that a person drew is there all the same,
    and of what is a board, the last resort, nothing more can be mended: both are doubted.
    """
    item = scene.state.object(finding.subject)
    if item is not None and item.form == "board" and finding.name != "mask":
        return True
    if finding.name == "stands out":
        return item is not None and item.grounding.box is not None
    min_rough_iou = 0.35  # IoU, 0.2..0.7: with its mask, that shows the right thing in place
    if finding.name == "reprojection":
        return finding.measured >= min_rough_iou
    return finding.kind == "camera" and _is_estimated(scene)


def _of_finding(finding: Finding, number: int, scene: Scene) -> Check:
    scale = max(abs(finding.threshold), 1e-6)
    distance = min(abs(finding.measured - finding.threshold) / scale, 10.0)
    reported = _only_reported(finding, scene)
    return Check(
        id=f"{finding.kind}.{finding.name}.{finding.subject or number}",
        text=finding.text,
        ok=finding.ok,
        measured=finding.measured,
        threshold=finding.threshold,
        unit=finding.unit,
        margin=distance if finding.ok else -max(distance, 1e-6),
        kind=finding.kind,
        demanded=not reported,
    )


# --- stage 2 -------------------------------------------------------------------------------------

_GROUPS: dict[str, frozenset[str]] = {
    "object trajectory": words_of(
        "moves falls lands_in passes_over stays stops stops_before reaches rests_on leaves "
        "descends_slowly speed_between path_bends reverses view covers side_of"
    ),
    "contact timing": words_of("contacts before airborne bounces in_turn together"),
    "force direction": words_of("cause energy"),
    "material response": words_of(
        "topples upright flips rotates deforms spreads breaks sways penetration sink blow_up"
    ),
}


def judge_rollout(evidence: RolloutEvidence) -> Assessment:
    """The contract, the physics and the view."""
    program, rollout = evidence.program, evidence.rollout
    checks = evidence.checks
    demanded = [c for c in checks if c.demanded]
    stated = [c for c in demanded if not c.always_on]
    return Assessment(
        stage="simulation",
        passed=bool(stated) and all(c.ok for c in demanded),
        checks=checks,
        criteria=criteria(evidence, checks),
        diagnosis=mismatches(program, rollout, checks),
        untested=(
            *(clause.text for clause in program.contract.untested),
            *(f"“{word}” was not understood" for word in program.contract.not_understood),
        ),
    )


def criteria(evidence: RolloutEvidence, checks: tuple[Check, ...]) -> tuple[Criterion, ...]:
    """The paper's four, each with the checks that speak of it."""
    directed = {
        s.id
        for s in evidence.program.contract.statements
        if getattr(s, "direction", None) or getattr(s, "toward", None) or getattr(s, "side", None)
    }
    found = []
    for name in CRITERIA:
        mine = [c for c in checks if c.demanded and _speaks_of(c, name, directed)]
        failing = [c for c in mine if not c.ok]
        if name == "contact timing":
            never = [s.id for s in evidence.rollout.spans if s.start is None]
            reason = f"{never[0]} never started" if never and failing else ""
        else:
            reason = ""
        reason = reason or "; ".join(c.text for c in failing[:3]) or _all_hold(mine)
        found.append(Criterion(name=name, ok=not failing, reason=reason))
    return tuple(found)


def _speaks_of(check: Check, criterion: str, directed: set[str]) -> bool:
    if criterion == "force direction" and check.id in directed:
        return True
    if check.kind in ("any_of", "all_of", "count_of"):
        return criterion == "object trajectory"
    return check.kind in _GROUPS[criterion]


def _all_hold(checks: list[Check]) -> str:
    if not checks:
        return "nothing is demanded of it"
    return f"{len(checks)} check{'s' if len(checks) > 1 else ''} hold"
