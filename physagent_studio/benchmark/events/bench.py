"""Events of case folders, run end to end: the references, every view check, and sheets to grade.

An event counts where the agent says that it happened (its demands, the physics and every check of
the view hold) and its reference contract does not deny it. A person grades the sheets; no figure
here stands for that.
"""

import statistics
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

import physagent_studio
from physagent_studio.benchmark.events.event_run import EventResult, EventTask, run_apart
from physagent_studio.benchmark.events.references import reference_path
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.errors import InputError
from physagent_studio.exchange import load_case

SHARE = 25 / 29
"""Least part of the events that are realised with every view check, clicks alone."""
MOTION = 45.0
"""Least median of the frames in which something moves."""
ROUNDS, SECONDS = 4.0, 30.0
ASKED = 6
"""Most events of 29 in which a mask is doubted, so that a run would wait for an answer."""
AGREEMENT = 0.9
"""Least share of the rollouts on which the agent's own contract and the reference agree."""


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

    annotations, references: folders; by default beside the cases, else those of a checkout.
    only: `case` or `case/event`. sheets: folder for a contact sheet of each, with its sentence as
    text beside it; grades that a person wrote to `grades.json` there (sheet's name: [grade,
    reason]) come into the page. out:
    also write the page, Markdown.
    """
    results: list[EventResult] = []
    for task in tasks_below(cases, annotations, references, tuple(only)):
        if sheets is not None:
            name = _sheet_name(task.label, task.annotation is not None)
            task = replace(task, sheet=sheets.resolve() / f"{name}.png")
        results += run_apart(task)
        tell(results[-1])
    rows = figures(results)
    if out is not None:
        out.write_text(_page(results, rows, sheets), encoding="utf-8")
    return [*(_row(item) for item in results), *rows]


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
    variant = "" if item.variant == "full" else f", {item.variant}"
    print(
        f"{item.label}, {mode_of(item)}{variant}: {words}, {report['rounds']} rounds, "
        f"{report['simulations']} simulations, {report['seconds']:.1f} s"
        + (" · happens by itself as well" if item.by_itself else "")
        + (f" · {item.problem}" if item.problem else "")
        + (f" · reference: {'; '.join(item.failing)}" if item.failing else ""),
        file=sys.stderr,
        flush=True,
    )


def mode_of(item: EventResult) -> str:
    """`annotated` or `clicks alone`."""
    return "annotated" if item.annotated else "clicks alone"


# --- figures -----------------------------------------------------------------------------------


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


def figures(results: Sequence[EventResult]) -> list[Row]:
    """The figures of each mode, then those of all events together."""
    rows: list[Row] = []
    for mode in dict.fromkeys(mode_of(item) for item in results):
        rows += _figures(mode, [item for item in results if mode_of(item) == mode])
    return rows + _agreement_rows(results)


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
    doubted = sum(any(d["kind"] == "mask" for d in i.report.get("doubts", ())) for i in results)
    rows.append(at_most(f"{mode}: wait for an answer about a mask", doubted, ASKED, "events"))
    failed = sum(bool(item.problem) for item in results)
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


_INTRO = """\
# Results on real photographs

Made by `physagent bench view --cases FOLDER --sheets SHEETS --out docs/results.md` with the
embedded agent (rules, no network, no GPU), policy `auto`, at most ten rounds. The photographs are
not part of this repository.

An event counts as realised when the agent says so (its demands, the physics and every check of what
a viewer sees hold) and a reference contract, written by hand from the sentence where there is one,
holds as well. *Clicks alone*: the case as it is. *Annotated*: with what a person would click beyond
that. *Motion*: frames of 81 in which something is seen to move. *Time*: simulated seconds for each
second shown. *Fastest*: farthest step from frame to frame, parts of the picture's width. *Grade*:
0 to 1, by one who saw eight frames and the sentence and nothing else.
"""


_COLUMNS = (
    "event", "mode", "outcome", "rounds", "seconds", "motion", "time", "fastest", "grade",
    "why not 1",
)  # fmt: skip


def _page(results: Sequence[EventResult], rows: Sequence[Row], sheets: Path | None) -> str:
    """The page of results: the figures, and a line for each event."""
    grades = _grades(sheets)
    lines = [_INTRO, "| figure | value | bound | |", "|---|---|---|---|"]
    for row in rows:
        value = f"{row.value:.3g}" if isinstance(row.value, float) else str(row.value)
        lines.append(
            f"| {row.name} | {value} {row.unit} | {row.bound} | {'✓' if row.ok else '✗'} |"
        )
    if grades:
        mean = statistics.fmean(float(grade) for grade, _ in grades.values())
        lines.append(f"| grade by eye, mean of {len(grades)} | {mean:.2f} | | |")
    lines += [
        "",
        f"| {' | '.join(_COLUMNS)} |",
        f"|{'---|' * len(_COLUMNS)}",
    ]
    for item in results:
        pace, name = _pacing(item), _sheet_name(item.label, item.annotated)
        grade, reason = grades.get(name, ("", ""))
        failing = [c["statement"] for c in _view(item) if not c["ok"]]
        words = "**realised**" if item.realised else item.report["outcome"]
        words += f" ({'; '.join(failing[:2])})" if failing else ""
        lines.append(
            f"| {item.label} | {mode_of(item)} | {words} | {item.report['rounds']} "
            f"| {item.report['seconds']:.0f} | {pace['moving']} | ×{pace['time_factor']:.2g} "
            f"| {100 * pace['fastest']:.1f} % | {grade} | {reason} |"
        )
    return "\n".join(lines) + "\n"


def _sheet_name(label: str, annotated: bool) -> str:
    return f"{label.replace('/', '__')}__{'annotated' if annotated else 'clicks'}"


def _grades(sheets: Path | None) -> dict[str, tuple[float, str]]:
    """A person's grades of sheets, by their names: `grades.json` beside them; none without it.

    Raises InputError where the file is something else.
    """
    path = None if sheets is None else sheets / "grades.json"
    if path is None or not path.is_file():
        return {}
    try:
        return _GRADES.validate_json(path.read_bytes())
    except ValidationError as error:
        raise InputError(f"{path} is not a table of grades: {error}") from None


_GRADES = TypeAdapter(dict[str, tuple[float, str]])
