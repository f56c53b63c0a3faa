"""Bent lines that run through a stack from side to side: where one thing ends on another.

Along a slope the picture is sheared, so that what all lines of that slope cost is one running sum
over its rows; the best line to the left and the best to the right of a pixel make a bent line.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray, IntArray
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, shrink
from physagent_studio.reconstruction.switches import at_work


@dataclass(frozen=True, slots=True)
class SeamSettings:
    """What a seam may look like."""

    max_seams_count: int = 11  # 4..20: weighed against one another: all choices of some are tried
    min_apart_share: float = 0.045  # 0.01..0.1: of the stack's height: thinner than any layer
    max_slope_ratio: float = 0.9  # 0.3..2: rise over run of a seam's straight parts
    slopes_count: int = 25  # 9..60: that are tried
    end_cost: float = 0.15  # cost, 0..0.5: of an end where the outline is straight, or a corner
    noise_lab: float = 2.0  # 0..5: steps of no edge
    faint_lab: float = 6.0  # 2..15: steps of an edge where nothing else is near


SEAM = SeamSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Seam:
    """A bent line from side to side: its row in each column, and how unlike a seam it is, 0 … 1."""

    rows: FloatArray
    cost: float


def seams_of(lab: NDArray[np.float32], stack: BoolArray) -> list[Seam]:
    """Different bent lines through the stack from side to side, the likeliest first."""
    x0, y0, x1, y1 = bounds(stack)
    inner = shrink(stack, max(2, (y1 - y0) // 60))
    costs = [_edges(lab, slope) for slope in (-0.5, 0.0, 0.5)]
    rims = _rims(stack)
    columns = np.arange(x0 + 2, x1 - 2, 3)
    rows = np.arange(y0 + 2, y1 - 2)
    sides = _sides(costs, rims, inner, rows, columns)
    (left, left_slope, left_n), (right, right_slope, right_n) = sides
    total = (left * left_n + right * right_n) / np.maximum(left_n + right_n, 1)
    wide = (left_n + right_n) / max(np.count_nonzero(inner.any(0)), 1)
    total += 0.8 * np.clip(0.85 - wide, 0, None)
    # Seen from above, the nearest corner is lowest: the lines fall towards it and rise again.
    total += 0.3 * np.clip(right_slope - left_slope - 0.1, 0, None)
    total = np.where(inner[np.ix_(rows, columns)], total, np.inf)
    return _different(total, rows, columns, left_slope, right_slope, (x0, x1), y1 - y0)


def _different(
    total: FloatArray,
    rows: IntArray,
    columns: IntArray,
    left: FloatArray,
    right: FloatArray,
    span: tuple[int, int],
    height: int,
) -> list[Seam]:
    """The lines of least cost through each pixel that lie apart from better ones."""
    reach = max(2.0, SEAM.min_apart_share * height)
    kept: list[Seam] = []
    across = np.arange(*span)
    for flat in np.argsort(total, axis=None, kind="stable")[:6000]:
        i, j = np.unravel_index(flat, total.shape)
        if not np.isfinite(total[i, j]) or len(kept) == SEAM.max_seams_count:
            break
        slope = np.where(across < columns[j], left[i, j], right[i, j])
        line = float(rows[i]) + slope * (across - columns[j]).astype(float)
        if all(np.abs(line - seam.rows).mean() >= reach for seam in kept):
            kept.append(Seam(line, float(total[i, j])))
    return kept


def _sides(
    costs: Sequence[NDArray[np.float32]],
    rims: NDArray[np.float32],
    inner: BoolArray,
    rows: IntArray,
    columns: IntArray,
) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """(cost, slope, length) of the best straight line from each pixel to the left and the right.

    Along a slope the picture is sheared, so that sums along its lines are sums along rows.
    """
    shape = (len(rows), len(columns))
    best = [(np.full(shape, np.inf), np.zeros(shape), np.zeros(shape)) for _ in range(2)]
    height, width = inner.shape
    x = np.arange(width)
    for slope in np.linspace(-SEAM.max_slope_ratio, SEAM.max_slope_ratio, SEAM.slopes_count):
        shift = np.rint(slope * x).astype(int)
        start = np.arange(-int(shift.max(initial=0)), height - int(shift.min(initial=0)))
        y = start[:, None] + shift[None]
        valid = (y >= 0) & (y < height)
        y = np.clip(y, 0, height - 1)
        held = inner[y, x[None]] & valid
        cost = costs[int(np.clip(round(slope * 1.6), -1, 1)) + 1]
        values = np.where(held, cost[y, x[None]], 0.0)
        rim = np.where(valid, rims[y, x[None]], -0.5)
        at = (rows[:, None] - shift[columns][None] - start[0], columns[None])
        for side in (0, 1):
            mean, count = _along(values, held, rim, reverse=side == 1)
            mean, count = mean[at], count[at]
            better = mean < best[side][0]
            best[side][0][better], best[side][1][better] = mean[better], slope
            best[side][2][better] = count[better]
    return best


def _along(
    values: NDArray, held: BoolArray, rim: NDArray[np.float32], reverse: bool
) -> tuple[FloatArray, IntArray]:
    """Mean cost and length of the line from the left (or right) end of each row to each pixel."""
    if reverse:
        values, held, rim = values[:, ::-1], held[:, ::-1], rim[:, ::-1]
    count = np.cumsum(held, axis=1).astype(np.int64)
    first = held.argmax(1)
    mean = np.cumsum(values, axis=1) / np.maximum(count, 1)
    index = np.arange(held.shape[1])[None]
    mean += 0.5 * (1 - count / np.maximum(index - first[:, None] + 1, 1)).clip(0, 1)
    ends = np.clip(first[:, None] - np.arange(1, 9)[None], 0, None)
    step = np.take_along_axis(rim, ends, axis=1).max(1)
    mean += (SEAM.end_cost * np.clip(0.08 - step, 0, 0.2) / 0.2)[:, None]
    mean[count == 0] = 0.0
    return (mean[:, ::-1], count[:, ::-1]) if reverse else (mean, count)


def _edges(lab: NDArray[np.float32], slope: float) -> NDArray[np.float32]:
    """(H, W) 0 … 1: 0 where colours part across lines of a slope, or where a thin line is dark."""
    across = np.array([-slope, 1.0]) / np.hypot(slope, 1.0)

    def moved(by: float) -> NDArray[np.float32]:
        matrix = np.array([[1, 0, -by * across[0]], [0, 1, -by * across[1]]], np.float32)
        size = (lab.shape[1], lab.shape[0])
        out = cv2.warpAffine(lab, matrix, size, borderMode=cv2.BORDER_REPLICATE)
        return out.astype(np.float32)

    step = np.linalg.norm(moved(1.0) + moved(2.0) - moved(-1.0) - moved(-2.0), axis=2) / 2
    darker = np.minimum(moved(2.5)[..., 0], moved(-2.5)[..., 0]) - lab[..., 0]
    strong = np.maximum(step, 1.5 * np.clip(darker, 0, None)).astype(np.float32)
    # In the dark a small step is an edge where nothing near is a larger one.
    around = cv2.dilate(strong, np.ones((15, 15), np.uint8))
    clear = np.clip(strong - SEAM.noise_lab, 0, None) / (SEAM.faint_lab + 0.5 * np.asarray(around))
    return np.exp(-2.0 * clear).astype(np.float32)


def settled(seam: Seam, lab: NDArray[np.float32], stack: BoolArray) -> Seam:
    """The seam moved by a few pixels to where it is seen best, column by column."""
    if not at_work("settled seams"):
        return seam
    x0, y0, x1, y1 = bounds(stack)
    reach = max(2, round(0.4 * SEAM.min_apart_share * (y1 - y0)))
    offsets = np.arange(-reach, reach + 1)
    at = np.rint(seam.rows[None] + offsets[:, None]).astype(int)
    cost = _edges(lab, 0.0)[np.clip(at, 0, len(lab) - 1), np.arange(x0, x1)[None]].astype(float)
    cost += 0.15 * np.abs(offsets / reach)[:, None]
    total, source = cost.copy(), np.zeros(cost.shape, np.int64)
    for column in range(1, cost.shape[1]):
        before = np.pad(total[:, column - 1], 1, constant_values=np.inf)
        options = np.stack([before[:-2] + 0.1, before[1:-1], before[2:] + 0.1])
        choice = options.argmin(0)
        source[:, column] = np.arange(len(offsets)) + choice - 1
        total[:, column] += options.min(0)
    path = np.zeros(cost.shape[1], np.int64)
    path[-1] = int(total[:, -1].argmin())
    for column in range(cost.shape[1] - 1, 0, -1):
        path[column - 1] = source[path[column], column]
    return Seam(seam.rows + offsets[path], seam.cost)


def _rims(stack: BoolArray) -> NDArray[np.float32]:
    """At the outline: how much the stack surrounds it beyond a half; −0.5 elsewhere.

    Positive where the outline steps in, as it does between two things of other sizes.
    """
    _, y0, _, y1 = bounds(stack)
    size = 2 * max(4, (y1 - y0) // 16) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)).astype(np.float32)
    share = cv2.filter2D(stack.astype(np.float32), -1, disc / disc.sum()) - 0.5
    solid = stack.astype(np.uint8)
    near = cv2.dilate(solid, np.ones((5, 5), np.uint8)) != solid
    return np.where(near, share, -0.5).astype(np.float32)
