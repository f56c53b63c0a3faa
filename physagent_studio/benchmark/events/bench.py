"""Events of case folders, run end to end by the embedded agent, held against references."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import physagent_studio
from physagent_studio.benchmark.events.event_run import EventResult, EventTask, run_apart
from physagent_studio.benchmark.events.references import reference_path
from physagent_studio.benchmark.events.results_page import mode_of, page
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.errors import InputError
from physagent_studio.exchange import load_case

SECONDS_PER_EVENT = 30.0
SHARE_CLICKS, SHARE_ANNOTATED = 10 / 21, 16 / 21
MEAN_ROUNDS = 3.6
AGREEMENT = 0.9


def bench(
    *,
    cases: Path | None,
    out: Path | None,
    annotations: Path | None = None,
    references: Path | None = None,
    only: Iterable[str] = (),
) -> list[Row]:
    """Runs every event below `cases`, as it is and annotated; rows, and a page at `out`.

    annotations, references: folders; by default beside the cases, else those of a checkout.
    only: `case` or `case/event`.
    """
    tasks = tasks_below(cases, annotations, references, tuple(only))
    results = []
    for task in tasks:
        results += run_apart(task)
        tell(results[-1])
    rows = figures(results)
    if out is not None:
        out.write_text(page(results, _lines(rows)), encoding="utf-8")
    return rows


def tasks_below(
    cases: Path | None,
    annotations: Path | None,
    references: Path | None,
    only: tuple[str, ...] = (),
) -> list[EventTask]:
    """Every event as it is, and annotated where there is a file for its case."""
    if cases is None or not cases.is_dir():
        raise InputError("give the folder of case folders with --cases")
    notes = _folder(annotations, "annotations", cases)
    refs = _folder(references, "reference_contracts", cases)
    tasks = []
    for folder, event in events_below(cases, only):
        reference = reference_path(refs, folder.name, event) if refs else None
        tasks.append(EventTask(folder, event, None, reference))
        note = notes / f"{folder.name}.yaml" if notes else None
        if note is not None and note.is_file():
            tasks.append(EventTask(folder, event, note, reference))
    if not tasks:
        wanted = f" that is called {' or '.join(only)}" if only else ""
        raise InputError(f"there is no event{wanted} below {cases}")
    return tasks


def events_below(cases: Path, only: tuple[str, ...] = ()) -> list[tuple[Path, str]]:
    """(case folder, event) below a folder; `only` picks `case/event` or whole `case`s."""
    found = []
    for path in sorted(cases.glob("*/case.yaml")):
        for name, _ in load_case(path.parent, None).events:
            label = f"{path.parent.name}/{name}"
            if not only or label in only or path.parent.name in only:
                found.append((path.parent, name))
    return found


def _folder(given: Path | None, name: str, cases: Path) -> Path | None:
    if given is not None:
        if not given.is_dir():
            raise InputError(f"there is no folder {given}")
        return given
    checkout = Path(physagent_studio.__file__).resolve().parent.parent
    for folder in (cases / name, cases.parent / name, checkout / "tests" / name):
        if folder.is_dir():
            return folder
    return None


def tell(item: EventResult) -> None:
    """One line about a result on standard error, for whoever waits."""
    report = item.report
    words = "realised" if item.realised else report["outcome"]
    if item.denied:
        words = "claimed, but the reference denies it"
    print(
        f"{item.label}, {mode_of(item)}{_variant(item)}: {words}, {report['rounds']} rounds, "
        f"{report['simulations']} simulations, {report['seconds']:.1f} s"
        + (" · happens by itself as well" if item.by_itself else "")
        + (f" · {item.problem}" if item.problem else "")
        + (f" · reference: {'; '.join(item.failing)}" if item.failing else ""),
        file=sys.stderr,
        flush=True,
    )


def _variant(item: EventResult) -> str:
    return "" if item.variant == "full" else f", {item.variant}"


# --- figures -----------------------------------------------------------------------------------


def figures(results: Sequence[EventResult]) -> list[Row]:
    """A row for each event, then the figures of each mode, then those of all together."""
    rows = [_event_row(item) for item in results]
    for with_notes, share in ((False, SHARE_CLICKS), (True, SHARE_ANNOTATED)):
        chosen = [item for item in results if item.annotated == with_notes]
        if chosen:
            rows += _mode_rows(chosen, share)
    rows += _agreement_rows(results)
    return rows


def _event_row(item: EventResult) -> Row:
    report = item.report
    words = "realised" if item.realised else "denied" if item.denied else report["outcome"]
    value = f"{words}, {report['rounds']} rounds, {report['simulations']} simulations"
    ok = not item.problem and not item.denied
    return Row(f"{item.label}, {mode_of(item)}", f"{value}, {report['seconds']:.1f} s", "", "", ok)


def _mode_rows(results: Sequence[EventResult], share: float) -> list[Row]:
    mode = mode_of(results[0])
    realised = [item for item in results if item.realised]
    least = math.ceil(round(share * len(results), 6))
    rows = [at_least(f"{mode}: realised of {len(results)}", len(realised), least, "events")]
    if realised:
        mean = sum(item.report["rounds"] for item in realised) / len(realised)
        name = f"{mode}: rounds per realised event, mean"
        rows.append(at_most(name, round(mean, 3), MEAN_ROUNDS, "rounds"))
    seconds = [item.report["seconds"] for item in results]
    rows.append(at_most(f"{mode}: slowest event", max(seconds), SECONDS_PER_EVENT, "s"))
    worked = [item.report["cpu_seconds"] for item in results]
    rows.append(shown(f"{mode}: processor time of the slowest", max(worked), "s"))
    runs = sum(item.report["simulations"] for item in results)
    rows.append(shown(f"{mode}: simulations, all events", runs, "runs"))
    assumed = sum(1 for item in realised if item.assumed)
    rows.append(shown(f"{mode}: realised at an assumed landmark", assumed, "events"))
    alone = sum(1 for item in realised if item.by_itself)
    rows.append(shown(f"{mode}: realised, and happens by itself as well", alone, "events"))
    failed = sum(1 for item in results if item.problem)
    rows.append(at_most(f"{mode}: events that ended by an error", failed, 0, "events"))
    return rows


def _agreement_rows(results: Sequence[EventResult]) -> list[Row]:
    judged = [r for r in results if r.reference_holds is not None and r.own_holds is not None]
    if not judged:
        return [shown("reference contracts", "none", "")]
    same = sum(1 for item in judged if item.own_holds == item.reference_holds)
    share = same / len(judged)
    denied = sum(1 for item in judged if item.denied)
    return [
        at_least(
            f"own contract agrees with the reference, {len(judged)} rollouts", share, AGREEMENT
        ),
        at_most("events claimed that the reference denies", denied, 0, "events"),
    ]


def _lines(rows: Sequence[Row]) -> list[str]:
    """The figures that are not about one event, as a Markdown table."""
    lines = ["| figure | value | bound | |", "|---|---|---|---|"]
    for row in rows:
        if isinstance(row.value, str):
            continue
        value = f"{row.value:.3g} {row.unit}".strip()
        lines.append(f"| {row.name} | {value} | {row.bound} | {'✓' if row.ok else '✗'} |")
    return lines
