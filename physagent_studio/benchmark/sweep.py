"""`physagent bench sweep`: runs a second by each executor, a search in one process and in two, and
whether all agree."""

import time
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from physagent_studio.assets import assets_dir
from physagent_studio.benchmark import searching
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.jobs import Inline, Processes
from physagent_studio.jobs.cluster import Cluster
from physagent_studio.program.text.document import load_program
from physagent_studio.reconstruction.without_photo import scene_without_photo
from physagent_studio.sweep import Plan, Point, Ran, Target, carry_out, planned
from physagent_studio.sweep.plan import Span

FASTER = 1.7
"""What two cores have to make of one, where all of it is measured."""
DOSES = {False: 40, True: 2000}
"""Programs of a dose and of all of it."""


def bench(*, cases: Path | None = None, out: Path | None = None, full: bool = False) -> list[Row]:
    """All rows; a domino run with the ball at other speeds."""
    count = DOSES[full]
    program = load_program((assets_dir() / "programs/domino_program.yaml").read_text("utf-8"))
    scene = scene_without_photo(program.scene, "bench", {})
    target = Target("dominoes", program.model_copy(update={"scene": scene.state}), scene)
    makers: dict[str, Callable[[], Any]] = {"inline": Inline}
    makers |= {f"processes, {width}": partial(Processes, width, keeping=True) for width in (1, 2)}
    if find_spec("ray") is not None:
        makers["ray, 2"] = partial(Cluster, cores=2)
    rates, results = dict[str, float](), []
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
    # In a dose, what else is at work on the machine counts for too much.
    rows.append(at_least("processes, 2 over 1", ratio, FASTER if full else 0.0, "×"))
    wrong = sum(one != results[0] for one in results[1:])
    rows.append(at_most("executors with a run missing, twice or of other bits", wrong, 0))
    return [*rows, *searching.rows_of(target, full=full)]


def _swept(target: Target, count: int, executor: Any) -> list[tuple[str, str]]:
    """The rollout of each program by its key, as often as it was done."""
    found: list[tuple[str, str]] = []

    def done(point: Point, ran: Ran) -> None:
        found.append((point.key, ran.rollout))

    plan = Plan(grid=(Span("event.actions.roll.velocity.0", 0.5, 1.5, count),))
    carry_out(planned(plan, (target,)), executor, done)
    return sorted(found)
