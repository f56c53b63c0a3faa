"""Which way along the ground leaves the other things alone, in closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene.measures import FloatArray, Layout, level, unit


@dataclass(frozen=True, slots=True)
class PathSettings:
    """Which arcs lead around what stands in the way."""

    # 10..180: of a curved path to its target, the flattest first
    turns_deg: tuple[float, ...] = (24.0, 36.0, 48.0, 60.0, 75.0, 90.0, 110.0, 130.0, 150.0, 170.0)


PATH = PathSettings()


def free_turn(
    layout: Layout, name: str, goal: FloatArray, sign: float, spared: Sequence[str]
) -> float:
    """The least turn, degrees, of an arc to `goal` that keeps clear of `spared`.

    sign: +1 bends to the left, so the arc lies to the right of the straight line. The widest
    clearance where none is free.
    """
    needed = 0.02 + 0.1 * layout.size(name)
    gaps = {turn: clearance(layout, name, goal, sign * turn, spared) for turn in PATH.turns_deg}
    free = [turn for turn, gap in gaps.items() if gap >= needed]
    return free[0] if free else max(gaps, key=lambda turn: (gaps[turn], -turn))


def clearance(
    layout: Layout, name: str, goal: FloatArray, turn: float, spared: Sequence[str]
) -> float:
    """Least horizontal gap to `spared` on an arc to `goal` that turns by `turn` degrees, m.

    Negative where they overlap; inf without anything to spare.
    """
    start = layout.position(name)
    points = _arc(start, goal, turn)
    gaps = [math.inf]
    for other in spared:
        if layout.placed(other) is None or other == name:
            continue
        away = np.linalg.norm(points[:, :2] - layout.position(other)[:2], axis=1)
        gaps.append(float(away.min()) - reach(layout, name) - reach(layout, other))
    return min(gaps)


def arc_length(distance: float, turn: float) -> float:
    """Length of an arc over a chord of that length, m."""
    half = math.radians(abs(turn)) / 2
    return distance * half / math.sin(half) if 1e-3 < half < math.pi - 1e-3 else distance


def reach(layout: Layout, name: str) -> float:
    """Half of the widest level extent, m."""
    ways = [np.array([math.cos(a), math.sin(a), 0.0]) for a in np.linspace(0, np.pi, 4)]
    return max(layout.extent(name, way) for way in ways)


def _arc(start: FloatArray, goal: FloatArray, turn: float) -> FloatArray:
    """(40, 3) points of the arc; a positive turn bends to the left."""
    count = 40
    chord = level(goal - start)
    length, ahead = float(np.linalg.norm(chord)), unit(chord)
    left = np.array([-ahead[1], ahead[0], 0.0])
    half = math.radians(abs(turn)) / 2
    if half < 1e-3:
        return start + np.linspace(0, 1, count)[:, None] * chord
    radius = length / (2 * math.sin(half))
    angles = np.linspace(-half, half, count)
    along = radius * np.sin(angles) + length / 2
    aside = radius * (np.cos(angles) - math.cos(half)) * -math.copysign(1.0, turn)
    return start + along[:, None] * ahead + aside[:, None] * left
