"""Edges that run into what is taken out of a picture and meet behind it, in a corner or a bow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.lines import Segments
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
JOINED = 0.02
"""Gap between two edges of one round outline, as a share of the picture's longer side."""
BENT = (math.radians(3.0), math.radians(50.0))
"""By how much an outline that is round turns from one edge to the next."""
PIECES = 8
"""Lines along a bow."""
MOST = 8
"""Edges beyond which they are a pattern and not outlines."""
INSIDE = 0.75
"""Share of the way from an edge's end to the corner that is hidden, at least."""


def corners(
    ends: FloatArray,
    ways: FloatArray,
    colours: FloatArray,
    free: Sequence[int],
    hole: BoolArray,
    found: Segments,
) -> FloatArray:
    """Lines (N, 2, 2), pixels, from where edges end to where they meet.

    Two for each corner; several along a bow where both edges are part of a round outline, for
    the edges before them bend the same way. ends, ways: (E, 2) where edges run into the hole
    (H, W) and the unit directions in which they do. colours: (E, 2, 3) to the left and the right
    of each. free: those that may meet. found: the picture's edges.
    """
    longer = max(hole.shape)
    free = [k for k in free if not _goes_on(ends[k], ways[k], found, longer)]
    if not 2 <= len(free) <= MOST:
        return np.zeros((0, 2, 2))
    rows, columns = np.nonzero(hole)
    reach = FAR * max(np.ptp(rows), np.ptp(columns), 1) if len(rows) else 0.0
    clear = np.abs(colours[:, 0] - colours[:, 1]).mean(-1)
    meetings = []
    for i in free:
        for j in (j for j in free if j > i and min(clear[i], clear[j]) > CLEAR):
            met = _meeting(ends[i], ways[i], ends[j], ways[j])
            if met is None or max(met[1:]) > reach:
                continue
            # Seen from the corner the left of one edge is the right of the other.
            apart = float(np.abs(colours[i] - colours[j, ::-1]).mean(-1).max())
            if apart < ALIKE and all(_hidden(hole, ends[k], met[0]) for k in (i, j)):
                meetings.append((sum(met[1:]) / reach + apart / ALIKE, i, j, met[0]))
    used: set[int] = set()
    out = []
    for _, i, j, spot in sorted(meetings, key=lambda meeting: meeting[:3]):
        if i not in used and j not in used:
            used |= {i, j}
            turn = _turn(ways[i], -ways[j])
            before = [_turn_before(ends[k], ways[k], found, longer) for k in (i, j)]
            bow = before[0] * turn > 0 and before[1] * -turn > 0
            out += _bow(ends[i], spot, ends[j]) if bow else [(ends[i], spot), (spot, ends[j])]
    return np.array(out).reshape(-1, 2, 2)


def _turn(u: FloatArray, v: FloatArray) -> float:
    """The sine of the turn from one unit direction to another."""
    return float(u[0] * v[1] - u[1] * v[0])


def _turn_before(end: FloatArray, way: FloatArray, found: Segments, longer: int) -> float:
    """The turn into the edge that ends here from the one that leads to it; 0 for none."""
    own = np.argwhere((found.ends == end).all(2))[0]
    step = _joined(found.ends[own[0], 1 - own[1]], own[0], found, longer)
    if step is None:
        return 0.0
    turn = _turn(-step, way)
    bent = -step @ way > math.cos(BENT[1]) and abs(turn) > math.sin(BENT[0])
    return turn if bent else 0.0


def _goes_on(end: FloatArray, way: FloatArray, found: Segments, longer: int) -> bool:
    """Whether another edge goes on where this one ends: it is no end at all."""
    # From its end ahead, not beside it: edges of one bar run side by side.
    ahead = found.ends - end
    along = ahead @ way
    aside = np.abs(ahead[..., 0] * way[1] - ahead[..., 1] * way[0])
    begins = (along > 0.5) & (along < JOINED * longer) & (aside < 2 + 0.3 * along)
    for index, side in np.argwhere(begins):
        step = found.ends[index, 1 - side] - found.ends[index, side]
        if step @ way > math.cos(BENT[1]) * float(np.linalg.norm(step)):
            return True
    return False


def _joined(spot: FloatArray, own: int, found: Segments, longer: int) -> FloatArray | None:
    """The unit direction away from a spot of the edge that begins there, None for none."""
    away = np.linalg.norm(found.ends - spot, axis=2)
    away[own] = np.inf
    index, side = np.unravel_index(int(away.argmin()), away.shape)
    if away[index, side] > JOINED * longer:
        return None
    step = found.ends[index, 1 - side] - found.ends[index, side]
    return step / max(float(np.linalg.norm(step)), 1e-9)


def _bow(
    one: FloatArray, spot: FloatArray, other: FloatArray
) -> list[tuple[FloatArray, FloatArray]]:
    """Pieces of the parabola that touches both ways to the spot where they would meet."""
    share = np.linspace(0, 1, PIECES + 1)[:, None]
    along = (1 - share) ** 2 * one + 2 * share * (1 - share) * spot + share**2 * other
    return list(pairwise(along))


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
