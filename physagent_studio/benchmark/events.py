"""Events of case folders, run end to end by the embedded agent; the table in docs/results.md."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.errors import InputError
from physagent_studio.exchange import load_case
from physagent_studio.records import LoopState
from physagent_studio.session import Store
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.engine import Control
from physagent_studio.workbench.report import report_of

SECONDS_PER_EVENT = 60.0


@dataclass(frozen=True, slots=True)
class EventResult:
    """One event: where it is from and the report of its run."""

    case: str
    event: str
    prompt: str
    report: dict[str, Any]


def bench(*, cases: Path | None, out: Path | None, only: Iterable[str] = ()) -> list[Row]:
    """Runs every event below `cases`; rows of figures, and a Markdown table at `out`."""
    if cases is None or not cases.is_dir():
        raise InputError("give the folder of case folders with --cases")
    results = [run_event(folder, event) for folder, event in events_below(cases, tuple(only))]
    if not results:
        raise InputError(f"no case.yaml below {cases}")
    if out is not None:
        out.write_text(markdown(results), encoding="utf-8")
    return figures(results)


def events_below(cases: Path, only: tuple[str, ...] = ()) -> list[tuple[Path, str]]:
    """(case folder, event) below a folder; `only` picks `case/event` or whole `case`s."""
    found = []
    for path in sorted(cases.glob("*/case.yaml")):
        names = [name for name, _ in load_case(path.parent, None).events]
        for name in names:
            label = f"{path.parent.name}/{name}"
            if not only or label in only or path.parent.name in only:
                found.append((path.parent, name))
    return found


def run_event(folder: Path, event: str, *, evidence: bool = False) -> EventResult:
    """Runs one event by policy `auto` in a workspace that is thrown away."""
    case = load_case(folder, event)
    with tempfile.TemporaryDirectory() as home:
        session = Store(Path(home)).create(case, LoopState(policy="auto"))
        desk = Desk(session, Control(), evidence=evidence)
        started = time.perf_counter()
        desk.advance(policy="auto")
        report = report_of(desk.state, session, time.perf_counter() - started)
        session.close()
    return EventResult(folder.name, event, case.prompt, report)


def figures(results: list[EventResult]) -> list[Row]:
    """Rows for the bench table."""
    rows = [
        Row(
            name=f"{item.case}/{item.event}",
            value=f"{'realised' if item.report['realised'] else item.report['outcome']}, "
            f"{item.report['rounds']} rounds, {item.report['simulations']} simulations",
            unit="",
            bound="",
            ok=True,
        )
        for item in results
    ]
    realised = [item for item in results if item.report["realised"]]
    slowest = max(item.report["seconds"] for item in results)
    rows.append(at_least("events realised", len(realised), (len(results) + 1) // 2, "events"))
    rows.append(at_most("slowest event", slowest, SECONDS_PER_EVENT, "s"))
    if realised:
        mean = sum(item.report["rounds"] for item in realised) / len(realised)
        rows.append(shown("rounds per realised event, mean", mean, "rounds"))
    return rows


def markdown(results: list[EventResult]) -> str:
    """The table of results with every contract check and its measured value."""
    lines = [
        "# Results on real photographs",
        "",
        "Made by `physagent bench events --cases FOLDER --out docs/results.md` with the embedded",
        "agent (rules, no network, no GPU), policy `auto`, at most ten rounds. The photographs are",
        "not part of this repository.",
        "",
        "| event | realised | rounds | simulations | seconds |",
        "|---|---|---|---|---|",
    ]
    for item in results:
        report = item.report
        lines.append(
            f"| {item.case} / {item.event} | {'yes' if report['realised'] else 'no'} "
            f"| {report['rounds']} | {report['simulations']} | {report['seconds']:.1f} |"
        )
    for item in results:
        lines += ["", *_event_section(item)]
    return "\n".join(lines) + "\n"


def _event_section(item: EventResult) -> list[str]:
    lines = [
        f"## {item.case} / {item.event}",
        "",
        f"> {item.prompt}",
        "",
        "| | statement | measured | threshold | margin |",
        "|---|---|---|---|---|",
    ]
    for check in item.report["contract"]:
        lines.append(
            f"| {'✓' if check['ok'] else '✗'} | {check['statement']} "
            f"| {_number(check['measured'], check['unit'])} "
            f"| {_number(check['threshold'], check['unit'])} | {check['margin']:+.3g} |"
        )
    for key, title in (
        ("diagnosis", "Diagnosis"),
        ("untested", "Untested clause"),
        ("not_understood", "Not understood"),
    ):
        lines += [f"\n{title}: {text}" for text in item.report[key]]
    return lines


def _number(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.3g} {unit}".strip()
