"""`physagent bench paper`: 80 events of 27 drawn pictures, with and without reflection, and plain.

Every event is a picture, clicks and a sentence in a case folder, and runs as a person's photograph
would. The first round of a run is the run without reflection: the same program, judged alike.
"""

import hashlib
import html
import os
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

import physagent_studio
from physagent_studio.benchmark.events.bench import tell
from physagent_studio.benchmark.events.event_run import EventResult, EventTask, run_apart
from physagent_studio.benchmark.events.references import reference_path
from physagent_studio.benchmark.paper.listing import FAMILIES, Event, events, write_case
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.errors import InputError
from physagent_studio.workbench.engine import limits_of

VARIANTS = ("full", "no_semantics", "model")
"""Runs of an event; what is without reflection is read off the first round of `full`."""
REALISED = 70 / 80
"""Least share of the events that are realised with reflection."""
GAIN = 15.0
"""Least percentage points by which reflection has to raise that share."""
DRAWN = 3000
"""Seed by which a small dose of the events is drawn."""
_NOT_READ = ("studio", "cli", "benchmark")
"""Rooms whose code decides nothing about what comes of an event."""
_RESULT = TypeAdapter(EventResult)


@dataclass(frozen=True, slots=True)
class Outcome:
    """An event with what came of it in each variant that was run."""

    event: Event
    results: dict[str, EventResult]


def bench(
    *,
    cases: Path | None,
    out: Path | None,
    sheets: Path | None = None,
    only: Sequence[str] = (),
    count: int | None = None,
    variants: Sequence[str] = (),
) -> list[Row]:
    """Runs the events and returns the paper's tables as rows; the page goes to `out`.

    sheets: folder of pictures, contact sheets and results; what is there already from the same
    version of the package is not run again. only: `scene` or `scene/event`. count: a small
    dose, so many events drawn by seed. variants: names of `VARIANTS`; by default all, `model`
    where an endpoint is set.
    """
    if cases is not None:
        raise InputError("the bench paper draws its own pictures; leave --cases out")
    chosen, names = chosen_events(only, count), _variants(variants)
    with ExitStack() as stack:
        folder = sheets or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        root = folder.resolve()
        outcomes = [Outcome(e, {name: _run(e, root, name) for name in names}) for e in chosen]
        if out is not None:
            write_page(out, outcomes, root)
    return figures(outcomes)


def chosen_events(only: Sequence[str], count: int | None) -> list[Event]:
    """The events that are asked for, in their order; raises InputError where there are none."""
    found = [e for e in events() if not only or e.label in only or e.scene in only]
    if not found:
        raise InputError(f"the bench paper has no event or scene called {' or '.join(only)}")
    if count is not None and count < len(found):
        drawn = np.random.default_rng(DRAWN).permutation(len(found))[: max(count, 1)]
        found = [found[k] for k in sorted(drawn)]
    return found


def _variants(wanted: Sequence[str]) -> tuple[str, ...]:
    for name in wanted:
        if name not in VARIANTS:
            raise InputError(f"there is no variant '{name}' (known: {', '.join(VARIANTS)})")
    # Settings that are wrong or missing say why where a model is asked for by name.
    return tuple(wanted) or (VARIANTS if limits_of("vlm") else VARIANTS[:2])


def _run(event: Event, folder: Path, variant: str) -> EventResult:
    """The result that is kept from before, else a run; kept at once, so that it can go on."""
    name = f"{event.scene}__{event.name}"
    case = write_case(event.scene, folder)
    reference = reference_path(folder / "references", event.scene, event.name)
    assert reference is not None
    key = _key(reference, case / "case.yaml", case / "input.png")
    kept = folder / "results" / f"{name}__{variant}__{key}.json"
    if kept.is_file():
        return _RESULT.validate_json(kept.read_bytes())
    sheet = folder / "sheets" / f"{name}__{variant}.png"
    result = run_apart(EventTask(case, event.name, None, reference, variant, sheet))[0]
    tell(result)
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.with_suffix(".part").write_bytes(_RESULT.dump_json(result))
    kept.with_suffix(".part").rename(kept)
    return result


def _key(*files: Path) -> str:
    """Ten digits that change with what a run reads: the files, and the rooms that carry it out."""
    digest = hashlib.sha256()
    for path in (*_rooms(), *files):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:10]


@cache
def _rooms() -> tuple[Path, ...]:
    folder = Path(physagent_studio.__file__).parent
    read = (path for path in sorted(folder.rglob("*")) if path.suffix in (".py", ".yaml", ".md"))
    return tuple(path for path in read if path.relative_to(folder).parts[0] not in _NOT_READ)


# --- figures -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the paper's tables: how many of how many events, and rounds of those realised."""

    words: str
    realised: int
    count: int
    rounds: float | None

    @property
    def share(self) -> float:
        """Percent of the events."""
        return 100 * self.realised / self.count


def lines_of(outcomes: Sequence[Outcome]) -> dict[str, Line]:
    """A line for each variant that was run, by its name."""
    out: dict[str, Line] = {}
    full = [o.results["full"] for o in outcomes if "full" in o.results]
    if full:
        out["full"] = _line("rules, with reflection", full)
        once = sum(item.at_once for item in full)
        out["no_reflection"] = Line("rules, without reflection", once, len(full), 1.0)
    for name, words in (("no_semantics", "rules, plain vectors"), ("model", "a model")):
        mine = [o.results[name] for o in outcomes if name in o.results]
        if mine:
            out[name] = _line(words, mine)
    return out


def _line(words: str, results: Sequence[EventResult]) -> Line:
    good = [item for item in results if item.realised]
    rounds = [float(item.passed_in or 0) for item in good]
    return Line(words, len(good), len(results), float(np.mean(rounds)) if rounds else None)


def figures(outcomes: Sequence[Outcome]) -> list[Row]:
    """The paper's tables as rows: each variant, then the families, then what is held to a bound."""
    lines = lines_of(outcomes)
    rows: list[Row] = []
    for line in lines.values():
        rows.append(shown(f"{line.words}: realised of {line.count}", line.realised, "events"))
        if line.rounds is not None:
            rows.append(shown(f"{line.words}: rounds, mean", round(line.rounds, 2), "rounds"))
    for family, words in FAMILIES.items():
        mine = [outcome for outcome in outcomes if outcome.event.family == family]
        for line in lines_of(mine).values():
            name = f"{words}, {line.words}: realised of {line.count}"
            rows.append(shown(name, line.realised, "events"))
    return rows + _bounds(outcomes, lines)


def _bounds(outcomes: Sequence[Outcome], lines: dict[str, Line]) -> list[Row]:
    if "full" not in lines:
        return []
    full, once = lines["full"], lines["no_reflection"]
    results = [outcome.results["full"] for outcome in outcomes]
    failed = sum(bool(item.problem) for item in results)
    return [
        at_least("realised with every view check, share", full.realised / full.count, REALISED),
        at_least("reflection gains", full.share - once.share, GAIN, "points"),
        shown("claimed, but the reference denies it", sum(r.denied for r in results), "events"),
        at_most("events that ended by an error", failed, 0, "events"),
    ]


_INTRO = """\
# The paper's benchmark, with pictures of our own

Made by `physagent bench paper --sheets FOLDER --out PAGE.md`; docs/paper.md says what counts.
*Without reflection*: the first round of the same run. *Rounds*: until the first that passed, of
the events that were realised. The paper states 3.63 with its loop and 5.74 without semantic
actions; its pictures, sentences and judge are others, so that no figure is the same as ours.
"""


def write_page(out: Path, outcomes: Sequence[Outcome], folder: Path) -> None:
    """Writes the page, Markdown; pictures are linked where they lie below `folder`."""
    lines = [_INTRO, *_table(outcomes), "", "## Events", ""]
    for outcome in outcomes:
        lines += [*_section(outcome, out.resolve().parent, folder), ""]
    out.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


def _table(outcomes: Sequence[Outcome]) -> list[str]:
    """A row for each variant with a column for each family, as in the paper."""
    lines = [
        f"| | realised | rounds | {' | '.join(FAMILIES.values())} |",
        f"|---|---|---|{'---|' * len(FAMILIES)}",
    ]
    for name, line in lines_of(outcomes).items():
        cells = []
        for family in FAMILIES:
            mine = lines_of([one for one in outcomes if one.event.family == family])
            cells.append(_share(mine.get(name)))
        rounds = "–" if line.rounds is None else f"{line.rounds:.2f}"
        lines.append(f"| {line.words} | {_share(line)} | {rounds} | {' | '.join(cells)} |")
    return lines


def _share(line: Line | None) -> str:
    if line is None:
        return "–"
    return f"{line.realised} of {line.count} ({line.share:.0f} %)"


def _section(outcome: Outcome, beside: Path, folder: Path) -> list[str]:
    event = outcome.event
    lines = [f"### {event.label}: {FAMILIES[event.family]}", "", f"> {event.prompt}", ""]
    for name, result in outcome.results.items():
        lines.append(f"- {name}: {_words(result)}")
        lines += [f"  - {text}" for text in reasons(result)]
    for name in outcome.results:
        sheet = folder / "sheets" / f"{event.scene}__{event.name}__{name}.png"
        if sheet.is_file():
            there = html.escape(os.path.relpath(sheet, beside))
            lines += ["", f'<img src="{there}" alt="{event.label}, {name}" width="640">']
    return lines


def _words(result: EventResult) -> str:
    report = result.report
    said = "**realised**" if result.realised else str(report["outcome"])
    said = "claimed, but the reference denies it" if result.denied else said
    rounds = f"passed in round {result.passed_in}" if result.passed_in else "no round passed"
    return f"{said}, {rounds} of {report['rounds']}, {report['seconds']:.0f} s"


def reasons(result: EventResult) -> list[str]:
    """Why an event is not realised: what the reference or the agent's own checks miss."""
    if result.realised:
        return []
    if result.problem:
        return [f"ended by an error: {result.problem}"]
    report = result.report
    lines = [f"reference: {text}" for text in result.failing]
    for part in ("contract", "physics", "view"):
        lines += [f"{part}: {row['statement']}" for row in report.get(part, ()) if not row["ok"]]
    lines += [f"untested: {text}" for text in report.get("untested", ())]
    return lines + [f"not understood: {text}" for text in report.get("not_understood", ())]
