"""`memory_of`: what the rounds on the path to the head have taught, small enough for a planner."""

from __future__ import annotations

import itertools

from physagent_studio.program import SetField
from physagent_studio.records import LoopState, Memory, MemoryEntry, Round

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
    )


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


def verified_paths(path: tuple[Round, ...]) -> tuple[str, ...]:
    """Paths of the scene that stage 1 has passed on the way to the head."""
    last = path[-1] if path else None
    if last is None or last.assessment is None:
        return ()
    if last.assessment.stage == "reconstruction" and not last.assessment.passed:
        return ()
    scene = last.program.scene
    found = ["scene.camera"]
    for room, fields in _VERIFIED_BY_STAGE_ONE:
        for item in getattr(scene, room):
            found += [f"scene.{room}.{item.name}.{field}" for field in fields]
    return tuple(found)
