"""On which sides a thing can lie, by its own form: a cone on its flank, a box on another face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene.measures import WAYS, Layout
from physagent_studio.arrays import FloatArray
from physagent_studio.knowledge import kind_of
from physagent_studio.program.scene.shapes import Outline


@dataclass(frozen=True, slots=True)
class SideSettings:
    """How sides are looked for, and how much of the way to one is lying on it."""

    step_deg: float = 3.0  # degrees, 1..6: from one lean that is looked at to the next
    least_deg: float = 30.0  # degrees, 20..40: less is leaning or standing on a rounded foot
    lying_share: float = 0.9  # ratio, 0.7..1: of a side's lean, from which a thing lies on it


SIDES = SideSettings()


def lying_from(layout: Layout, name: str, usual: float) -> float:
    """Tilt from which a thing has fallen over, degrees: the usual one, or less where it lies on
    another side of its own with less, as a spinning top does on its flank."""
    body = layout.placed(name)
    if body is None or body.outline is None or body.outline.is_ball:
        return usual
    nearest = _nearest_side(body.outline, body.matrices[0])
    return usual if nearest is None else min(usual, round(SIDES.lying_share * nearest, 1))


def stands_tall(layout: Layout, name: str) -> bool:
    """Whether a thing is higher than it is long, or has a back to lean on: what is not, as a dog or
    a car, is upside down when it lies on its back."""
    kind, ways = kind_of(name), (WAYS["right"], WAYS["away"])
    long = max((layout.extent(name, way) + layout.extent(name, -way) for way in ways), default=0.0)
    return (kind is not None and "back" in kind.parts) or layout.height(name) > long


def _nearest_side(outline: Outline, matrix: FloatArray) -> float | None:
    """Least lean at which it is at rest on another side than at first, degrees.

    A body rests where its centre is lower than at any lean close by.
    """
    leans = np.radians(np.arange(0.0, 180.0 + SIDES.step_deg / 2, SIDES.step_deg))
    ways = np.radians(np.arange(0.0, 360.0, 4 * SIDES.step_deg))
    across = np.stack([np.cos(ways), np.sin(ways)], axis=-1)
    # What points down once it leans so far that way, as it points at first: (ways, leans, 3).
    down = np.empty((len(ways), len(leans), 3))
    down[..., :2] = across[:, None] * np.sin(leans)[:, None]
    down[..., 2] = -np.cos(leans)
    own = down @ matrix
    heights = np.sum(outline.support(own.reshape(-1, 3)) * own.reshape(-1, 3), axis=-1)
    heights = heights.reshape(down.shape[:2])
    slack = 1e-6 * outline.radius
    beside = [np.roll(heights, 1, axis=0), np.roll(heights, -1, axis=0)]
    low = np.all([heights <= one + slack for one in beside], axis=0)[:, 1:-1]
    low &= heights[:, 1:-1] < heights[:, :-2]
    low &= heights[:, 1:-1] <= heights[:, 2:] + slack
    found = np.degrees(leans[1:-1])[low.any(axis=0)]
    found = found[found >= SIDES.least_deg]
    return float(found[0]) if len(found) else None
