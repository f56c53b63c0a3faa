"""How deep two bodies overlap, and the shortest way out."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.shapes import Placed, gap, stretched

_TINY = 1e-12


def overlap(first: Placed, second: Placed) -> float:
    """How deep two bodies overlap at their first pose, m; 0 where they do not, bounded above."""
    return float(np.linalg.norm(way_out(first, second)))


def way_out(first: Placed, second: Placed, upward: bool = False) -> FloatArray:
    """(3,) the shortest shift of the first body that frees it from the second, m; 0 if it is free.

    The best over the directions of both bodies' axes, the line between their centres and a
    sphere of further directions. upward: only shifts that do not go down.
    """
    if first.half_space is not None:
        return -way_out(second, first) if second.half_space is None else np.zeros(3)
    if second.half_space is not None:
        return max(0.0, -float(gap(first, second)[0])) * second.half_space.normal
    one, two = first.at(slice(0, 1)), second.at(slice(0, 1))
    if float(gap(one, two)[0]) > 1e-6:
        return np.zeros(3)
    between = two.positions - one.positions
    ways = np.concatenate([one.matrices[0].T, two.matrices[0].T, between, _sphere(96)])
    ways = np.concatenate([ways, -ways])
    lengths = np.linalg.norm(ways, axis=-1, keepdims=True)
    ways = (ways / np.maximum(lengths, _TINY))[lengths[:, 0] > _TINY]
    if upward:
        ways = ways[ways[:, 2] <= 1e-9]
    one, two = stretched(one, len(ways)), stretched(two, len(ways))
    depth = np.sum(one.support(ways) * ways, -1) - np.sum(two.support(-ways) * ways, -1)
    best = int(depth.argmin())
    return -max(0.0, float(depth[best])) * ways[best]


def _sphere(count: int) -> FloatArray:
    """(count, 3) directions spread evenly over a sphere (Fibonacci)."""
    index = np.arange(count) + 0.5
    z = 1 - 2 * index / count
    angle = np.pi * (1 + math.sqrt(5)) * index
    flat = np.sqrt(1 - z * z)
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), z], axis=-1)
