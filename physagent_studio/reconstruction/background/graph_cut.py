"""Which copy fills which part of a hole: few large pieces whose seams are not seen.

Every copy is a map of the picture onto itself; a copy is chosen for each missing place such that
it agrees with the photo at the rim and with its neighbours at every seam. Found by expansion
moves, each an exact minimum cut (Boykov et al. 2001), as in shift-map editing (Pritch et al. 2009).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from physagent_studio.arrays import BoolArray, FloatArray, FloatImage


@dataclass(frozen=True, slots=True)
class CutSettings:
    """What a minimum cut counts in."""

    never_levels: float = 4000.0  # 2000..20000: price of a place that a copy does not reach


CUT = CutSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """The places to fill: their indices (H, W), -1 elsewhere, and pairs of neighbours (E, 2)."""

    index: NDArray[np.int64]
    pairs: NDArray[np.int64]

    @classmethod
    def of(cls, places: BoolArray) -> Grid:
        index = np.full(places.shape, -1)
        index[places] = np.arange(int(places.sum()))
        beside = [
            np.stack([a[both], b[both]], 1)
            for a, b in ((index[:, :-1], index[:, 1:]), (index[:-1], index[1:]))
            for both in [(a >= 0) & (b >= 0)]
        ]
        return cls(index, np.concatenate(beside))


def choose(grid: Grid, looks: FloatImage, prices: FloatImage, sweeps: int = 2) -> NDArray[np.int64]:
    """(N,) the copy that fills each of N places.

    looks: (K, N, C) what each copy shows there, in grey levels. prices: (K, N) what it costs to
    take it there, grey levels.
    """
    order = np.argsort(prices.sum(1), kind="stable")
    chosen = np.full(prices.shape[1], order[0])
    for sweep in range(sweeps):
        before = chosen.copy()
        tried = order if sweep == 0 else [k for k in order if (before == k).any()]
        for label in tried:
            chosen = _expanded(grid, looks, prices, chosen, int(label))
        if np.array_equal(before, chosen):
            break
    return chosen


def _expanded(
    grid: Grid, looks: FloatImage, prices: FloatImage, chosen: NDArray[np.int64], label: int
) -> NDArray[np.int64]:
    """The best choice in which every place keeps its copy or takes this one."""
    # Only where it can be taken at all: elsewhere every place keeps what it has.
    able = np.flatnonzero((prices[label] < CUT.never_levels) & (chosen != label))
    if not len(able):
        return chosen
    local = np.full(len(chosen), -1)
    local[able] = np.arange(len(able))
    p, q = grid.pairs[:, 0], grid.pairs[:, 1]
    near = (local[p] >= 0) | (local[q] >= 0)
    p, q = p[near], q[near]
    first, second = chosen[p], chosen[q]
    kept = _apart(looks, first, second, p, q)
    one = _apart(looks, first, label, p, q)
    other = _apart(looks, label, second, p, q)
    change = (prices[label, able] - prices[chosen[able], able]).astype(np.float64)
    p, q = local[p], local[q]
    change += np.bincount(p[p >= 0], (other - kept)[p >= 0], len(able))
    both = (p >= 0) & (q >= 0)
    change -= np.bincount(q[both], other[both], len(able))
    alone = (p < 0) & (q >= 0)
    change += np.bincount(q[alone], (one - kept)[alone], len(able))
    between = np.maximum(one + other - kept, 0)[both]
    taken = _cut(change, p[both], q[both], between)
    out = chosen.copy()
    out[able[taken]] = label
    return out


def _apart(
    looks: FloatImage,
    one: NDArray[np.int64] | int,
    other: NDArray[np.int64] | int,
    p: NDArray[np.int64],
    q: NDArray[np.int64],
) -> FloatArray:
    """(E,) how visible the seam is between two copies that meet at places p and q."""
    at_p = np.abs(looks[one, p] - looks[other, p]).sum(-1)
    at_q = np.abs(looks[one, q] - looks[other, q]).sum(-1)
    return (at_p + at_q).astype(np.float64)


def _cut(
    change: FloatArray, p: NDArray[np.int64], q: NDArray[np.int64], between: FloatArray
) -> BoolArray:
    """(N,) which places change, at least cost: `change` each, `between` where p stays and q not."""
    count = len(change)
    source, sink = count, count + 1
    places = np.arange(count)
    rows = np.concatenate([p, q, np.full(count, source), places])
    columns = np.concatenate([q, p, places, np.full(count, sink)])
    nothing = np.zeros(len(p))
    values = np.concatenate([between, nothing, np.maximum(change, 0), np.maximum(-change, 0)])
    units_ratio = 8.0  # 1..32: capacities are whole numbers: so many to a grey level
    whole = np.minimum(np.round(values * units_ratio), 2**28).astype(np.int32)
    graph = sparse.csr_matrix((whole, (rows, columns)), (count + 2, count + 2))
    left = graph - maximum_flow(graph, source, sink).flow
    left.data = np.maximum(left.data, 0)
    left.eliminate_zeros()
    stays = breadth_first_order(left, source, return_predecessors=False)
    out = np.ones(count + 2, bool)
    out[stays] = False
    return out[:count]
