"""What a viewer sees of the events of case folders: every view check, and sheets to grade by eye.

An event counts where the agent says that it happened: then its demands, the physics and every
check of the view hold. A person grades the sheets; no figure here stands for that.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from physagent_studio.benchmark.event_run import EventResult, run_apart
from physagent_studio.benchmark.events import tasks_below, tell
from physagent_studio.benchmark.results_page import mode_of
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown

SHARE = 25 / 29
"""Least part of the events that are realised with every view check, clicks alone."""
MOTION = 45.0
"""Least median of the frames in which something moves."""
ROUNDS, SECONDS = 4.0, 30.0


def bench(
    *,
    cases: Path | None,
    out: Path | None,
    annotations: Path | None = None,
    references: Path | None = None,
    only: Iterable[str] = (),
    sheets: Path | None = None,
) -> list[Row]:
    """Runs every event below `cases`, as it is and annotated; a row for each and the figures.

    sheets: folder for a contact sheet of each, with its sentence as text beside it. out: also
    write a table of every view check, Markdown.
    """
    results: list[EventResult] = []
    for task in tasks_below(cases, annotations, references, tuple(only)):
        if sheets is not None:
            mode = "annotated" if task.annotation is not None else "clicks"
            name = f"{task.label.replace('/', '__')}__{mode}.png"
            task = replace(task, sheet=sheets.resolve() / name)
        results += run_apart(task)
        tell(results[-1])
    if out is not None:
        out.write_text(_page(results), encoding="utf-8")
    rows = [_row(item) for item in results]
    for mode in dict.fromkeys(mode_of(item) for item in results):
        rows += _figures(mode, [item for item in results if mode_of(item) == mode])
    return rows


def _view(item: EventResult) -> list[dict[str, Any]]:
    return item.report.get("view") or []


def _pacing(item: EventResult) -> dict[str, Any]:
    return item.report.get("pacing") or {"moving": 0, "time_factor": 1.0, "fastest": 0.0}


def _row(item: EventResult) -> Row:
    pace, failing = _pacing(item), [c["check"] for c in _view(item) if not c["ok"]]
    words = "realised" if item.realised else "denied" if item.denied else item.report["outcome"]
    value = (
        f"{words}, motion {pace['moving']} frames, time ×{pace['time_factor']:.2g}, fastest "
        f"{100 * pace['fastest']:.1f} %, {item.report['rounds']} rounds, "
        f"{item.report['seconds']:.0f} s" + (f", fails {', '.join(failing)}" if failing else "")
    )
    return Row(f"{item.label}, {mode_of(item)}", value, "", "", item.realised and not failing)


def _figures(mode: str, results: Sequence[EventResult]) -> list[Row]:
    good = [i for i in results if i.realised and _view(i) and all(c["ok"] for c in _view(i))]
    rows = [
        at_least(
            f"{mode}: realised with every view check of {len(results)}",
            len(good),
            round(SHARE * len(results)),
            "events",
        )
    ]
    if good:
        moving = statistics.median(_pacing(item)["moving"] for item in good)
        rows.append(at_least(f"{mode}: frames in which something moves, median", moving, MOTION))
        rounds = statistics.fmean(item.report["rounds"] for item in good)
        rows.append(at_most(f"{mode}: rounds, mean", round(rounds, 2), ROUNDS, "rounds"))
    seconds = [item.report["seconds"] for item in results]
    rows.append(at_most(f"{mode}: slowest event", max(seconds), SECONDS, "s"))
    slowed = sum(_pacing(item)["time_factor"] < 0.999 for item in good)
    rows.append(shown(f"{mode}: in slow motion", slowed, "events"))
    rows.append(shown(f"{mode}: denied by the reference", sum(i.denied for i in results), "events"))
    return rows


def _page(results: Sequence[EventResult]) -> str:
    lines = ["| event | check | measured | bound | |", "|---|---|---|---|---|"]
    for item in results:
        for check in _view(item):
            mark, name = "✓" if check["ok"] else "✗", f"{item.label}, {mode_of(item)}"
            lines.append(f"| {name} | {check['statement']} | {_short(check)} | {mark} |")
    return "\n".join(lines) + "\n"


def _short(check: dict[str, Any]) -> str:
    measured, bound = check["measured"], check["threshold"]
    figures = "–" if measured is None else f"{measured:.3g} {check['unit']}".strip()
    return f"{figures} | {'–' if bound is None else f'{bound:.3g}'}"
