"""`physagent bench ablation`: the agent without reflection, without semantic actions, and full.

Parser, verifier, planner and simulation budget are the same in all three.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from physagent_studio.assets import assets_dir
from physagent_studio.benchmark.events.bare_scenes import load_bare_scene
from physagent_studio.benchmark.events.bench import tasks_below, tell
from physagent_studio.benchmark.events.event_run import EventResult, EventTask, run_apart
from physagent_studio.benchmark.events.variants import VARIANTS
from physagent_studio.benchmark.rows import Row, shown
from physagent_studio.errors import InputError

PHOTOS, PROMPTS = "photographs", "prompts"
"""Events of photographs, and prompts over the bundled scenes without one."""


def bench(
    *,
    cases: Path | None,
    out: Path | None,
    annotations: Path | None = None,
    references: Path | None = None,
    only: Iterable[str] = (),
) -> list[Row]:
    """Runs every event and every bundled prompt in every variant.

    Events are annotated where there is a file for their case. Without `cases` only the prompts
    are run. only: `case`, `case/event`, or the name of a bundled scene.
    """
    wanted = tuple(only)
    groups = [[task] for task in _photographs(cases, annotations, references, wanted)]
    groups += prompts_of(assets_dir() / "scenes", wanted)
    if not groups:
        raise InputError(f"there is no event or scene that is called {' or '.join(wanted)}")
    results: list[EventResult] = []
    for group in groups:
        for name in VARIANTS:
            results += run_apart(*(replace(task, variant=name) for task in group))
            _tell(results[-len(group) :])
    if out is not None:
        out.write_text(page(results), encoding="utf-8")
    return figures(results)


def _photographs(
    cases: Path | None, annotations: Path | None, references: Path | None, only: tuple[str, ...]
) -> list[EventTask]:
    """Each event once, annotated where that is possible."""
    scenes = {path.stem for path in (assets_dir() / "scenes").glob("*.yaml")}
    named = tuple(name for name in only if name.split("/")[0] not in scenes)
    if cases is None or (only and not named):
        return []
    chosen: dict[str, EventTask] = {}
    for task in tasks_below(cases, annotations, references, named):
        if task.annotation is not None or task.label not in chosen:
            chosen[task.label] = task
    return list(chosen.values())


def prompts_of(folder: Path, only: tuple[str, ...] = ()) -> list[list[EventTask]]:
    """The wordings of each event of the bundled scenes, an event's together."""
    groups = []
    for path in sorted(folder.glob("*.yaml")):
        for event, wordings in load_bare_scene(path).prompts.items():
            if not only or path.stem in only or f"{path.stem}/{event}" in only:
                groups.append([EventTask(path, f"{event}#{k}") for k in range(len(wordings))])
    return groups


def _tell(results: Sequence[EventResult]) -> None:
    if len(results) == 1:
        tell(results[0])
        return
    good = sum(item.realised for item in results)
    label = results[0].label.partition("#")[0]
    words = f"{label}, {results[0].variant}: {good} of {len(results)} wordings realised"
    print(words, file=sys.stderr, flush=True)


def group_of(item: EventResult) -> str:
    """Whether a result is of a photograph or of a bundled prompt."""
    return PROMPTS if "#" in item.label else PHOTOS


# --- figures -----------------------------------------------------------------------------------


def figures(results: Sequence[EventResult]) -> list[Row]:
    """Per group and variant what was realised and spent; and by how much full is ahead."""
    rows: list[Row] = []
    for group in (PHOTOS, PROMPTS):
        mine = [item for item in results if group_of(item) == group]
        if mine:
            rows += _group_rows(group, mine)
    return rows


def _group_rows(group: str, results: Sequence[EventResult]) -> list[Row]:
    rows: list[Row] = []
    realised: dict[str, int] = {}
    for name, variant in VARIANTS.items():
        mine = [item for item in results if item.variant == name]
        good = [item for item in mine if item.realised]
        realised[name] = len(good)
        head = f"{group}, {variant.words}"
        rows.append(shown(f"{head}: realised of {len(mine)}", len(good), "events"))
        if good:
            mean = sum(item.report["rounds"] for item in good) / len(good)
            rows.append(shown(f"{head}: rounds per realised event", round(mean, 3), "rounds"))
        if mine:
            spent = sum(item.report["rounds"] for item in mine) / len(mine)
            rows.append(shown(f"{head}: rounds per event", round(spent, 3), "rounds"))
            held = sum(_share_held(item) for item in mine) / len(mine)
            rows.append(shown(f"{head}: statements that hold", round(held, 3), "share"))
        runs = sum(item.report["simulations"] for item in mine)
        rows.append(shown(f"{head}: simulations", runs, "runs"))
    lead = realised["full"] - max(count for name, count in realised.items() if name != "full")
    rows.append(
        Row(f"{group}: full ahead of the better other by", lead, "events", "≥ 0", lead >= 0)
    )
    return rows


def _share_held(item: EventResult) -> float:
    """Share of the reference's statements, else of the agent's own, that hold at the end."""
    rows = item.reference or item.report["contract"]
    return sum(bool(row["ok"]) for row in rows) / len(rows) if rows else 0.0


# --- the page ----------------------------------------------------------------------------------


def page(results: Sequence[EventResult]) -> str:
    """A Markdown page: the figures, and a row per event with a column per variant."""
    words = [variant.words for variant in VARIANTS.values()]
    lines = [
        "# Ablation",
        "",
        "Made by `physagent bench ablation`. Parser, verifier, planner and simulation budget are",
        "the same everywhere. *Without reflection*: the first program only. *Without the semantic",
        "actions*: plain world-frame force and torque vectors with start and duration; no",
        "velocities, named directions, aims, starts on a condition, placing or holding.",
        "",
        "| figure | value |",
        "|---|---|",
    ]
    for row in figures(results):
        lines.append(f"| {row.name} | {row.value:g} {row.unit} |")
    lines += ["", f"| event | {' | '.join(words)} |", f"|---|{'---|' * len(words)}"]
    for label in dict.fromkeys(item.label.partition("#")[0] for item in results):
        mine = [item for item in results if item.label.partition("#")[0] == label]
        cells = [_cell([item for item in mine if item.variant == name]) for name in VARIANTS]
        lines.append(f"| {label} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _cell(results: Sequence[EventResult]) -> str:
    if not results:
        return "–"
    rounds = sum(item.report["rounds"] for item in results) / len(results)
    runs = sum(item.report["simulations"] for item in results)
    good = sum(item.realised for item in results)
    if len(results) == 1:
        word = "**realised**" if good else results[0].report["outcome"]
    else:
        word = f"{good} of {len(results)} wordings"
    return f"{word}, {rounds:g} rounds, {runs} runs"
