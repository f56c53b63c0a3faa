"""What is being done, in the words in which a person is told of it."""

from __future__ import annotations

from physagent_studio.records import LoopState

RUNNING = {
    "generate": "reading the photo and the sentence",
    "reconstruct": "reconstructing the scene",
    "simulate": "simulating",
    "propose": "searching for a repair",
    "ease": "looking for a gentler way",
}
"""Phase → what is being done in it; the others take no time."""
STEPS = {
    "masks": "finding the outlines of things",
    "camera": "finding where the camera stood",
    "supports": "finding what things stand on",
    "objects": "building the things",
    "textures": "taking their looks from the photo",
    "background": "filling in what is behind them",
    "checks": "holding the scene against the photo",
}
"""Steps of a reconstruction."""


def doing_in(state: LoopState) -> str:
    """What the phase of a state does, with its round: in one that a proposal made, what it tries.

    "" for a phase that takes no time.
    """
    current, doing = state.current, RUNNING.get(state.phase)
    if doing is None or current is None:
        return doing or ""
    if state.phase == "reconstruct" and (tried := _tried(state)):
        doing = f"trying {tried}"
    return f"round {current.number}: {doing}"


def _tried(state: LoopState) -> str:
    """The changes that made the newest round; "" where no proposal did."""
    made_from = state.current.parent if state.current else None
    before = next((one for one in state.rounds if one.id == made_from), None)
    proposal = before.proposal if before is not None else None
    return "; ".join(hunk.summary for hunk in proposal.hunks) if proposal is not None else ""
