"""Lengths and percentiles of small arrays: the bits of NumPy's own without what these cost."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def lengths(vectors: NDArray[Any]) -> NDArray[Any]:
    """Lengths (…) of vectors (…, 2 or 3), as `np.linalg.norm` gives them over the last axis."""
    # A sum over an axis of three is ten times as dear as two sums.
    squares = vectors * vectors
    total = squares[..., 0] + squares[..., 1]
    for k in range(2, squares.shape[-1]):
        total += squares[..., k]
    return np.sqrt(total, out=total)


def median(ordered: NDArray[Any]) -> float:
    """The median of values (N,) in ascending order, as `np.median` gives it."""
    half, odd = divmod(len(ordered), 2)
    return float(ordered[half] if odd else (ordered[half - 1] + ordered[half]) / 2)


def percentile(ordered: NDArray[Any], percent: float) -> float:
    """A percentile of floats (N,) in ascending order, as `np.percentile` gives it."""
    at = (len(ordered) - 1) * (percent / 100)
    low = int(at)
    part = at - low
    one, other = ordered[low], ordered[min(low + 1, len(ordered) - 1)]
    step = other - one
    return float(one + step * part if part < 0.5 else other - step * (1 - part))
