"""Run: which session this is, what is happening, and what may be done next."""

from __future__ import annotations

from typing import Any

from physagent_studio.studio.panels.rounds import OUTCOMES
from physagent_studio.workbench import Snapshot

PHASES = {
    "generate": "ready to start",
    "reconstruct": "next: look at the scene",
    "simulate": "next: run the event",
    "propose": "next: think of a repair",
    "decide": "waiting for your decision",
    "revise": "next: apply the decision",
    "done": "done",
}


def state_of(snapshot: Snapshot) -> dict[str, Any]:
    """Title, sentence, progress, policy and budget."""
    loop, case = snapshot.state, snapshot.case
    return {
        "session": snapshot.session_id,
        "title": snapshot.title,
        "prompt": snapshot.program.event.prompt or (case.prompt if case else ""),
        "event": case.event if case else "",
        "busy": snapshot.busy,
        "progress": snapshot.progress,
        "phase": loop.phase,
        "doing": PHASES.get(loop.phase, loop.phase),
        "outcome": OUTCOMES[loop.outcome],
        "realised": loop.outcome == "realised",
        "policy": loop.policy,
        "budget": loop.budget,
        "used": len(loop.path()),
        "simulations": sum(item.simulations for item in loop.rounds),
        "canUndo": snapshot.can_undo,
        "canRedo": snapshot.can_redo,
        "draft": snapshot.has_draft,
        "readOnly": snapshot.read_only,
        "rounds": len(loop.rounds),
        "started": any(item.rollout is not None for item in loop.rounds),
    }
