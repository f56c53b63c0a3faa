"""`memory_of`: what the rounds on the path to the head have taught, small enough for a planner."""

import itertools
from collections.abc import Iterable

from physagent_studio.errors import EditError
from physagent_studio.program import PhysicalProgram, SetField, value_at
from physagent_studio.records import (
    Decision,
    Lesson,
    LoopState,
    Memory,
    MemoryEntry,
    Proposal,
    Round,
)

# What a passed stage 1 vouches for. Material, density and friction are not seen in a photo.
_VERIFIED_BY_STAGE_ONE = (
    ("objects", ("grounding", "shape", "position", "rotation", "support")),
    ("supports", ("grounding", "shape")),
)


def memory_of(state: LoopState) -> Memory:
    """The memory at the head: entries along its path, everything tried anywhere in the tree."""
    path = state.path()
    entries = tuple(
        _entry(before, after) for before, after in itertools.pairwise(path) if after.origin
    )
    rejected = tuple(
        (proposal, decision.reason) for item in path for proposal, decision in item.rejected
    )
    ran = tuple(item.program.hash for item in state.rounds if item.assessment is not None)
    return Memory(
        entries=entries,
        pinned=state.pinned,
        verified=(*verified_paths(path), *set_by_hand(path)),
        tried=ran,
        hints=(*state.hints, *_overruling(path)),
        rejected=rejected,
        lessons=state.lessons,
        said=_said(path[-1]) if path else "",
    )


def _said(head: Round) -> str:
    """What a person said last of a round: why a proposal was turned down, or a verdict."""
    if head.rejected:
        decision = head.rejected[-1][1]
        return decision.reason if decision.author == "person" else ""
    override = head.override
    return override.words if override is not None and not override.passed else ""


def lessons_of(state: LoopState) -> tuple[Lesson, ...]:
    """What all decisions of a session taught, in the order of its rounds, for the next one."""
    by_id = {item.id: item for item in state.rounds}
    found: list[Lesson] = []
    for item in state.rounds:
        before = by_id.get(item.parent or "")
        if before is not None and item.origin is not None:
            found += _lesson(before, before.proposal, item.origin, item)
        for proposal, decision in item.rejected:
            found += _lesson(item, proposal, decision, None)
    return tuple(found)


def _lesson(
    before: Round, proposal: Proposal | None, decision: Decision, after: Round | None
) -> list[Lesson]:
    """One lesson, or none where nothing failed or it is not told what was changed."""
    diagnosis = before.assessment.diagnosis if before.assessment else ()
    by_hand = decision.kind in ("override", "edit")
    factor = "by hand" if by_hand else proposal.factor if proposal and proposal.hunks else ""
    if not diagnosis or not factor:
        return []
    return [
        Lesson(
            mismatch=diagnosis[0].code[:60],
            factor=factor[:60],
            decided=decision.kind,
            failing_before=_failing(before),
            failing_after=_failing(after) if after and after.assessment else None,
            reason=decision.reason[:500] if decision.author == "person" else "",
        )
    ]


def _failing(item: Round) -> int:
    checks = item.assessment.checks if item.assessment else ()
    return sum(check.demanded and not check.ok for check in checks)


def _entry(before: Round, after: Round) -> MemoryEntry:
    proposal, origin = before.proposal, after.origin
    assert origin is not None
    return MemoryEntry(
        round=after.id,
        factor=proposal.factor if proposal else "",
        rationale=proposal.rationale if proposal else "",
        edits=origin.edits,
        decided=origin.kind,
        reason=origin.reason,
        margins_before=_margins(before),
        margins_after=_margins(after),
    )


def _overruling(path: tuple[Round, ...]) -> tuple[str, ...]:
    """A person's words against verdicts that held."""
    overrides = [item.override for item in path if item.override is not None]
    return tuple(one.words for one in overrides if one.words and not one.passed)


def set_by_hand(path: tuple[Round, ...]) -> tuple[str, ...]:
    """Paths that a person has set on the way to the head; the agent changes them last.

    Unlike a pin they are no order: where nothing else helps, a proposal may say that it
    touches them.
    """
    origins = [item.origin for item in path if item.origin is not None]
    edits = [e for one in origins if one.kind in ("override", "edit") for e in one.edits]
    return tuple(dict.fromkeys(e.path for e in edits if isinstance(e, SetField)))


def _margins(item: Round) -> dict[str, float]:
    checks = item.assessment.checks if item.assessment else ()
    return {check.id: check.margin for check in checks}


def changed_among(
    paths: Iterable[str], before: PhysicalProgram, after: PhysicalProgram
) -> tuple[str, ...]:
    """Those of the paths whose value differs between two programs, or can no longer be found."""
    return tuple(path for path in paths if _found(before, path) != _found(after, path))


def _found(program: PhysicalProgram, path: str) -> object:
    try:
        return value_at(program, path)
    except EditError:
        return _NOWHERE


_NOWHERE = object()


def verified_paths(path: tuple[Round, ...]) -> tuple[str, ...]:
    """Paths of the scene that stage 1 has passed at the head, a person's word going first."""
    last = path[-1] if path else None
    if last is None or last.assessment is None:
        return ()
    if last.assessment.stage == "reconstruction" and not last.scene_holds:
        return ()
    scene = last.program.scene
    found = ["scene.camera"]
    for room, fields in _VERIFIED_BY_STAGE_ONE:
        for item in getattr(scene, room):
            found += [f"scene.{room}.{item.name}.{field}" for field in fields]
    return tuple(found)
