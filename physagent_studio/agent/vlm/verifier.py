"""`VlmVerifier`: judges from pictures and measured facts; a contradiction is flagged."""

from dataclasses import dataclass
from typing import Literal

from physagent_studio.agent.vlm import facts
from physagent_studio.agent.vlm.dialogue import converse
from physagent_studio.agent.vlm.forms import StageOneReply, StageTwoReply
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import (
    Invalid,
    Part,
    Picture,
    Turn,
    VlmError,
    prompt,
    quoted,
)
from physagent_studio.agent.vlm.pictures import side_by_side
from physagent_studio.agent.vlm.verdicts import (
    no_rollout_verdict,
    no_scene_verdict,
    rollout_assessment,
    scene_assessment,
)
from physagent_studio.records import Assessment, Evidence, RolloutEvidence, SceneEvidence
from physagent_studio.rendering.sheets import contact_sheet, marked


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
        known = set(evidence.program.scene.names)

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
            return no_scene_verdict(evidence, str(error))
        return scene_assessment(reply, findings)

    # --- stage 2 -----------------------------------------------------------------------------

    def _rollout(self, evidence: RolloutEvidence, sentence: str) -> Assessment:
        program = evidence.program
        known = set(program.scene.names)
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
            return no_rollout_verdict(evidence, str(error))
        return rollout_assessment(reply, evidence)


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
