"""What divides a hole of a picture: lines that are known to go on behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds

NO_LINES: FloatArray = np.zeros((0, 2, 2))


@dataclass(frozen=True, eq=False, slots=True)
class Structure:
    """lines: (N, 2, 2) pixels, edges over which no colour runs."""

    lines: FloatArray

    def scaled(self, ratio: FloatArray) -> Self:
        """The same in a picture `ratio` (2,) times as wide and high."""
        return type(self)(self.lines * ratio)

    def moved(self, x: float, y: float) -> Self:
        """The same in a part of the picture whose corner is at (x, y)."""
        return type(self)(self.lines - np.array([x, y]))

    def clear(self, missing: BoolArray) -> Self:
        """With the longest of the lines alone.

        missing: (h, w) the hole.
        """
        x0, y0, x1, y1 = bounds(missing)
        min_length_share = 0.2  # 0.05..0.5: of the hole's extent, for a line to be kept sharp
        least = min_length_share * max(x1 - x0, y1 - y0)
        max_lines = 8  # count, 1..20: that are kept, the longest
        chains = self.chains()
        kept = [c for c in chains if np.linalg.norm(c[:, 1] - c[:, 0], axis=1).sum() > least]
        return type(self)(np.concatenate([NO_LINES, *kept[:max_lines]]))

    def chains(self) -> list[FloatArray]:
        """The lines (n, 2, 2) apart, but for those that begin where the one before ends."""
        out: list[list[FloatArray]] = []
        # 1e-4..0.5: from the end of a line to the beginning of one that leads on from it
        joined_px = 1e-3
        for line in self.lines:
            if (
                out
                and np.abs(out[-1][-1][1] - line[0]).max() < joined_px
                and _bulges(out[-1], line)
            ):
                out[-1].append(line)
            else:
                out.append([line])
        return [np.array(one) for one in out]

    @property
    def empty(self) -> bool:
        """Whether nothing divides the hole."""
        return not len(self.lines)

    def sides(self, shape: tuple[int, ...]) -> NDArray[np.int64]:
        """(H, W) a number that tells on which side of every line a pixel lies.

        Lines that lead on from one another have two sides together: within their bend and without.
        """
        y, x = np.indices(shape) + 0.5
        out = np.zeros(shape, np.int64)
        chains = self.chains()
        for k, chain in enumerate(chains):
            # On which side of its lines lies what is within their bend.
            sign = 1.0 if _turns(chain).sum() <= 0 else -1.0
            within = np.ones(shape, bool)
            for one, other in chain:
                way = other - one
                within &= sign * ((x - one[0]) * way[1] - (y - one[1]) * way[0]) > 0
            out |= within.astype(np.int64) << k
        return out

    def crossed(self, shape: tuple[int, ...]) -> tuple[BoolArray, BoolArray]:
        """Which steps (H, W) to the right, and below, lead from one side to the other."""
        right, below = np.zeros(shape, bool), np.zeros(shape, bool)
        rows, columns = np.indices(shape).astype(float)
        spots = np.stack([columns + 0.5, rows + 0.5], -1)
        for one, other in self.lines:
            length = max(float(np.linalg.norm(other - one)), 1e-9)
            way = (other - one) / length
            off = (spots - one) @ np.array([-way[1], way[0]])
            along = (spots - one) @ way
            inside = (along > -2) & (along < length + 2)
            for axis, over in ((1, right), (0, below)):
                ahead = np.roll(off, -1, axis)
                over |= (off * ahead <= 0) & inside & (np.abs(off - ahead) < 2)
        return right, below


def _bulges(chain: Sequence[FloatArray], line: FloatArray) -> bool:
    """Whether lines that lead on from one another still bend one way with this one."""
    turns = _turns(np.array([*chain, line]))
    return bool((turns >= 0).all() or (turns <= 0).all())


def _turns(chain: FloatArray) -> FloatArray:
    ways = chain[:, 1] - chain[:, 0]
    return ways[:-1, 0] * ways[1:, 1] - ways[:-1, 1] * ways[1:, 0]
