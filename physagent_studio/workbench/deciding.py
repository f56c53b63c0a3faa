"""A person's acts on a state of the loop, as values: decisions, verdicts, forks."""

from physagent_studio.agent import loop
from physagent_studio.agent.by_hand import in_order, without_schedule
from physagent_studio.errors import InputError
from physagent_studio.program import Edit
from physagent_studio.program.text.diff import diff
from physagent_studio.records import Decision, LoopState, Override, Round
from physagent_studio.records.loop_state import RoleName
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
        edits=tuple(edit for hunk in diff(head.program, draft) for edit in hunk.edits),
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
    update = {
        "head": item.id,
        "draft": None,
        "phase": _phase_of(state, item),
        "outcome": "realised" if item.passed else "running",
    }
    return state.model_copy(update=update)


def _phase_of(state: LoopState, item: Round) -> str:
    """Where the loop goes on from a round."""
    if item.assessment is None:
        return "reconstruct"
    if item.proposal is not None and not item.passed:
        return "decide"
    if "verifier" in state.by_hand and item.ruling is None:
        return "judge"
    return "done" if item.passed else "simulate" if item.scene_holds else "propose"


def overruled(state: LoopState, override: Override) -> LoopState:
    """The state with a person's verdict on the stage that its head was judged by last.

    It goes before the measured one: a stage that holds leads on, one that does not to a repair.
    """
    item = state.current
    if item is None or item.assessment is None:
        raise InputError("there is no verdict to overrule yet")
    override = override.model_copy(update={"stage": item.assessment.stage})
    update: dict[str, object] = {"override": override}
    if override.passed and item.assessment.stage == "reconstruction":
        # What repaired the scene has no object any more.
        update |= {"proposal": None, "preview": None}
    after = loop.replace_round(state, item.model_copy(update=update))
    if override.passed or state.phase == "judge":
        return loop.after_verdict(after)
    if after.phase in ("done", "simulate"):
        return after.model_copy(update={"phase": "propose", "outcome": "running"})
    return after


def with_role(state: LoopState, role: RoleName, *, on: bool) -> LoopState:
    """The state in which a person plays this role too, or the agent does again.

    A first program that has not run yet is given up to a person in the generator's role: its
    scene and demands become the draft, with nothing scheduled.
    """
    others = [one for one in state.by_hand if one != role]
    roles = in_order([*others, role] if on else others)
    head, update = state.current, dict[str, object](by_hand=roles)
    new = role == "generator" and on and "generator" not in state.by_hand
    ran = any(item.rollout is not None for item in state.rounds)
    if new and head is not None and state.draft is None and not ran:
        update["draft"] = without_schedule(head.program)
    return state.model_copy(update=update)


def _decided_edits(command: commands.Decide, item: Round) -> tuple[Edit, ...]:
    """The edits that a decision applies: whole, by hunks, or the person's own."""
    assert item.proposal is not None
    if command.kind == "accept":
        return item.proposal.edits
    if command.kind == "accept_hunks":
        unknown = set(command.hunks) - {hunk.id for hunk in item.proposal.hunks}
        if unknown:
            raise InputError(f"the proposal has no change called {', '.join(sorted(unknown))}")
        chosen = [hunk for hunk in item.proposal.hunks if hunk.id in command.hunks]
        if not chosen:
            raise InputError("tick at least one change, or reject the proposal")
        return tuple(edit for hunk in chosen for edit in hunk.edits)
    if command.kind in ("override", "edit"):
        if not command.edits:
            raise InputError("an override needs at least one edit of yours")
        return command.edits
    return ()
