"""Plots as SVG text: the share that holds over one or two numbers, and points over a number."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray

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
