"""Cancelling at random moments of everything that takes long: how long until the worker is free."""

from __future__ import annotations

import os
import random
import time
from collections import Counter
from pathlib import Path

from physagent_studio.assets import assets_dir
from physagent_studio.benchmark.rows import Row, at_most, shown
from physagent_studio.jobs import Processes
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands, tasks

OPENING = commands.OpenCase(assets_dir() / "demo", "block_stays_standing")
"""An event of which every phase is long: its first program has to be repaired."""
LONGEST = {"opening": 6.0, "running": 9.0, "rendering": 4.0}
"""Seconds at most between the start of a command and its cancellation."""
PATIENCE = 300.0
"""Seconds for a command that nobody cancels."""


def cancelled(root: Path, times: int) -> list[Row]:
    """Figures over that many cancelled commands: photos opened, steps of the loop, videos."""
    executor, store = Processes(1, keeping=True), Store(root)
    executor.warm(*tasks.MODULES).join()
    workbench = Workbench(store, executor=executor)
    rng, waits, doing = random.Random(0), [], Counter[str]()
    try:
        begun, ended = _prepared(workbench, store)
        for number in range(times):
            kind = ("opening", "running", "rendering")[number % 3]
            command = _command(kind, workbench, store, begun, ended)
            workbench.post(command)
            time.sleep(rng.uniform(0.1, LONGEST[kind]))
            doing[_doing(workbench)] += 1
            began = time.perf_counter()
            workbench.cancel()
            workbench.wait(PATIENCE)
            waits.append(time.perf_counter() - began)
        # Whatever was cut short goes on from where it was, to its end.
        _prepared(workbench, store)
        realised = workbench.snapshot().state.outcome == "realised"
    finally:
        workbench.close()
        executor.close()
    spread = ", ".join(f"{what} {count}" for what, count in sorted(doing.items()))
    loaded = os.getloadavg()[0] > (os.cpu_count() or 1) + 1
    words = f"longest of {times} cancels{', on a loaded machine' if loaded else ''}"
    return [
        at_most(f"until the worker is free, {words}", max(waits), 3.0 if loaded else 1.0, "s"),
        at_most("runs that do not reach their end after these", not realised, 0),
        shown("what was cancelled", spread),
    ]


def _prepared(workbench: Workbench, store: Store) -> tuple[str, str]:
    """Two sessions: one that has been reconstructed, and one that has run to its end."""
    workbench.post(OPENING)
    workbench.wait(PATIENCE)
    begun = store.duplicate(workbench.snapshot().session_id or "")
    workbench.post(commands.Run())
    workbench.wait(PATIENCE)
    return begun, workbench.snapshot().session_id or ""


def _command(
    kind: str, workbench: Workbench, store: Store, begun: str, ended: str
) -> commands.Command:
    if kind == "opening":
        return OPENING
    running = kind == "running"
    workbench.post(commands.OpenSession(store.duplicate(begun) if running else ended))
    workbench.wait(PATIENCE)
    return commands.Run() if running else commands.Render(store.root / "clip.mp4")


def _doing(workbench: Workbench) -> str:
    return (workbench.snapshot().busy or "nothing").rpartition(": ")[2]
