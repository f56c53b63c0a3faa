"""A person's acts on a state of the loop, as values: decisions, verdicts, forks."""

from __future__ import annotations

from physagent_studio.agent import loop
from physagent_studio.errors import InputError
from physagent_studio.program import Edit, PhysicalProgram
from physagent_studio.program.diff import diff
from physagent_studio.records import Decision, LoopState, Override, Round
from physagent_studio.session.session import now
from physagent_studio.workbench import commands


def with_draft_as_round(state: LoopState) -> LoopState:
    """The state whose draft has become the next round, decided by the person's own hand."""
    head, draft = state.current, state.draft
    if draft is None or head is None:
        return state
    origin = Decision(
        kind="override",
        author="person",
        at=now(),
        reason="edited by hand",
        edits=_edits_between(head.program, draft),
        before=head.program.hash,
        after=draft.hash,
    )
    return loop.add_round(state, draft, "person", origin)


def taken_up_again(state: LoopState) -> LoopState:
    """The state of a loop that had ended without success, about to look for another repair."""
    item = state.current
    if item is None or item.assessment is None:
        return state.model_copy(update={"phase": "reconstruct", "outcome": "running"})
    more = len(state.path()) + 5 if state.outcome == "budget" else state.budget
    update = {"phase": "propose", "outcome": "running", "budget": more}
    return state.model_copy(update=update)


def decided(state: LoopState, item: Round, command: commands.Decide) -> LoopState:
    """The state after a decision on the proposal of its head, `item`."""
    decision = Decision(
        kind=command.kind,
        author=command.author,
        at=now(),
        reason=command.reason,
        hunks=command.hunks,
        edits=_decided_edits(command, item),
    )
    return loop.decide(state.model_copy(update={"phase": "decide"}), decision)


def forked(state: LoopState, round_id: str) -> LoopState:
    """The state that goes on from an earlier round; its draft is gone."""
    item = next((one for one in state.rounds if one.id == round_id), None)
    if item is None:
        raise InputError(f"there is no round '{round_id}'")
    phase = "decide" if item.proposal is not None else "propose"
    update = {
        "head": item.id,
        "draft": None,
        "phase": "done" if item.passed else phase if item.assessment else "reconstruct",
        "outcome": "realised" if item.passed else "running",
    }
    return state.model_copy(update=update)


def overruled(state: LoopState, override: Override) -> LoopState:
    """The state with a person's verdict beside the measured one of its head."""
    item = state.current
    if item is None or item.assessment is None:
        raise InputError("there is no verdict to overrule yet")
    after = loop.replace_round(state, item.model_copy(update={"override": override}))
    if override.passed:
        return after.model_copy(update={"phase": "done", "outcome": "realised"})
    if after.phase == "done":
        return after.model_copy(update={"phase": "propose", "outcome": "running"})
    return after


def _edits_between(before: PhysicalProgram, after: PhysicalProgram) -> tuple[Edit, ...]:
    return tuple(edit for hunk in diff(before, after) for edit in hunk.edits)


def _decided_edits(command: commands.Decide, item: Round) -> tuple[Edit, ...]:
    """The edits that a decision applies: whole, by hunks, or the person's own."""
    assert item.proposal is not None
    if command.kind == "accept":
        return item.proposal.edits
    if command.kind == "accept_hunks":
        unknown = set(command.hunks) - {hunk.id for hunk in item.proposal.hunks}
        if unknown:
            raise InputError(f"the proposal has no hunk {', '.join(sorted(unknown))}")
        chosen = [hunk for hunk in item.proposal.hunks if hunk.id in command.hunks]
        if not chosen:
            raise InputError("select at least one hunk, or reject the proposal")
        return tuple(edit for hunk in chosen for edit in hunk.edits)
    if command.kind in ("override", "edit"):
        if not command.edits:
            raise InputError("an override needs at least one edit of yours")
        return command.edits
    return ()
