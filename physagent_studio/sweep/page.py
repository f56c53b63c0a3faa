"""A sweep as columns, and as a page: success over two numbers, margins, contact times."""

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.exchange.files import written
from physagent_studio.sweep.plan import Point
from physagent_studio.sweep.run import Ran

WIDTH, HEIGHT = 420, 300
LEFT, BOTTOM, TOP, RIGHT = 62, 44, 14, 14
"""Margins of the axes, px."""
ACROSS, UP = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
BINS = 10
"""Cells along an axis whose values are drawn and not of a grid."""
MOST_DOTS = 2000
"""Points of one plot; of more every so manyth is drawn."""
Ends = tuple[float, float]


def shares(x: FloatArray, y: FloatArray, holds: FloatArray, names: tuple[str, str]) -> str:
    """Cells coloured by the share of runs that hold, which each says under the pointer.

    Where y is one value all over: bars as high as that share.
    """
    (columns, i), (rows, j) = _cells(x), _cells(y)
    wide, high, bars = ACROSS / len(columns), UP / len(rows), len(rows) == 1
    body = []
    for a, b in sorted(set(zip(i.tolist(), j.tolist(), strict=True))):
        inside = holds[(i == a) & (j == b)]
        share = float(inside.mean())
        tall, shade = (share * high, _shade(1.0)) if bars else (high, _shade(share))
        body.append(
            f'<rect x="{LEFT + a * wide:.1f}" y="{TOP + UP - b * high - tall:.1f}"'
            f' width="{wide - bars:.1f}" height="{tall:.1f}" fill="{shade}"><title>'
            f"{columns[a]:.4g}, {rows[b]:.4g}: {share:.0%} of {len(inside)}</title></rect>"
        )
    ends = (columns[0], columns[-1]), ((0.0, 1.0) if bars else (rows[0], rows[-1]))
    return _framed(body, names, ends, (wide / 2, 0.0 if bars else high / 2))


def dots(x: FloatArray, y: FloatArray, holds: FloatArray, names: tuple[str, str]) -> str:
    """A point for each run, green where all holds; a line at nothing, where margins end."""
    kept = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    kept = kept[:: max(len(kept) // MOST_DOTS, 1)]
    if not len(kept):
        return ""
    across, up = _ends(x[kept]), _ends(np.append(y[kept], 0.0))
    level = TOP + UP * (1 - _share(0.0, up))
    body = [f'<path d="M{LEFT} {level:.1f}h{ACROSS}" class="axis"/>']
    body += [
        f'<circle cx="{LEFT + ACROSS * _share(float(x[k]), across):.1f}"'
        f' cy="{TOP + UP * (1 - _share(float(y[k]), up)):.1f}" r="3"'
        f' fill="{_shade(float(holds[k]))}"/>'
        for k in kept
    ]
    return _framed(body, names, (across, up), (0.0, 0.0))


def _cells(values: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
    """The values of a grid, or the middles of ranges, and in which of them each value lies."""
    known, places = np.unique(values, return_inverse=True)
    if len(known) <= 2 * BINS:
        return known, places
    edges = np.linspace(known[0], known[-1], BINS + 1)
    places = np.clip(np.digitize(values, edges) - 1, 0, BINS - 1).astype(np.intp)
    return (edges[1:] + edges[:-1]) / 2, places


def _ends(values: FloatArray) -> Ends:
    low, high = float(values.min()), float(values.max())
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _share(value: float, ends: Ends) -> float:
    return (value - ends[0]) / (ends[1] - ends[0])


def _shade(share: float) -> str:
    """From orange to green by way of grey, told apart by who does not see red and green."""
    ends = np.array([[214, 96, 32], [200, 200, 200], [24, 128, 112]], float)
    colour = [np.interp(share, (0, 0.5, 1), ends[:, channel]) for channel in range(3)]
    return "#" + "".join(f"{round(part):02x}" for part in colour)


def _framed(
    body: Sequence[str], names: tuple[str, str], ends: tuple[Ends, Ends], inside: Ends
) -> str:
    """The plot with its axes. inside: how far from the corners their ends are written, px."""
    (low, high), (least, most) = ends
    right, bottom = LEFT + ACROSS, TOP + UP
    words = [
        (LEFT + inside[0], bottom + 16, "middle", f"{low:.4g}"),
        (right - inside[0], bottom + 16, "middle", f"{high:.4g}"),
        (LEFT - 6, bottom + 4 - inside[1], "end", f"{least:.4g}"),
        (LEFT - 6, TOP + 4 + inside[1], "end", f"{most:.4g}"),
        ((LEFT + right) / 2, HEIGHT - 8, "middle", escape(names[0])),
    ]
    told = [f'<text x="{x}" y="{y}" text-anchor="{at}">{text}</text>' for x, y, at, text in words]
    frame = f'<path d="M{LEFT} {TOP}V{bottom}H{right}" class="axis"/>'
    return (
        f"<figure><figcaption>{escape(names[1])}</figcaption>"
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}">{"".join([*body, frame, *told])}</svg></figure>'
    )


Columns = dict[str, list[Any]]
MARGIN, CONTACT = "margin ", "contact "
"""How the columns of margins and of times of first contacts, s, begin."""


HEAD = ("target", "seed", "holds", "problem", "program", "rollout")
"""The columns that every table has; what is neither of these nor of the others is what was set."""


def columns_of(found: Iterable[tuple[Point, Ran]]) -> Columns:
    """The columns of points and their runs, in the order of the points; None where one has none."""
    rows = [_row(point, ran) for point, ran in found]
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: [row.get(name) for row in rows] for name in names}


def _row(point: Point, ran: Ran) -> dict[str, Any]:
    program = point.program.hash if point.program else ""
    seed = point.seed if point.seed >= 0 else None
    told = (point.target.label, seed, ran.holds, ran.problem, program, ran.rollout)
    row: dict[str, Any] = dict(zip(HEAD, told, strict=True))
    # A field may be a whole number in one program and not in another.
    row |= {path: float(value) for path, value in point.values.items()}
    row |= {f"{MARGIN}{one.id}": one.margin for one in ran.checks if one.demanded}
    return row | {f"{CONTACT}{pair}": seconds for pair, seconds in ran.touches}


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
    others = (*HEAD, *(name for name in columns if name.startswith((MARGIN, CONTACT))))
    numbers = {name: _numbers(columns, name) for name in columns if name not in others}
    parts = [f"<p>{int(holds.sum())} of {len(holds)} runs hold.</p>"]
    if not (varied := telling(numbers, holds)[:2]):
        return parts
    first, level = varied[0], np.zeros(len(holds))
    plots = [shares(numbers[name], level, holds, (name, "share that holds")) for name in varied]
    if len(varied) > 1:
        head = (first, f"share that holds, with {varied[1]} upwards")
        plots = [shares(numbers[first], numbers[varied[1]], holds, head), *plots]
    # What always has to hold is called by a path, such as `physics.energy`: shown where it fails.
    failing = {name for name in others if name not in HEAD and _least(columns, name) < 0}
    margins = [name for name in others if name.startswith(MARGIN)]
    margins = [name for name in margins if "." not in name or name in failing]
    contacts = [name for name in others if name.startswith(CONTACT)]
    sections = {
        "What holds": plots,
        "Margins: a statement holds at nothing and above": _dotted(columns, first, margins),
        "First contacts, s": _dotted(columns, first, contacts),
    }
    for heading, pictures in sections.items():
        parts.append(f'<h3>{heading}</h3><div class="plots">{"".join(pictures)}</div>')
    return parts


def _least(columns: Columns, name: str) -> float:
    return float(np.nanmin(_numbers(columns, name), initial=0.0))


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
