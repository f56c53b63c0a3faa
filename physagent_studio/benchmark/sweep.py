"""`physagent bench sweep`: runs a second on one core and on two, and killed workers."""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from physagent_studio.assets import assets_dir
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.jobs import Inline, Processes
from physagent_studio.jobs.cluster import Cluster
from physagent_studio.program.text.document import load_program
from physagent_studio.reconstruction.without_photo import scene_without_photo
from physagent_studio.sweep import Plan, Point, Ran, Target, carry_out, planned
from physagent_studio.sweep.fields import Span

FASTER = 1.7
"""What two cores have to make of one."""
DOSES = {False: (40, 3), True: (2000, 10)}
"""Programs, and workers that are killed, of a dose and of all of it."""


def bench(*, cases: Path | None = None, out: Path | None = None, full: bool = False) -> list[Row]:
    """All rows; a domino run with the ball at other speeds."""
    count, kills = DOSES[full]
    program = load_program((assets_dir() / "programs/domino_program.yaml").read_text("utf-8"))
    scene = scene_without_photo(program.scene, "bench", {})
    target = Target("dominoes", program.model_copy(update={"scene": scene.state}), scene)
    makers: dict[str, Callable[[], Any]] = {
        "inline": Inline,
        "processes, 1": lambda: Processes(1, keeping=True),
        "processes, 2": lambda: Processes(2, keeping=True),
    }
    if find_spec("ray") is not None:
        makers["ray, 2"] = lambda: Cluster(cores=2)
    rates, results = {}, []
    for name, make in makers.items():
        executor = make()
        _swept(target, 4, executor)  # Workers start, and import what they need.
        began = time.perf_counter()
        results.append(_swept(target, count, executor))
        rates[name] = count / (time.perf_counter() - began)
        if name != "inline":
            executor.close()
    rows = [shown(f"{name}: {count} programs", rate, "runs/s") for name, rate in rates.items()]
    ratio = rates["processes, 2"] / rates["processes, 1"]
    rows.append(at_least("processes, 2 over 1", ratio, FASTER, "×") if full else
                shown("processes, 2 over 1", ratio, "×"))  # fmt: skip
    pool = Processes(2, keeping=True)
    results.append(_swept(target, count, pool, kills))
    pool.close()
    wrong = sum(one != results[0] for one in results[1:])
    words = f"runs lost, done twice or with other bits, {kills} workers killed"
    return [*rows, at_most(words, wrong, 0)]


def _swept(target: Target, count: int, executor: Any, kills: int = 0) -> list[tuple[str, str]]:
    """The rollout of each program by its key, as often as it was done; workers are killed."""
    found: list[tuple[str, str]] = []
    draw, due = random.Random(0), {count * (k + 1) // (kills + 1) for k in range(kills)}

    def done(point: Point, ran: Ran) -> None:
        found.append((point.key, ran.rollout))
        if len(found) in due:
            os.kill(draw.choice(_children()), signal.SIGKILL)

    plan = Plan(grid=(Span("event.actions.roll.velocity.0", 0.5, 1.5, count),))
    carry_out(planned(plan, (target,)), executor, done)
    return sorted(found)


def _children() -> list[int]:
    """The processes that this one has started, on Linux."""
    lists = [path.read_text().split() for path in Path("/proc/self/task").glob("*/children")]
    return [int(pid) for one in lists for pid in one]
