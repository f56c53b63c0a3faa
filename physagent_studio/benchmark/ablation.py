"""`physagent bench ablation`: the agent without reflection, without semantic actions, and full.

Parser, verifier, planner and simulation budget are the same in all three.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from physagent_studio.benchmark.event_run import EventResult, EventTask, run_apart
from physagent_studio.benchmark.events import tasks_below, tell
from physagent_studio.benchmark.rows import Row, shown
from physagent_studio.benchmark.variants import VARIANTS
from physagent_studio.errors import InputError


def bench(
    *,
    cases: Path | None,
    out: Path | None,
    annotations: Path | None = None,
    references: Path | None = None,
    only: Iterable[str] = (),
) -> list[Row]:
    """Runs every event in every variant; annotated where there is a file for its case."""
    tasks = _annotated_where_possible(tasks_below(cases, annotations, references, tuple(only)))
    results = []
    for task in tasks:
        for name in VARIANTS:
            results.append(run_apart(replace(task, variant=name)))
            tell(results[-1])
    rows = figures(results)
    if out is not None:
        out.write_text(page(results), encoding="utf-8")
    return rows


def _annotated_where_possible(tasks: Sequence[EventTask]) -> list[EventTask]:
    chosen: dict[str, EventTask] = {}
    for task in tasks:
        if task.annotation is not None or task.label not in chosen:
            chosen[task.label] = task
    return list(chosen.values())


def figures(results: Sequence[EventResult]) -> list[Row]:
    """Per variant: events realised, rounds over them, simulations; and whether full is ahead."""
    rows: list[Row] = []
    realised: dict[str, int] = {}
    for name, variant in VARIANTS.items():
        mine = [item for item in results if item.variant == name]
        if not mine:
            raise InputError("no event was run")
        good = [item for item in mine if item.realised]
        realised[name] = len(good)
        rows.append(shown(f"{variant.words}: realised of {len(mine)}", len(good), "events"))
        if good:
            mean = sum(item.report["rounds"] for item in good) / len(good)
            rows.append(shown(f"{variant.words}: rounds per realised event", mean, "rounds"))
        spent = sum(item.report["rounds"] for item in mine) / len(mine)
        rows.append(shown(f"{variant.words}: rounds per event", spent, "rounds"))
        runs = sum(item.report["simulations"] for item in mine)
        rows.append(shown(f"{variant.words}: simulations", runs, "runs"))
        held = sum(_share_held(item) for item in mine) / len(mine)
        rows.append(shown(f"{variant.words}: statements of the references held", held, "share"))
    others = max(count for name, count in realised.items() if name != "full")
    lead = realised["full"] - others
    rows.append(Row("full ahead of the better other by", lead, "events", "≥ 0", lead >= 0))
    return rows


def _share_held(item: EventResult) -> float:
    """Share of the reference's statements, else of the agent's own, that hold at the end."""
    rows = item.reference or item.report["contract"]
    return sum(bool(row["ok"]) for row in rows) / len(rows) if rows else 0.0


def page(results: Sequence[EventResult]) -> str:
    """A Markdown page: a row per event, a column per variant."""
    words = [variant.words for variant in VARIANTS.values()]
    lines = [
        "# Ablation",
        "",
        "Made by `physagent bench ablation`. Parser, verifier, planner and simulation budget are",
        "the same everywhere. *Without reflection*: the first program only. *Without the semantic",
        "actions*: plain world-frame force and torque vectors with start and duration.",
        "",
        f"| event | {' | '.join(words)} |",
        f"|---|{'---|' * len(words)}",
    ]
    for label in dict.fromkeys(item.label for item in results):
        mine = {item.variant: item for item in results if item.label == label}
        cells = [_cell(mine[name]) if name in mine else "–" for name in VARIANTS]
        lines.append(f"| {label} | {' | '.join(cells)} |")
    lines += ["", "| figure | value |", "|---|---|"]
    for row in figures(results):
        value = f"{row.value:.3g}" if isinstance(row.value, float) else str(row.value)
        lines.append(f"| {row.name} | {value} {row.unit} |")
    return "\n".join(lines) + "\n"


def _cell(item: EventResult) -> str:
    word = "**realised**" if item.realised else item.report["outcome"]
    return f"{word}, {item.report['rounds']} rounds, {item.report['simulations']} runs"
