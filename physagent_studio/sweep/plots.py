"""Plots as SVG text: shares over one or two numbers, and points over a number."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray

WIDTH, HEIGHT = 420, 300
LEFT, BOTTOM, TOP, RIGHT = 62, 44, 14, 14
"""Margins of the axes, px."""
BINS = 10
"""Cells along an axis whose values are drawn and not of a grid."""
MOST_DOTS = 2000
"""Points of one plot; of more every so manyth is drawn."""


def share_over_two(x: FloatArray, y: FloatArray, holds: FloatArray, names: tuple[str, str]) -> str:
    """Cells coloured by the share of runs that hold; the share is written into each."""
    across, columns = _cells(x)
    up, rows = _cells(y)
    wide, high = _plot_size()
    wide, high = wide / len(across), high / len(up)
    body = []
    for i, j in sorted(set(zip(columns.tolist(), rows.tolist(), strict=True))):
        inside = holds[(columns == i) & (rows == j)]
        left, top = LEFT + i * wide, TOP + (len(up) - 1 - j) * high
        told = f"{names[0]} {across[i]:.4g}, {names[1]} {up[j]:.4g}: "
        told += f"{inside.mean():.0%} of {len(inside)}"
        body.append(
            f'<rect x="{left:.1f}" y="{top:.1f}" width="{wide:.1f}" height="{high:.1f}"'
            f' fill="{_shade(float(inside.mean()))}"><title>{escape(told)}</title></rect>'
        )
    ends = ((across[0], across[-1]), (up[0], up[-1]))
    head = (names[0], f"share that holds, with {names[1]} upwards")
    return _framed(body, head, ends, centred=(wide / 2, high / 2))


def share_over_one(x: FloatArray, holds: FloatArray, name: str) -> str:
    """A bar for each value, or range of values, as high as the share of runs that hold."""
    across, columns = _cells(x)
    wide, high = _plot_size()
    wide /= len(across)
    body = []
    for i in sorted(set(columns.tolist())):
        share = float(holds[columns == i].mean())
        top = TOP + (1 - share) * high
        told = f"{name} {across[i]:.4g}: {share:.0%} of {int((columns == i).sum())}"
        body.append(
            f'<rect x="{LEFT + i * wide + 1:.1f}" y="{top:.1f}" width="{max(wide - 2, 1):.1f}"'
            f' height="{share * high:.1f}" fill="{_shade(1.0)}">'
            f"<title>{escape(told)}</title></rect>"
        )
    ends = ((across[0], across[-1]), (0.0, 1.0))
    return _framed(body, (name, "share that holds"), ends, centred=(wide / 2, 0))


def dots(x: FloatArray, y: FloatArray, holds: FloatArray, names: tuple[str, str]) -> str:
    """A point for each run, green where all holds; a line at nothing, where margins end."""
    kept = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    kept = kept[:: max(len(kept) // MOST_DOTS, 1)]
    if not len(kept):
        return ""
    low, high = float(min(y[kept].min(), 0.0)), float(max(y[kept].max(), 0.0))
    ends = (_widened(float(x[kept].min()), float(x[kept].max())), _widened(low, high))
    body = [_line(_at(0.0, ends[1], up=True))]
    for index in kept:
        across, up = _at(float(x[index]), ends[0]), _at(float(y[index]), ends[1], up=True)
        body.append(
            f'<circle cx="{across:.1f}" cy="{up:.1f}" r="3" fill="{_shade(float(holds[index]))}"/>'
        )
    return _framed(body, names, ends)


def _cells(values: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
    """The values of a grid, or the middles of ranges, and in which of them each value lies."""
    known, places = np.unique(values, return_inverse=True)
    if len(known) <= 2 * BINS:
        return known, places
    edges = np.linspace(known[0], known[-1], BINS + 1)
    places = np.clip(np.digitize(values, edges) - 1, 0, BINS - 1).astype(np.intp)
    return (edges[1:] + edges[:-1]) / 2, places


def _plot_size() -> tuple[float, float]:
    return WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM


def _widened(low: float, high: float) -> tuple[float, float]:
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _at(value: float, ends: tuple[float, float], *, up: bool = False) -> float:
    wide, high = _plot_size()
    share = (value - ends[0]) / (ends[1] - ends[0])
    return TOP + (1 - share) * high if up else LEFT + share * wide


def _line(y: float) -> str:
    return f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" class="axis"/>'


def _shade(share: float) -> str:
    """From orange to green by way of grey, told apart by who does not see red and green."""
    ends = np.array([[214, 96, 32], [200, 200, 200], [24, 128, 112]], float)
    colour = [np.interp(share, (0, 0.5, 1), ends[:, channel]) for channel in range(3)]
    return "#" + "".join(f"{round(part):02x}" for part in colour)


def _framed(
    body: Sequence[str],
    names: tuple[str, str],
    ends: tuple[tuple[float, float], tuple[float, float]],
    centred: tuple[float, float] = (0.0, 0.0),
) -> str:
    """The plot with its axes. centred: how far inside the ends are written, px."""
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    words = [
        (LEFT + centred[0], bottom + 16, "middle", f"{ends[0][0]:.4g}"),
        (right - centred[0], bottom + 16, "middle", f"{ends[0][1]:.4g}"),
        (LEFT - 6, bottom + 4 - centred[1], "end", f"{ends[1][0]:.4g}"),
        (LEFT - 6, TOP + 4 + centred[1], "end", f"{ends[1][1]:.4g}"),
        ((LEFT + right) / 2, HEIGHT - 8, "middle", names[0]),
    ]
    told = [
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'
        for x, y, anchor, text in words
    ]
    frame = f'<path d="M{LEFT} {TOP}V{bottom}H{right}" class="axis"/>'
    picture = f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img">'
    return (
        f"<figure><figcaption>{escape(names[1])}</figcaption>{picture}{''.join(body)}{frame}"
        f"{''.join(told)}</svg></figure>"
    )
