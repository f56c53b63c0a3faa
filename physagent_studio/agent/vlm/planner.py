"""`VlmPlanner`: assessment and memory → structured edits; never touches a pinned path."""

import hashlib
import json
from dataclasses import dataclass

from physagent_studio.agent.memory import changed_among
from physagent_studio.agent.roles import Situation
from physagent_studio.agent.vlm import facts, paths, reference
from physagent_studio.agent.vlm.dialogue import converse
from physagent_studio.agent.vlm.forms import EventPlan, PlannedEdit, PlannedHunk, ScenePlan
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Invalid, Turn, VlmError, prompt, quoted
from physagent_studio.program import AddItem, Edit, MoveItem, RemoveItem, SetField, apply
from physagent_studio.program.base import overlap
from physagent_studio.records import Hunk, Memory, MemoryEntry, Proposal

AUTHOR = "vlm"
MOST_ENTRIES = 6
MOST_DIGEST = 6000


@dataclass(frozen=True, slots=True)
class VlmPlanner:
    """Proposes a repair. Where no valid one comes: no change, and a question to a person."""

    line: Line

    def propose(self, situation: Situation) -> Proposal:
        """The proposal; raises `Cancelled` alone."""
        stage = situation.assessment.stage
        form = ScenePlan if stage == "reconstruction" else EventPlan

        def check(plan: ScenePlan | EventPlan) -> Proposal:
            return proposal_of(plan, situation)

        try:
            return converse(self.line, "planner.propose", _turns(situation), form, check)
        except VlmError as error:
            return _no_change(situation, str(error))


def _turns(situation: Situation) -> tuple[Turn, ...]:
    program, memory = situation.program, situation.memory
    stage = situation.assessment.stage
    if stage == "reconstruction":
        advice = prompt("plan_scene_advice")
    else:
        advice = prompt(
            "plan_event_advice",
            actions=reference.action_reference(),
            materials=reference.material_reference(),
        )
    task = prompt(
        "plan_task",
        sentence=quoted(program.event.prompt or situation.case.prompt),
        verdict=verdict_lines(situation),
        paths=paths.listing(program, stage),
        pinned=", ".join(memory.pinned) or "nothing",
        verified=", ".join(memory.verified) or "nothing",
        memory=digest(memory),
        hints=quoted("\n".join(memory.hints)) if memory.hints else "none",
    )
    system = prompt("system", part=prompt("plan", advice=advice))
    return (Turn("system", (system,)), Turn("user", (task,)))


# --- what the planner is told ----------------------------------------------------------------


def verdict_lines(situation: Situation) -> str:
    """The assessment and, after a run, the measured motion."""
    assessment, program = situation.assessment, situation.program
    lines = [f"stage: {assessment.stage}; {'passed' if assessment.passed else 'failed'}"]
    lines += [
        f"{item.name}: {'ok' if item.ok else 'NOT OK'} — {item.reason}"
        for item in (*assessment.criteria, *assessment.clauses)
    ]
    lines += [f"what went wrong: [{item.code}] {item.text}" for item in assessment.diagnosis]
    lines += ["measured:", facts.check_lines(assessment.checks, program)]
    if situation.rollout is not None and assessment.stage == "simulation":
        lines += ["motion:", facts.motion_lines(situation.rollout)]
    lines += ["scene:", facts.scene_lines(program.scene)]
    return "\n".join(lines)


def digest(memory: Memory) -> str:
    """The last rounds and what was turned down, short enough to send every time."""
    lines = [_entry(entry) for entry in memory.entries[-MOST_ENTRIES:]]
    left_out = len(memory.entries) - MOST_ENTRIES
    if left_out > 0:
        lines.insert(0, f"({left_out} earlier rounds left out)")
    for proposal, reason in memory.rejected[-MOST_ENTRIES:]:
        edits = "; ".join(spelled(edit) for edit in proposal.edits[:6]) or "no change"
        lines.append(f"turned down: {edits}. Reason: {reason or 'none given'}")
    lines += _lessons(memory)
    return "\n".join(lines)[:MOST_DIGEST] or "nothing"


def _lessons(memory: Memory) -> list[str]:
    """What earlier sessions taught, one line for each pair of mismatch and factor."""
    told: dict[tuple[str, str], list[bool]] = {}
    for lesson in memory.lessons:
        told.setdefault((lesson.mismatch, lesson.factor), []).append(lesson.helped)
    often = sorted(told.items(), key=lambda row: (-len(row[1]), row[0]))[:MOST_ENTRIES]
    return [
        f"in earlier sessions, against {mismatch}: changing {factor} helped"
        f" {sum(helped)} of {len(helped)} times"
        for (mismatch, factor), helped in often
    ]


def _entry(entry: MemoryEntry) -> str:
    edits = "; ".join(spelled(edit) for edit in entry.edits[:8]) or "no edits"
    moved = [
        f"{name} {facts.figure(before)} → {facts.figure(entry.margins_after[name])}"
        for name, before in entry.margins_before.items()
        if name in entry.margins_after and entry.margins_after[name] != before
    ]
    words = f" ({entry.reason})" if entry.reason else ""
    return (
        f"{entry.round}: {entry.factor or 'edit'}, {entry.decided}{words}: {edits}. "
        f"Margins: {', '.join(moved[:12]) or 'unchanged'}"
    )


def spelled(edit: Edit) -> str:
    """An edit in one short line."""
    if isinstance(edit, SetField):
        return f"{edit.path} = {json.dumps(facts.rounded(edit.value))[:200]}"
    if isinstance(edit, AddItem):
        return f"add to {edit.path}: {json.dumps(facts.rounded(edit.item))[:200]}"
    if isinstance(edit, RemoveItem):
        return f"remove {edit.path}"
    return f"move {edit.path} to {edit.index}"


# --- what becomes of the reply ---------------------------------------------------------------


def proposal_of(plan: ScenePlan | EventPlan, situation: Situation) -> Proposal:
    """The plan as a proposal that applies, respects pins and was not tried before.

    Raises `Invalid` or `ProgramError` with what the model has to correct.
    """
    memory, program = situation.memory, situation.program
    if not plan.hunks:
        if not plan.question.strip():
            raise Invalid("hunks is empty, so `question` must ask a person something concrete")
        return _proposal(plan, (), situation)
    hunks = tuple(_hunk(item, index, situation) for index, item in enumerate(plan.hunks))
    edits = [edit for hunk in hunks for edit in hunk.edits]
    revised = apply(program, edits)
    touched = changed_among(memory.pinned, program, revised)
    if touched:
        raise Invalid(f"{', '.join(touched)} is pinned by a person; leave it as it is")
    if revised.hash == program.hash:
        raise Invalid("these edits change nothing")
    if revised.hash in memory.tried:
        raise Invalid("these edits lead to a program that already ran; propose something else")
    return _proposal(plan, hunks, situation)


def _hunk(item: PlannedHunk, index: int, situation: Situation) -> Hunk:
    program, memory = situation.program, situation.memory
    stage = situation.assessment.stage
    edits = tuple(_plain(edit) for edit in item.edits)
    for edit in edits:
        where = paths.target(edit, program)
        if not paths.allowed(edit, program, stage):
            raise Invalid(f"{where}: is not among the paths that may be edited now")
        pinned = next((one for one in memory.pinned if overlap(where, one)), None)
        if pinned is not None:
            raise Invalid(f"{where}: {pinned} is pinned by a person; leave it as it is")
    opened = tuple(
        edit
        for edit in paths.entailed(program, edits)
        if not any(overlap(edit.path, one) for one in memory.pinned)
    )
    return Hunk(id=f"h{index + 1}", summary=item.summary, edits=(*edits, *opened))


def _plain(edit: PlannedEdit) -> Edit:
    """The program's own edit of a planned one, its value as plain data."""
    data = edit.model_dump(mode="json")
    kinds = {"set": SetField, "add": AddItem, "remove": RemoveItem, "move": MoveItem}
    return kinds[data["op"]].model_validate(data)


def _proposal(
    plan: ScenePlan | EventPlan, hunks: tuple[Hunk, ...], situation: Situation
) -> Proposal:
    edits = [edit for hunk in hunks for edit in hunk.edits]
    verified = situation.memory.verified
    touches = any(
        overlap(paths.target(edit, situation.program), one) for edit in edits for one in verified
    )
    content = json.dumps([hunk.model_dump(mode="json") for hunk in hunks], sort_keys=True)
    return Proposal(
        id=_id(situation, content + plan.rationale + plan.question),
        hunks=hunks,
        rationale=plan.rationale,
        factor=plan.factor,
        confidence=plan.confidence,
        touches_verified=touches,
        question=plan.question,
        author=AUTHOR,
    )


def _no_change(situation: Situation, why: str) -> Proposal:
    diagnosis = situation.assessment.diagnosis
    failed = diagnosis[0].text if diagnosis else "the verdict is negative"
    return Proposal(
        id=_id(situation, why),
        hunks=(),
        rationale=f"no change, needs a person: {why}",
        factor="none",
        confidence=0.0,
        question=f"The model gave no usable proposal ({why}). What should change, given that "
        f"{failed}?",
        author=AUTHOR,
    )


def _id(situation: Situation, content: str) -> str:
    """Names a proposal by what it is for and what it says, so that a replay gives the same."""
    turned_down = len(situation.memory.rejected)
    text = f"{situation.program.hash}|{turned_down}|{content}"
    return "vlm-" + hashlib.sha256(text.encode()).hexdigest()[:12]
