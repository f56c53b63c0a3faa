"""Which way a thing on wheels faces, as far as a scene says: its longer side, a likely front."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene.measures import FloatArray, Layout
from physagent_studio.knowledge import kind_of


@dataclass(frozen=True, slots=True)
class FacingSettings:
    """What shows which way a thing lies, and which of its ends is taken for the front."""

    min_long_ratio: float = 1.3  # 1.1..2: length over width of what shows which way it lies
    # cosine, 0.1..0.7: of its axis and the line of sight, from which one end is the nearer one
    min_near_cosine: float = math.cos(math.radians(67.5))


FACING = FacingSettings()


def long_axis(layout: Layout, name: str) -> tuple[FloatArray, bool]:
    """Level unit axis (3,) of the longer side of its outline, and whether it clearly is longer."""
    ways = [
        np.array([math.cos(angle), math.sin(angle), 0.0])
        for angle in np.radians(np.arange(0.0, 180.0, 1.0))
    ]
    wide = np.array([layout.extent(name, way) + layout.extent(name, -way) for way in ways])
    across = np.roll(wide, -90)
    # The smallest upright box around it, from above, lies as it does.
    best = int(np.argmin(wide * across))
    if wide[best] < across[best]:
        best = (best + 90) % 180
    shown = bool(wide[best] > FACING.min_long_ratio * across[best])
    item = layout.state.object(name)
    if item is not None and item.shape is not None and item.shape.kind == "inflated":
        # Its depth is a guess: as wide as high it may as well be seen from behind.
        shown = shown and bool(wide[best] > FACING.min_long_ratio * layout.height(name))
    return ways[best], shown


def likely_front(layout: Layout, name: str) -> FloatArray | None:
    """Level unit direction (3,) in which a thing on wheels is likely to face: as its wheels have it
    already, else as photographs are taken, from before it or with more room before it than behind
    it. None for what has no front."""
    item, kind = layout.state.object(name), kind_of(name)
    if kind is not None and kind.wheels == "any_way":
        return None
    if item is not None and item.wheels is not None:
        angle = math.radians(item.wheels.heading)
        return np.array([math.cos(angle), math.sin(angle), 0.0])
    if kind is None or kind.wheels is None or not layout.has(name):
        return None
    axis, shown = long_axis(layout, name)
    if kind.wheels == "short_axis":
        axis = np.array([-axis[1], axis[0], 0.0])
    if not shown:
        return np.array([0.0, -1.0, 0.0])
    if abs(axis[1]) > FACING.min_near_cosine:
        return axis if axis[1] < 0 else -axis
    return -axis if axis[0] * layout.position(name)[0] > 0 else axis
