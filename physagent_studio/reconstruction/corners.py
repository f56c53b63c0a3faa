"""Edges that run into what is taken out of a picture and meet behind it in a corner."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import BoolArray

FloatArray = NDArray[np.float64]
STRAIGHT = math.radians(8.0)
"""Edges that bend less than this where they meet are one straight line, and no corner."""
FAR = 1.6
"""How far an edge may run to its corner, in extents of the hole."""
ALIKE = 32.0
"""Largest difference in colour between the two sides of a corner, grey levels."""
CLEAR = 10.0
"""Least difference in colour across an edge that is followed, grey levels."""
MOST = 14
"""Edges beyond which they are a pattern and not outlines."""
INSIDE = 0.75
"""Share of the way from an edge's end to the corner that is hidden, at least."""


def corners(
    ends: FloatArray, ways: FloatArray, colours: FloatArray, free: Sequence[int], hole: BoolArray
) -> FloatArray:
    """Lines (N, 2, 2), pixels, two for each corner, from where edges end to where they meet.

    ends, ways: (E, 2) where edges run into the hole (H, W) and the unit directions in which they
    do. colours: (E, 2, 3) to the left and the right of each. free: those that may end in a corner.
    """
    if not 2 <= len(free) <= MOST:
        return np.zeros((0, 2, 2))
    rows, columns = np.nonzero(hole)
    reach = FAR * max(np.ptp(rows), np.ptp(columns), 1) if len(rows) else 0.0
    clear = np.abs(colours[:, 0] - colours[:, 1]).mean(-1)
    meetings = []
    for i in free:
        for j in (j for j in free if j > i and min(clear[i], clear[j]) > CLEAR):
            found = _meeting(ends[i], ways[i], ends[j], ways[j])
            if found is None or max(found[1:]) > reach:
                continue
            # Seen from the corner the left of one edge is the right of the other.
            apart = float(np.abs(colours[i] - colours[j, ::-1]).mean(-1).max())
            if apart < ALIKE and all(_hidden(hole, ends[k], found[0]) for k in (i, j)):
                meetings.append((sum(found[1:]) / reach + apart / ALIKE, i, j, found[0]))
    used: set[int] = set()
    out = []
    for _, i, j, spot in sorted(meetings, key=lambda meeting: meeting[:3]):
        if i not in used and j not in used:
            used |= {i, j}
            out += [(ends[i], spot), (spot, ends[j])]
    return np.array(out).reshape(-1, 2, 2)


def _meeting(
    p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray
) -> tuple[FloatArray, float, float] | None:
    """Where two rays meet, and how far along each; None where they run beside or away."""
    turn = float(u[0] * v[1] - u[1] * v[0])
    if abs(turn) < math.sin(STRAIGHT):
        return None
    gap = q - p
    first = float(gap[0] * v[1] - gap[1] * v[0]) / turn
    second = float(gap[0] * u[1] - gap[1] * u[0]) / turn
    return (p + first * u, first, second) if min(first, second) > 3 else None


def _hidden(hole: BoolArray, end: FloatArray, spot: FloatArray) -> bool:
    """Whether the way to the corner, and the corner, lie in the hole."""
    x, y = (end + np.linspace(0, 1, 30)[:, None] * (spot - end)).astype(int).T
    inside = (x >= 0) & (y >= 0) & (x < hole.shape[1]) & (y < hole.shape[0])
    x, y = x.clip(0, hole.shape[1] - 1), y.clip(0, hole.shape[0] - 1)
    covered = hole[y, x] & inside
    return bool(covered[-1] and covered.mean() > INSIDE)
