"""A sweep as one page that opens anywhere: success over two numbers, margins, contact times."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.exchange.files import written
from physagent_studio.sweep.plots import dots, shares
from physagent_studio.sweep.table import CONTACT, MARGIN, Columns, fields_of

MOST_PLOTS = 12
"""Margins, and contact times, that a page shows of one target; the table has all of them."""
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
  color: #1c1c1c; background: #fff }
.plots { display: flex; flex-wrap: wrap; gap: 1rem } figure { margin: 0; width: 29rem }
figcaption { font-weight: 600; font-size: 13px } svg { width: 100%; font-size: 11px }
svg text { fill: currentColor } .axis { stroke: currentColor; fill: none }
@media (prefers-color-scheme: dark) { body { color: #e4e4e4; background: #181818 } }
"""


def write_page(columns: Columns, path: Path, said: list[str]) -> None:
    """Writes the page. said: sentences that stand at its head."""
    parts = [f"<p>{escape(line)}</p>" for line in said]
    for label in dict.fromkeys(columns["target"]):
        mine = [place for place, one in enumerate(columns["target"]) if one == label]
        of_target = {name: [column[k] for k in mine] for name, column in columns.items()}
        parts += [f"<h2>{escape(label)}</h2>", *_sections(of_target)]
    text = (
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>Sweep</title>'
        f"<style>{STYLE}</style><h1>Sweep</h1>{''.join(parts)}</html>\n"
    )
    with written(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _sections(columns: Columns) -> list[str]:
    holds = np.array(columns["holds"], float)
    numbers = {name: _numbers(columns, name) for name in fields_of(columns)}
    varied = telling(numbers, holds)
    parts = [f"<p>{int(holds.sum())} of {len(holds)} runs hold.</p>"]
    if not varied:
        return parts
    first, *others = varied[:2]
    level = np.zeros(len(holds))
    plots = [shares(numbers[name], level, holds, (name, "share that holds")) for name in varied[:2]]
    for second in others:
        head = (first, f"share that holds, with {second} upwards")
        plots.insert(0, shares(numbers[first], numbers[second], holds, head))
    margins = [
        name
        for name in columns
        # What always has to hold is called by a path, such as `physics.energy`.
        if name.startswith(MARGIN)
        and ("." not in name or np.nanmin(_numbers(columns, name), initial=0.0) < 0)
    ]
    contacts = [name for name in columns if name.startswith(CONTACT)]
    sections = {
        "What holds": plots,
        "Margins: a statement holds at nothing and above": _dotted(columns, first, margins),
        "First contacts, s": _dotted(columns, first, contacts),
    }
    for heading, pictures in sections.items():
        parts.append(f'<h3>{heading}</h3><div class="plots">{"".join(pictures)}</div>')
    return parts


def _dotted(columns: Columns, first: str, names: list[str]) -> list[str]:
    x, holds = _numbers(columns, first), np.array(columns["holds"], float)
    plots = [dots(x, _numbers(columns, name), holds, (first, name)) for name in names]
    return [plot for plot in plots if plot][:MOST_PLOTS]


def telling(numbers: dict[str, FloatArray], holds: FloatArray) -> list[str]:
    """The fields that have several values, the one that goes along with success most first."""
    varied = [name for name, one in numbers.items() if np.isfinite(one).all() and one.std() > 0]
    if holds.std() == 0:
        return varied
    return sorted(varied, key=lambda name: -abs(np.corrcoef(numbers[name], holds)[0, 1]))


def _numbers(columns: Columns, name: str) -> FloatArray:
    return np.array([np.nan if one is None else one for one in columns[name]], float)
