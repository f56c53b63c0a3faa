"""A process that works on a session until it is killed, and says what was acknowledged to it.

`nursery` forks one for each line that it reads, so that a kill costs no start of an interpreter.
"""

import os
import random
import sys
import time
from pathlib import Path
from typing import Any

from physagent_studio.agent.vlm import Answers, Endpoint, Ledger, Limits, wire
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Answer, Question, Turn
from physagent_studio.assets import assets_dir
from physagent_studio.errors import StudioError
from physagent_studio.exchange import load_case
from physagent_studio.program import SetField
from physagent_studio.records import LoopState
from physagent_studio.session import Session, Store, archive
from physagent_studio.workbench import commands
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.engine import Control
from physagent_studio.workbench.journal import carry_out
from physagent_studio.workbench.rendering import render_rollout

ACTIVITIES = ("edit", "edit", "step", "decide", "undo", "redo", "export", "render", "ask", "new")
ANSWER_SECONDS = 0.05
"""How long the model that is asked takes to answer."""


def nursery() -> None:
    """For each line on standard input, root, session and seed, a process; prints its number."""
    for line in sys.stdin:
        root, session, seed = line.split()
        pid = os.fork()
        if pid == 0:
            try:
                _work(Path(root), session, random.Random(int(seed)))
            finally:
                os._exit(1)
        print(pid, flush=True)
        os.waitpid(pid, 0)
        print("gone", flush=True)


class _Notes:
    """Lines in a file of which each is there as soon as it is written, whoever is killed then."""

    def __init__(self, path: Path) -> None:
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)

    def write(self, *words: object) -> None:
        os.write(self._file, (" ".join(map(str, words)) + "\n").encode())


def last_entry(session: Session) -> tuple[int, str]:
    """Number and link of the newest entry of a session's log: both stand for all before."""
    row = session._db.execute("SELECT seq, link FROM log ORDER BY seq DESC LIMIT 1").fetchone()
    return (0, "-") if row is None else (int(row[0]), str(row[1]))


def _work(root: Path, session_id: str, rng: random.Random) -> None:
    notes, began = _Notes(root / "notes"), time.monotonic()
    store = Store(root)
    desk = Desk(store.open(session_id), Control(), evidence=False)
    notes.write("ready", round(time.monotonic() - began, 4))
    while True:
        kind = rng.choice(ACTIVITIES)
        notes.write("begins", kind)
        try:
            _do(kind, desk, store, rng, notes)
        except StudioError as error:
            notes.write("said", type(error).__name__)
        notes.write("kept", len(desk.session.load().rounds), *last_entry(desk.session))


def _do(kind: str, desk: Desk, store: Store, rng: random.Random, notes: _Notes) -> None:
    if kind == "edit":
        edit = SetField(path="event.actions.go.velocity.0", value=round(rng.uniform(0.1, 2), 3))
        carry_out(desk, commands.ApplyEdits((edit,)), "bench")
    elif kind == "decide" and (head := desk.state.current) is not None and head.proposal:
        carry_out(desk, commands.Decide("accept", head.proposal.id), "bench")
    elif kind in ("step", "undo", "redo"):
        acts = {"step": commands.Step(), "undo": commands.Undo(), "redo": commands.Redo()}
        carry_out(desk, acts[kind], "bench")
    elif kind == "export":
        archive.export(desk.session, store.root / "export.physagent")
    elif kind == "render":
        render_rollout(desk, store.root / "clip.mp4")
    elif kind == "ask":
        _ask(desk.session, rng, notes)
    elif kind == "new":
        case = load_case(assets_dir() / "demo")
        fresh = Desk(store.create(case, LoopState(), title="fresh"), Control(), evidence=False)
        carry_out(fresh, commands.Advance(until="simulate"), "bench")
        fresh.session.close()


def _ask(session: Session, rng: random.Random, notes: _Notes) -> None:
    """A question to a model that notes that it was asked; few questions, so that they recur."""
    question = Question("bench", (Turn("user", (f"question {rng.randrange(50)}",)),), "Reply", {})
    key = question.key("model")[:16]

    def answers(*_given: Any) -> Answer:
        notes.write("asked", key)
        time.sleep(ANSWER_SECONDS)
        return Answer("yes")

    line = Line("planner", Endpoint(base_url="http://127.0.0.1:1", model="model"), Ledger(Limits()))
    line.kept = Answers(session.answer, session.keep_answer)
    wire.send = answers
    line.ask(question)
    notes.write("arrived", key)


if __name__ == "__main__":
    nursery()
