"""Tables for people, JSON for machines."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    DownloadColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

if TYPE_CHECKING:
    # Only named in annotations here; importing them would cost every command a second.
    from physagent_studio.benchmark.rows import Row
    from physagent_studio.records import Check
    from physagent_studio.session import SessionInfo
    from physagent_studio.workbench.engine import Control

LONGEST = 44
"""Characters of a stage on a terminal: with bar and clock they fit into 80 columns."""


def print_json(value: Any) -> None:
    """One JSON value on standard output; numbers are finite."""
    print(json.dumps(value, indent=2, allow_nan=False, ensure_ascii=False))


@contextmanager
def progress_control(quiet: bool) -> Iterator[Control]:
    """A `Control` that tells of progress on standard error, or of nothing.

    On a terminal one line, rewritten; elsewhere a line for each stage, with the seconds until it.
    """
    from physagent_studio.workbench.doing import STEPS
    from physagent_studio.workbench.engine import Control

    console = Console(stderr=True)
    if quiet:
        yield Control()
        return
    if not console.is_terminal:
        yield Control(progress=_lines())
        return
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def show(what: str, share: float | None) -> None:
            said = shorten(STEPS.get(what, what), LONGEST, placeholder=" …")
            bar.update(task, description=escape(said), total=1.0 if share is not None else None)
            if share is not None:
                bar.update(task, completed=share)

        yield Control(progress=show)


def _lines() -> Callable[[str, float | None], None]:
    """Told of progress, prints a line on standard error where another stage begins."""
    from physagent_studio.workbench.doing import STEPS

    began, last = time.monotonic(), ""

    def show(what: str, share: float | None) -> None:
        nonlocal last
        if what in (last, "done"):
            return
        last = what
        said = shorten(STEPS.get(what, what), 2 * LONGEST, placeholder=" …")
        print(f"{time.monotonic() - began:6.1f} s  {said}", file=sys.stderr, flush=True)

    return show


@contextmanager
def bytes_bar(name: str) -> Iterator[Callable[[int, int], None]]:
    """Told of bytes that are there and of how many, draws them on a terminal's standard error."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda have, whole: None
        return
    columns = (TextColumn(name), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(name, total=None)
        yield lambda have, whole: bar.update(task, completed=have, total=whole)


def print_checks(checks: Sequence[Check]) -> None:
    """The contract as a checklist."""
    table = Table("", "statement", "margin", box=None, pad_edge=False)
    for check in checks:
        mark = "[green]✓[/]" if check.ok else "[red]✗[/]"
        table.add_row(
            mark if check.demanded else "",
            escape(check.text) if check.demanded else f"[dim]  part: {escape(check.text)}[/]",
            f"{check.margin:+.3g}",
        )
    Console().print(table)


def print_rows(name: str, rows: Sequence[Row], as_json: bool) -> None:
    """Bench figures with their bounds."""
    if as_json:
        print_json([asdict(row) for row in rows])
        return
    table = Table("", "figure", "value", "unit", "bound", title=f"bench {name}", box=None)
    for row in rows:
        mark = "[green]✓[/]" if row.ok else "[red]✗[/]"
        value = f"{row.value:.6g}" if isinstance(row.value, float) else str(row.value)
        table.add_row(mark, row.name, value, row.unit, row.bound)
    Console().print(table)


def print_sessions(infos: Sequence[SessionInfo], as_json: bool) -> None:
    """The session list."""
    if as_json:
        keys = ("id", "title", "prompt", "rounds", "outcome", "in_doubt", "modified")
        print_json([{key: getattr(item, key) for key in keys} for item in infos])
        return
    if not infos:
        print("no sessions yet; `physagent run` and `physagent studio` make them")
        return
    from physagent_studio.session.standing import IN_DOUBT

    # The id is there to be copied: it is never cut, whatever the width of the terminal.
    wide = max(len(item.id) for item in infos)
    for item in infos:
        said = f"{count(item.rounds, 'round')}, {item.outcome}"
        said += f", {IN_DOUBT}" if item.in_doubt else ""
        print(f"{item.id:<{wide}}  {item.modified[:16].replace('T', ' ')}  {said}")
        print(f"    {item.title}: {shorten(item.prompt or 'no sentence yet', 100)}")


def count(number: int, what: str) -> str:
    """`1 round`, `2 rounds`."""
    return f"{number} {what}{'' if number == 1 else 's'}"
