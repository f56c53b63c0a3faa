"""A sweep as one page that opens anywhere: success over two numbers, margins, contact times."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.exchange.files import written
from physagent_studio.sweep.plots import dots, share_over_one, share_over_two
from physagent_studio.sweep.table import Table

MOST_PLOTS = 12
"""Margins, and contact times, that a page shows of one target; the table has all of them."""
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
  color: #1c1c1c; background: #fff }
.plots { display: flex; flex-wrap: wrap; gap: 1rem } figure { margin: 0; width: 29rem }
figcaption { font-weight: 600; font-size: 13px } svg { width: 100%; font-size: 11px }
svg text { fill: currentColor } .axis { stroke: currentColor; fill: none; stroke-width: 1 }
@media (prefers-color-scheme: dark) { body { color: #e4e4e4; background: #181818 } }
"""


def write_page(table: Table, path: Path, title: str, said: tuple[str, ...]) -> None:
    """Writes the page. said: sentences that stand at its head."""
    labels = list(dict.fromkeys(table.column("target")))
    parts = [part for label in labels for part in _target(table, str(label), len(labels) > 1)]
    head = "".join(f"<p>{escape(line)}</p>" for line in said)
    text = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(title)}</title>'
        f"<style>{STYLE}</style><h1>{escape(title)}</h1>{head}{''.join(parts)}</html>\n"
    )
    with written(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _target(table: Table, label: str, named: bool) -> list[str]:
    rows = [row for row in table.rows if row["target"] == label]
    mine = Table(rows, table.fields, table.margins, table.touches)
    holds = np.array([row["holds"] for row in rows], float)
    said = f"{int(holds.sum())} of {len(rows)} runs hold"
    parts = [f"<h2>{escape(label)}: {said}</h2>" if named else f"<p>{said}</p>"]
    varied = telling(mine, holds)
    if not varied:
        return parts
    first = _numbers(mine, varied[0])
    parts += ["<h3>What holds</h3>", '<div class="plots">']
    if len(varied) > 1:
        parts.append(
            share_over_two(first, _numbers(mine, varied[1]), holds, (varied[0], varied[1]))
        )
    parts += [share_over_one(_numbers(mine, name), holds, name) for name in varied[:2]]
    for heading, columns in (
        ("Margins: at nothing and above, a statement holds", _worth_seeing(mine)),
        ("First contacts, s", mine.touches),
    ):
        plots = [dots(first, _numbers(mine, name), holds, (varied[0], name)) for name in columns]
        plots = [plot for plot in plots if plot][:MOST_PLOTS]
        if plots:
            parts += ["</div>", f"<h3>{heading}</h3>", '<div class="plots">', *plots]
    return [*parts, "</div>"]


def _worth_seeing(table: Table) -> list[str]:
    """The margins of what the contract states, and of all else that fails somewhere."""
    # What always has to hold is called by a path, such as `physics.energy`.
    return [
        name
        for name in table.margins
        if "." not in name or np.nanmin(_numbers(table, name), initial=0.0) < 0
    ]


def telling(table: Table, holds: FloatArray) -> list[str]:
    """The fields that have several values: those of a grid as they come, then the most telling."""
    found = []
    for place, name in enumerate(table.fields):
        values = _numbers(table, name)
        known = np.unique(values[np.isfinite(values)])
        if len(known) > 1 and np.isfinite(values).all():
            # Few values are those of a grid: what was asked for comes before what was only moved.
            drawn = len(known) == len(values) and len(table.fields) > 2
            found.append((drawn, -_correlation(values, holds) if drawn else 0.0, place, name))
    return [name for *_, name in sorted(found)]


def _correlation(values: FloatArray, holds: FloatArray) -> float:
    if holds.std() == 0 or values.std() == 0:
        return 0.0
    return abs(float(np.corrcoef(values, holds)[0, 1]))


def _numbers(table: Table, name: str) -> FloatArray:
    return np.array([np.nan if one is None else one for one in table.column(name)], float)
