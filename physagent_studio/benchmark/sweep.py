"""`physagent bench sweep`: runs a second by each executor, a search in one process and in two, and
whether all agree."""

import time
from collections.abc import Callable
from contextlib import closing
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from physagent_studio.agent.crew import Bench
from physagent_studio.agent.previews import trial_of
from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules import RulePlanner, RuleVerifier
from physagent_studio.assets import assets_dir
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.jobs import Inline, Processes
from physagent_studio.jobs.cluster import Cluster
from physagent_studio.program import SetField, apply
from physagent_studio.program.text.document import load_program
from physagent_studio.reconstruction.without_photo import scene_without_photo
from physagent_studio.records import Case, LoopState, Memory, Proposal, RolloutEvidence
from physagent_studio.session import Store
from physagent_studio.sweep import Plan, Point, Ran, Target, carry_out, planned
from physagent_studio.sweep.plan import Span
from physagent_studio.workbench.engine import Engine

FASTER = 1.7
"""What two cores have to make of one, where all of it is measured."""
DOSES = {False: 40, True: 2000}
"""Programs of a dose and of all of it."""


def bench(*, cases: Path | None = None, full: bool = False) -> list[Row]:
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
    return [*rows, *_search_rows(target, full=full)]


def _swept(target: Target, count: int, executor: Any) -> list[tuple[str, str]]:
    """The rollout of each program by its key, as often as it was done."""
    found: list[tuple[str, str]] = []

    def done(point: Point, ran: Ran) -> None:
        found.append((point.key, ran.rollout))

    plan = Plan(grid=(Span("event.actions.roll.velocity.0", 0.5, 1.5, count),))
    carry_out(planned(plan, (target,)), executor, done)
    return sorted(found)


SOONER = 1.6
"""What two cores have to make of one, where all of it is measured."""
WEAK = SetField(path="event.actions.roll.velocity.0", value=0.05)
"""A ball so slow that the dominoes stay as they are."""


def _search_rows(target: Target, *, full: bool) -> list[Row]:
    """How much sooner two cores find a planner's proposal than one, and whether it is the same."""
    target = Target(target.label, apply(target.program, [WEAK]), target.scene)
    limit = 60 if full else 6
    (one, first), (two, second) = (_searched(target, width, limit) for width in (1, 2))
    return [
        shown(f"a search of {first.simulations} runs in one process", one, "s"),
        shown("the same in two", two, "s"),
        # In a dose, what else is at work on the machine counts for too much.
        at_least("a search: one process over two", one / two, SOONER if full else 0.0, "×"),
        at_most("searches with another proposal", int(first.edits != second.edits), 0),
    ]


def _searched(target: Target, width: int, limit: int) -> tuple[float, Proposal]:
    """Seconds of a search, and what it proposes; all processes run and have run the scene."""
    case = Case("bench", prompt=target.program.event.prompt)
    with TemporaryDirectory() as home, closing(Processes(width, keeping=True)) as pool:
        session = Store(Path(home)).create(case, LoopState())
        bench = Engine(session, case, evidence=False, executor=pool).bench()
        situation = _situation(target, case, bench)
        RulePlanner(limit).propose(situation)
        began = time.perf_counter()
        proposal = RulePlanner(limit).propose(situation)
        seconds = time.perf_counter() - began
        session.close()
    return seconds, proposal


def _situation(target: Target, case: Case, bench: Bench) -> Situation:
    program, scene = target.program, target.scene
    try_out = trial_of(scene, bench)
    ran = try_out(program)
    evidence = RolloutEvidence(program, scene, ran.rollout, ran.checks, ())
    verdict = RuleVerifier().judge(evidence, program.event.prompt)
    return Situation(
        case, program, scene, ran.rollout, verdict, Memory(), try_out, ahead=bench.ahead(scene)
    )
