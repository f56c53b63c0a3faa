"""kill -9 at random moments of everything that a session goes through, and what was left."""

import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

from physagent_studio.benchmark.durability.victim import last_entry
from physagent_studio.benchmark.rows import Row, at_most, shown
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Case, LoopState
from physagent_studio.session import Store
from physagent_studio.session.care import check

LONGEST_LIFE = 0.6
"""Seconds that a process lives at most after it has opened the session."""
SAVING = ("edit", "step", "decide")
"""What is acknowledged in steps, after each of which a model is asked anew."""
CHECKED_EVERY = 10
"""Kills between two checks of every session there is, row by row and file by file."""


def kills(root: Path, program: PhysicalProgram, times: int) -> list[Row]:
    """Figures over that many kills of processes that work on one session below `root`."""
    case = Case("bench", prompt=program.event.prompt)
    store = Store(root)
    session = store.create(case, LoopState(draft=program), title="bench")
    session.close()
    command = [sys.executable, "-m", "physagent_studio.benchmark.durability.victim"]
    rng, lost, damaged = random.Random(0), 0, 0
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as nursery:  # type: ignore[call-overload]
        for number in range(times):
            _kill_one(nursery, f"{root} {session.id} {number}\n", root / "notes", rng)
            lost += _lost(store, session.id, root / "notes")
            if number % CHECKED_EVERY == CHECKED_EVERY - 1 or number == times - 1:
                damaged += sum(bool(check(store.folder_of(one.id))) for one in store.list())
        assert nursery.stdin is not None
        nursery.stdin.close()
    return [
        at_most(f"acknowledged rounds and decisions lost, {times} kills", lost, 0),
        at_most(f"sessions damaged, {times} kills", damaged, 0),
        *_from_notes((root / "notes").read_text().splitlines(), times),
    ]


def _kill_one(nursery: subprocess.Popen[str], order: str, notes: Path, rng: random.Random) -> None:
    assert nursery.stdin is not None
    assert nursery.stdout is not None
    ready = _count(notes)
    nursery.stdin.write(order)
    nursery.stdin.flush()
    pid = int(nursery.stdout.readline())
    while _count(notes) == ready:
        time.sleep(0.002)
    time.sleep(rng.uniform(0, LONGEST_LIFE))
    os.kill(pid, signal.SIGKILL)
    nursery.stdout.readline()
    with notes.open("a") as stream:
        stream.write("killed\n")


def _count(notes: Path) -> int:
    return notes.read_text().count("ready") if notes.exists() else 0


def _lost(store: Store, session_id: str, notes: Path) -> int:
    """How much of what was last acknowledged is not there, or is not what it was."""
    kept = [line.split() for line in notes.read_text().splitlines() if line.startswith("kept")]
    if not kept:
        return 0
    _, rounds, seq, chain = kept[-1]
    session = store.open(session_id, writing=False)
    try:
        there = len(session.load().rounds)
        row = session._db.execute("SELECT link FROM log WHERE seq = ?", (int(seq),)).fetchone()
        same = int(seq) == 0 or (row is not None and row[0] == chain)
        return max(int(rounds) - there, 0) + (not same) + (last_entry(session)[0] < int(seq))
    finally:
        session.close()


def _from_notes(lines: list[str], times: int) -> list[Row]:
    """Repeated calls, times to open, and what was cut short."""
    arrived: set[str] = set()
    flying, again, open_ones, doing, cut = Counter[str](), 0, [], "", Counter[str]()
    for line in lines:
        word, *rest = line.split()
        if word == "ready":
            open_ones.append(float(rest[0]))
        elif word == "begins":
            doing = rest[0]
        elif word == "asked":
            again += rest[0] in arrived
            flying[rest[0]] += 1
        elif word == "arrived":
            arrived.add(rest[0])
            del flying[rest[0]]
        elif word == "kept" and doing != "ask":
            # A phase was acknowledged or has failed: its answers have had their effect.
            arrived.clear()
        elif word == "killed":
            cut[doing or "open"] += 1
            if doing in SAVING:
                # Whether it was acknowledged before the kill is not known here.
                arrived.clear()
            doing = ""
    spread = ", ".join(f"{kind} {count}" for kind, count in sorted(cut.items()))
    most = max((count - 1 for count in flying.values()), default=0)
    return [
        at_most(f"calls repeated whose answer had arrived, {times} kills", again, 0),
        at_most("calls in flight at a kill that were repeated, most for one", most, 1),
        at_most("seconds to open after a kill, longest", max(open_ones), 2.0, "s"),
        shown("what the kills cut short", spread),
    ]
