"""The page of results: each event with rounds, seconds, simulations and every check."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from physagent_studio.benchmark.events.event_run import EventResult

MAIN = (
    "soccer_ball/rolls_over_line",
    "soccer_ball/kicked_into_goal",
    "cube_table_edge/flips_left_off",
    "bowling/right_pin_only",
    "persimmons/two_fall_one_stays",
    "pumpkin_stool/falls_on_stool",
    "toy_car_ramp/reaches_table",
)
"""Events that come first on the page."""

_INTRO = """\
# Results on real photographs

Made by `physagent bench events --cases FOLDER --out docs/results.md` with the embedded agent
(rules, no network, no GPU), policy `auto`, at most ten rounds, nothing rendered. The photographs
are not part of this repository.

An event counts as realised when the agent says so and a reference contract, written by hand from
the prompt's words before the agent was tuned, holds on the final rollout as well. *Clicks alone*:
the case as it is. *Annotated*: with what a person would click beyond that (horizon, one size,
supports, landmarks; `tests/annotations`), never an action. A landmark that nobody clicked is put
where the prompt makes it likely; such rows say "assumed". "By itself as well": the reference also
holds on the final scene when nothing is done, as where a thing hangs in the air and falls.
"""


def page(results: Sequence[EventResult], figures: Sequence[str]) -> str:
    """The Markdown page. figures: lines about all events together."""
    order = {label: index for index, label in enumerate(MAIN)}
    ranked = sorted(results, key=lambda r: (order.get(r.label, len(order)), r.label, r.annotated))
    first = [item for item in ranked if item.label in order]
    lines = [_INTRO, *figures, ""]
    if first:
        lines += ["## Main events", "", *_table(first), ""]
    lines += ["## All events", "", *_table(ranked), "", "## Every check", ""]
    for item in ranked:
        lines += [*_section(item), ""]
    return "\n".join(lines).rstrip() + "\n"


def _table(results: Sequence[EventResult]) -> list[str]:
    lines = [
        "| event | mode | realised | agent says | reference | rounds | simulations | seconds |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for item in results:
        report = item.report
        says = ", assumed ".join((report["outcome"], *item.assumed))
        says += ", by itself as well" if item.by_itself else ""
        lines.append(
            f"| {item.label} | {mode_of(item)} | {'**yes**' if item.realised else 'no'} | {says} "
            f"| {_word(item.reference_holds)} | {report['rounds']} | {report['simulations']} "
            f"| {report['seconds']:.1f} |"
        )
    return lines


def mode_of(item: EventResult) -> str:
    """`annotated` or `clicks alone`."""
    return "annotated" if item.annotated else "clicks alone"


def _word(holds: bool | None) -> str:
    return "–" if holds is None else "holds" if holds else "does not hold"


def _section(item: EventResult) -> list[str]:
    lines = [f"### {item.label}, {mode_of(item)}", "", f"> {item.prompt}", ""]
    if item.problem:
        lines += [f"Ended by an error: {item.problem}", ""]
    if item.report["contract"]:
        lines += ["The agent's contract:", "", *_checks(item.report["contract"]), ""]
    if item.reference:
        lines += ["The reference:", "", *_checks(item.reference), ""]
    for key, title in (
        ("diagnosis", "Diagnosis"),
        ("untested", "Untested clause"),
        ("not_understood", "Not understood"),
    ):
        lines += [f"- {title}: {text}" for text in item.report.get(key, ())]
    missing = [text for text in item.failing if text.startswith("the scene has no")]
    return [*lines, *(f"- Reference: {text}" for text in missing)]


def _checks(rows: Sequence[dict[str, Any]]) -> list[str]:
    lines = ["| | statement | measured | threshold | margin |", "|---|---|---|---|---|"]
    for row in rows:
        lines.append(
            f"| {'✓' if row['ok'] else '✗'} | {row['statement'].replace('|', '/')} "
            f"| {_number(row['measured'], row['unit'])} "
            f"| {_number(row['threshold'], row['unit'])} | {row['margin']:+.3g} |"
        )
    return lines


def _number(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.3g} {unit}".strip()
