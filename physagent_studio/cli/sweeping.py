"""`physagent sweep` and `physagent attribute`: many runs of programs, and what they tell."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physagent_studio.cli import output
from physagent_studio.cli.guard import guarded
from physagent_studio.errors import InputError

if TYPE_CHECKING:
    from physagent_studio.jobs import Executor

EXECUTORS = ("inline", "processes", "ray")
DRAWS = 50
"""Draws of --random where --seeds does not say: a share is then known to about 7 in a hundred."""

ExecutorName = Annotated[str, typer.Option(help="inline, processes, or ray (an extra).")]
Workers = Annotated[
    int | None, typer.Option(min=1, max=1024, help="Runs at a time; else as many as cores.")
]
Address = Annotated[
    str, typer.Option(help="ray: of a running cluster (auto, ray://host:10001); else one here.")
]
Workspace = Annotated[
    Path | None,
    typer.Option(help="Folder of sessions; else $PHYSAGENT_HOME, else your data folder."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON value for machines.")]


@guarded
def sweep(
    targets: Annotated[
        list[str], typer.Argument(help="Programs, case folders or sessions (their best round).")
    ],
    out: Annotated[Path, typer.Option(help="Folder of results; what is in it is not run again.")],
    grid: Annotated[
        list[str] | None, typer.Option(help="FIELD=A:B:N, N values from A to B; again for more.")
    ] = None,
    random: Annotated[
        list[str] | None, typer.Option(help="FIELD=A:B, drawn evenly; again for more.")
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(min=1, help="Draws of --random; without it, as --robustness."),
    ] = None,
    robustness: Annotated[
        int | None,
        typer.Option(min=1, help="Draws of all uncertain numbers: mass, friction, pose, force."),
    ] = None,
    event: Annotated[str | None, typer.Option(help="Of a case; else each of its events.")] = None,
    executor: ExecutorName = "processes",
    workers: Workers = None,
    address: Address = "",
    as_json: Json = False,
    workspace: Workspace = None,
) -> None:
    """Run a program many times with its numbers moved; a table and a page of what came of it."""
    from physagent_studio.sweep.fields import span_of
    from physagent_studio.sweep.plan import Plan
    from physagent_studio.sweep.robustness import draw_of

    grids = tuple(span_of(word, grid=True) for word in grid or ())
    drawn = tuple(span_of(word, grid=False) for word in random or ())
    moved = robustness is not None or (seeds is not None and not drawn)
    count = robustness or seeds or (DRAWS if drawn else 0)
    if robustness and (drawn or seeds):
        raise InputError("--robustness draws what is uncertain; it goes with --grid alone")
    if not grids and not count:
        raise InputError("nothing is to be moved: give --grid, --random, --seeds or --robustness")
    plan = Plan(grids, drawn, count, draw_of(0) if moved else None)
    with executor_of(executor, workers, address) as pool:
        from physagent_studio.cli.swept import swept

        report = swept(targets, event, plan, pool, out, workspace, tell=_progress)
    if as_json:
        output.print_json(report)
        return
    for line in report["said"]:
        typer.echo(line)


@guarded
def attribute(
    session: Annotated[str, typer.Argument(help="A session id or a unique beginning of one.")],
    round_id: Annotated[
        str | None, typer.Option("--round", help="Made by an accepted proposal; else the best.")
    ] = None,
    executor: ExecutorName = "processes",
    workers: Workers = None,
    address: Address = "",
    as_json: Json = False,
    workspace: Workspace = None,
) -> None:
    """Which of the changes of an accepted proposal brought the event about."""
    from physagent_studio.cli.swept import attributed

    with executor_of(executor, workers, address) as pool:
        found = attributed(session, round_id, pool, workspace)
    if as_json:
        output.print_json(found)
        return
    typer.echo(found["said"])
    for one in found["hunks"]:
        share = "" if one["shapley"] is None else f"{one['shapley']:+.2f}  "
        typer.echo(f"  {share}{'needed  ' if one['needed'] else '        '}{one['summary']}")


@contextmanager
def executor_of(name: str, workers: int | None, address: str) -> Iterator[Executor]:
    """The executor of that name, closed at the end. Raises InputError, BackendMissing."""
    from physagent_studio.jobs import Inline, Processes

    if name not in EXECUTORS:
        raise InputError(f"--executor {name} is not known ({', '.join(EXECUTORS)})")
    if address and name != "ray":
        raise InputError("--address is of a Ray cluster: give --executor ray")
    if name == "inline":
        yield Inline()
        return
    if name == "ray":
        from physagent_studio.jobs.cluster import Cluster

        made = Cluster(address, workers)
    else:
        made = Processes(workers or os.cpu_count() or 1, keeping=True)
    try:
        yield made
    finally:
        made.close()


def _progress(done: int, total: int) -> None:
    """A line that is written over on a terminal, else one for each tenth."""
    terminal = sys.stderr.isatty()
    if terminal or done * 10 // total > (done - 1) * 10 // total:
        end = "\n" if done == total or not terminal else "\r"
        print(f"{done} of {total} runs", end=end, file=sys.stderr, flush=True)
