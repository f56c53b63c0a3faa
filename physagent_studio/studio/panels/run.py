"""Run: which session this is, what is happening, and what may be done next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from physagent_studio.agent.by_hand import turn_of
from physagent_studio.program.timing import length_in_words
from physagent_studio.records import doubts_of
from physagent_studio.session.standing import IN_DOUBT
from physagent_studio.studio.library import Output
from physagent_studio.studio.panels.rounds import OUTCOMES, RECENT
from physagent_studio.workbench import Snapshot, Spending
from physagent_studio.workbench.doing import STEPS

PHASES = {
    "generate": "ready to start",
    "reconstruct": "next: look at the scene",
    "simulate": "next: run the event",
    "judge": "next: judge what happened",
    "propose": "next: think of a repair",
    "ease": "next: look for a gentler way",
    "decide": "waiting for your decision",
    "revise": "next: apply the decision",
    "done": "done",
}
TURNS = {
    "generator": "your turn: put actions on the timeline, then run them",
    "verifier": "your turn: give your verdict",
    "planner": "your turn: change the program, then run it",
}
"""What a person is to do in a role of theirs."""


def state_of(snapshot: Snapshot, outputs: Sequence[Output] = ()) -> dict[str, Any]:
    """Title, sentence, progress, policy, budget, and what was made of the round on view."""
    loop, case = snapshot.state, snapshot.case
    turn, path, told = turn_of(loop), snapshot.state.path(), snapshot.program.contract
    unsure = told.untested or told.not_understood or doubts_of(snapshot.scene)
    doubted = loop.outcome == "realised" and bool(unsure)
    return {
        "session": snapshot.session_id,
        "title": snapshot.title,
        "prompt": snapshot.program.event.prompt or (case.prompt if case else ""),
        "busy": None if snapshot.busy is None else STEPS.get(snapshot.busy, snapshot.busy),
        "progress": snapshot.progress,
        "phase": loop.phase,
        "doing": TURNS[turn] if turn else PHASES.get(loop.phase, loop.phase),
        "turn": turn or "",
        "byHand": list(loop.by_hand),
        "outcome": f"The event happens, {IN_DOUBT}." if doubted else OUTCOMES[loop.outcome],
        "realised": loop.outcome == "realised",
        "inDoubt": doubted,
        "policy": loop.policy,
        "budget": loop.budget,
        "used": len(path),
        "simulations": sum(item.simulations for item in path[-RECENT:]),
        "canUndo": snapshot.can_undo,
        "canRedo": snapshot.can_redo,
        "draft": snapshot.has_draft,
        "readOnly": snapshot.read_only,
        "rounds": len(loop.rounds),
        "outputs": [
            {
                "kind": one.kind,
                "url": f"file/{one.path.name}",
                "save": one.save,
                "made": str(one.path.stat().st_mtime_ns),
            }
            for one in outputs
            if one.round == snapshot.shown_round and not snapshot.has_draft
        ],
        "clip": length_in_words(snapshot.program.clip),
        "spending": _spending(snapshot.spending),
        "started": any(item.rollout is not None for item in (*path[:1], *loop.rounds[:RECENT])),
    }


def _spending(spent: Spending) -> dict[str, Any]:
    """Time of work in words, and what a model has cost of what it may."""
    rows = []
    if spent.calls or spent.most_calls is not None:
        rows = [
            _meter("Calls", spent.calls, spent.most_calls),
            _meter("Tokens", spent.tokens, spent.most_tokens),
        ]
        if spent.money or spent.most_money is not None:
            rows.append(_meter("Money", spent.money, spent.most_money))
    return {
        "time": duration(spent.seconds),
        "waited": duration(spent.waited) if spent.waited else "",
        "rows": rows,
    }


def _meter(name: str, used: float, most: float | None) -> dict[str, Any]:
    text = f"{used:,}" if isinstance(used, int) else f"{used:.2f}"
    limit = "" if most is None else f"{most:,}" if isinstance(most, int) else f"{most:.2f}"
    share = None if not most else round(min(1.0, used / most), 3)
    return {"name": name, "used": text, "most": limit, "share": share}


def duration(seconds: float) -> str:
    """Seconds as a person says them: 8.2 s, 3 min 20 s, 1 h 5 min."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"
