"""A measured value with its bound, and how memory is read."""

from __future__ import annotations

import resource
import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Figure:
    """A measured value with the bound that it has to keep: below it, or (`above`) not below."""

    name: str
    value: float
    unit: str
    bound: float
    above: bool = False

    @property
    def ok(self) -> bool:
        """Whether the bound is kept."""
        return self.value >= self.bound if self.above else self.value <= self.bound


def p95(seconds: Sequence[float]) -> float:
    """The 95th percentile, ms."""
    return statistics.quantiles(seconds, n=20)[-1] * 1000


def memory() -> float:
    """Memory in use by this process, MB; its peak where the system tells nothing else."""
    status = Path("/proc/self/statm")
    if status.exists():
        return int(status.read_text().split()[1]) * resource.getpagesize() / 2**20
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)
