"""A box is tight: what it holds reaches all four of its sides, so a mask is led there.

From a mask that stops short of a side, the cheapest way to that side through pixels that look
like the object becomes part of it, and a graph cut settles what else belongs (after the tightness
prior of Lempitsky et al. 2009, with shortest paths in place of its relaxed program). Necks, legs
and poles come in this way.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra

from physagent_studio.reconstruction.masks import grabcut
from physagent_studio.reconstruction.masks.task import Task
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, shrink

SHORT = 0.06
"""Gap to a side, as a share of the box, that a box drawn a little wide leaves."""
_STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))

Box = tuple[float, float, float, float]


def reaching(
    small: NDArray[np.uint8], lab: NDArray[np.float32], mask: BoolArray, box: Box, task: Task
) -> BoolArray | None:
    """The mask led to the sides of its box that it does not reach; None if it reaches all."""
    sides = _missed(mask, box)
    x0, y0, x1, y1 = _pixels(box, mask.shape)
    if not sides or x1 - x0 < 8 or y1 - y0 < 8 or not mask.any():
        return None
    within = np.zeros_like(mask)
    within[y0:y1, x0:x1] = True
    around = grow(within, max(4, (x1 - x0 + y1 - y0) // 12)) & ~within
    if np.count_nonzero(around) < 30:
        return None
    ratio = grabcut.likelihood_ratio(lab, mask, around)
    crop = (slice(y0, y1), slice(x0, x1))
    cost = 0.08 + np.log1p(np.exp(-np.clip(ratio[crop], -12, 12)))
    for x, y in task.outside:
        barred = np.zeros(mask.shape, np.uint8)
        cv2.circle(barred, (int(x), int(y)), 3, 1, -1)
        cost[barred[crop] > 0] = 50.0
    ways = np.zeros_like(mask)
    ways[crop] = _ways(cost, mask[crop], sides)
    return _settled(small, mask, ways, within, task)


def _missed(mask: BoolArray, box: Box) -> list[str]:
    """The sides that a mask stops short of."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = max(box[2] - box[0], 1.0), max(box[3] - box[1], 1.0)
    gaps = {
        "left": (x0 - box[0]) / width,
        "right": (box[2] - x1) / width,
        "top": (y0 - box[1]) / height,
        "bottom": (box[3] - y1) / height,
    }
    return [side for side, gap in gaps.items() if gap > SHORT]


def _pixels(box: Box, shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    rows, columns = shape[:2]
    x0, y0 = max(0, int(box[0])), max(0, int(box[1]))
    return x0, y0, min(columns, int(np.ceil(box[2])) + 1), min(rows, int(np.ceil(box[3])) + 1)


def _ways(cost: NDArray[np.float64], mask: BoolArray, sides: list[str]) -> BoolArray:
    """Pixels of the cheapest ways from the mask to each side."""
    rows, columns = cost.shape
    graph = _graph(cost)
    start = np.flatnonzero(mask & ~shrink(mask, 1))
    far, before, _ = dijkstra(graph, indices=start, min_only=True, return_predecessors=True)
    index = np.arange(rows * columns).reshape(rows, columns)
    wide, high = max(2, round(SHORT * columns)), max(2, round(SHORT * rows))
    strips = {
        "left": index[:, :wide],
        "right": index[:, -wide:],
        "top": index[:high],
        "bottom": index[-high:],
    }
    out = np.zeros(rows * columns, bool)
    for side in sides:
        goals = strips[side].ravel()
        node = int(goals[far[goals].argmin()])
        while node >= 0 and not out[node]:
            out[node] = True
            node = int(before[node])
    return out.reshape(rows, columns)


def _graph(cost: NDArray[np.float64]) -> csr_matrix:
    """The grid with eight neighbours; a step costs the mean of its ends times its length."""
    rows, columns = cost.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    heads, tails, weights = [], [], []
    for down, right in _STEPS:
        low, high = max(0, -right), columns - max(0, right)
        a = index[: rows - down, low:high]
        b = index[down:, low + right : high + right]
        weight = 0.5 * (cost.ravel()[a] + cost.ravel()[b]) * np.hypot(down, right)
        heads += [a.ravel(), b.ravel()]
        tails += [b.ravel(), a.ravel()]
        weights += [weight.ravel(), weight.ravel()]
    size = (rows * columns, rows * columns)
    data = np.concatenate(weights), (np.concatenate(heads), np.concatenate(tails))
    return csr_matrix(coo_matrix(data, shape=size))


def _settled(
    small: NDArray[np.uint8], mask: BoolArray, ways: BoolArray, within: BoolArray, task: Task
) -> BoolArray | None:
    trimap = np.where(within, cv2.GC_PR_BGD, cv2.GC_BGD).astype(np.uint8)
    trimap[mask | grow(ways, 2)] = cv2.GC_PR_FGD
    trimap[shrink(mask, 3) | ways] = cv2.GC_FGD
    for x, y in task.outside:
        cv2.circle(trimap, (int(x), int(y)), 3, cv2.GC_BGD, -1)
    trimap[~within] = cv2.GC_BGD
    rows, columns = np.flatnonzero(within.any(1)), np.flatnonzero(within.any(0))
    pad = 8 + (len(rows) + len(columns)) // 8
    crop = (
        slice(max(0, rows[0] - pad), rows[-1] + pad),
        slice(max(0, columns[0] - pad), columns[-1] + pad),
    )
    part = grabcut.cut(
        np.ascontiguousarray(small[crop]), np.ascontiguousarray(trimap[crop]), rounds=2
    )
    if part is None:
        return None
    out = np.zeros_like(mask)
    out[crop] = part
    return out
