"""`physagent sweep` and `physagent attribute`: many runs of programs, and what they tell."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physagent_studio.cli.early import session_there, target_there
from physagent_studio.cli.guard import Workspace, guarded
from physagent_studio.errors import InputError

if TYPE_CHECKING:
    from physagent_studio.jobs import Executor

EXECUTORS = ("inline", "processes", "ray")


@guarded
def sweep(
    targets: Annotated[
        list[str], typer.Argument(help="Programs, case folders or sessions (their best round).")
    ],
    out: Annotated[Path, typer.Option(help="Folder of results; what is in it is not run again.")],
    grid: Annotated[list[str] | None, typer.Option(help="FIELD=A:B:N; again for more.")] = None,
    random: Annotated[list[str] | None, typer.Option(help="FIELD=A:B; again for more.")] = None,
    seeds: Annotated[
        int, typer.Option(min=0, help="How many draws: of --random, else as --robustness.")
    ] = 0,
    robustness: Annotated[
        int,
        typer.Option(min=0, help="Draws of all that is uncertain: mass, friction, pose, push."),
    ] = 0,
    event: Annotated[str | None, typer.Option(help="Which event of a case.")] = None,
    executor: Annotated[str, typer.Option(help="inline, processes, or ray (an extra).")] = (
        "processes"
    ),
    workers: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Runs at a time; else as many as cores.")
    ] = None,
    address: Annotated[
        str, typer.Option(help="Of a Ray cluster (auto, ray://host:10001); else one here.")
    ] = "",
    workspace: Workspace = None,
) -> None:
    """Run programs many times with numbers moved; write a table and a page of what came of it."""
    draws = robustness or seeds
    if (random and not seeds) or (robustness and seeds):
        raise InputError(
            "--random goes with --seeds, which says how often it draws; not so --robustness"
        )
    if not grid and not draws:
        raise InputError("nothing is to be moved: give --grid, --random with --seeds, --robustness")
    for target in targets:
        target_there(target, workspace)
    with executor_of(executor, workers, address) as pool:
        from physagent_studio.cli.swept import plan_of, swept

        plan = plan_of(grid or [], random or [], draws)
        for line in swept(targets, event, plan, pool, out, workspace):
            typer.echo(line)


@guarded
def attribute(
    session: Annotated[str, typer.Argument(help="A session id or a unique beginning of one.")],
    round_id: Annotated[
        str | None, typer.Option("--round", help="Made by an accepted proposal; else the best.")
    ] = None,
    workspace: Workspace = None,
) -> None:
    """Which of the changes of an accepted proposal brought the event about."""
    session_there(session, workspace)
    with executor_of("processes", None, "") as pool:
        from physagent_studio.cli.swept import attributed

        for line in attributed(session, round_id, pool, workspace):
            typer.echo(line)


@contextmanager
def executor_of(name: str, workers: int | None, address: str) -> Iterator[Executor]:
    """The executor of that name, closed at the end. Raises InputError, BackendMissing."""
    from physagent_studio.jobs import Inline, Processes
    from physagent_studio.jobs.cluster import Cluster

    if name not in EXECUTORS or (address and name != "ray"):
        known = ", ".join(EXECUTORS)
        raise InputError(f"--executor {name} is not known ({known}; --address is of ray alone)")
    if name == "inline":
        yield Inline()
        return
    here = name == "processes"
    cores = workers or os.cpu_count() or 1
    with closing(Processes(cores, keeping=True) if here else Cluster(address, workers)) as made:
        yield made
