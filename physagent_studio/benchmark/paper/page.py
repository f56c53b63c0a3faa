"""The page of the paper's benchmark: its tables, and every event with a picture."""

from __future__ import annotations

import html
import os
from collections.abc import Sequence
from pathlib import Path

from physagent_studio.benchmark.events.event_run import EventResult
from physagent_studio.benchmark.paper.bench import Line, Outcome, lines_of
from physagent_studio.benchmark.paper.listing import FAMILIES

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
