"""The camera from the picture: where the horizon is, and how sure that is.

Several cues vote on the row of the horizon: edges that meet in a vanishing point, things of
known size that stand at different depths, what stands on the ground lies below it, and the way
people hold cameras. The answer is the best row and the spread of the votes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.lines import Segments, level_transitions, meeting_points
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]

PITCH = math.radians(9.0)
PITCH_SPREAD = math.radians(8.0)
"""People look down a little: prior of the pitch."""


@dataclass(frozen=True, slots=True)
class Standing:
    """A thing that stands on a level plane: where, how large it looks, how large it is.

    foot: row of its lowest point. extent: pixels. metres, spread: its usual size and the
    standard deviation of its logarithm. plane: which plane; only things on one are compared.
    """

    foot: float
    extent: float
    metres: float
    spread: float
    plane: str


@dataclass(frozen=True, slots=True)
class Horizon:
    """row: pixels, in the middle column. sigma: pixels. focal: pixels."""

    row: float
    sigma: float
    focal: float


def usual_focal(size: tuple[int, int]) -> float:
    """Focal length in pixels of a 45° field of view on the shorter side."""
    return min(size) / 2 / math.tan(math.radians(22.5))


def estimate(
    image: Image,
    found: Segments,
    standing: Sequence[Standing],
    limits: Sequence[float] = (),
    focal: float | None = None,
) -> Horizon:
    """The horizon of a picture.

    found: its straight edges. standing: things on level planes. limits: rows of further
    points that certainly lie on a level plane, hence below the horizon.
    """
    rows, columns = image.shape[:2]
    focal = focal or usual_focal((columns, rows))
    grid = np.arange(-1.2 * rows, 1.1 * rows, 1.0)
    votes = _posture(grid, rows, focal)
    votes += _vanishing(grid, found, (columns, rows))
    votes += _below(grid, [item.foot for item in standing], rows, 0.02)
    votes += _below(grid, limits, rows, 0.0)
    votes += _sizes(grid, standing)
    votes += _shore(grid, image, rows)
    weight = np.exp(votes - votes.max())
    weight /= weight.sum()
    row = float(grid[int(votes.argmax())])
    near = np.abs(grid - row) < 0.75 * rows
    sigma = math.sqrt(float((weight[near] * (grid[near] - row) ** 2).sum() / weight[near].sum()))
    return Horizon(row, max(sigma, 1.0), focal)


def _posture(grid: FloatArray, rows: int, focal: float) -> FloatArray:
    """Log prior of the pitch, with a heavy tail for views from above."""
    pitch = np.arctan2(rows / 2 - grid, focal)
    off = (pitch - PITCH) / PITCH_SPREAD
    return np.where(off > 0, -np.log1p(off**2 / 3) * 2, -0.5 * off**2)


def _vanishing(grid: FloatArray, found: Segments, size: tuple[int, int]) -> FloatArray:
    """Edges of level things meet on the horizon; some meet elsewhere, so it is a soft vote."""
    votes = np.zeros_like(grid)
    for x, y, weight in meeting_points(found, size):
        # A point far off the picture is known less well.
        away = math.hypot(x - size[0] / 2, y - size[1] / 2) / size[1]
        sigma = size[1] * (0.02 + 0.03 * away)
        hit = np.exp(-0.5 * ((grid - y) / sigma) ** 2)
        votes += np.log(0.25 + 3.0 * weight * hit) - np.log(0.25)
    return votes


def _below(grid: FloatArray, feet: Sequence[float], rows: int, margin: float) -> FloatArray:
    """What stands on the ground is seen below the horizon."""
    votes = np.zeros_like(grid)
    for foot in feet:
        over = (grid - (foot - margin * rows)) / (0.01 * rows)
        votes -= np.where(over > 0, np.minimum(over, 30) ** 1.0, 0)
    return votes


def _sizes(grid: FloatArray, standing: Sequence[Standing]) -> FloatArray:
    """Things of known size on one plane must give one height of the camera above it."""
    votes = np.zeros_like(grid)
    for plane in {item.plane for item in standing}:
        items = [item for item in standing if item.plane == plane]
        if len(items) < 2:
            continue
        below = np.array([item.foot for item in items])[None] - grid[:, None]
        logs = np.log(np.maximum(below, 1.0))
        logs = logs + np.log([item.metres / item.extent for item in items])
        spread = np.array([item.spread for item in items]) + 0.05
        weight = 1 / spread**2
        middle = (logs * weight).sum(1, keepdims=True) / weight.sum()
        votes -= (np.log1p(0.5 * ((logs - middle) / spread) ** 2)).sum(1)
    return votes


def _shore(grid: FloatArray, image: Image, rows: int) -> FloatArray:
    """A line across the whole picture is a wall's foot or the horizon itself: none is below."""
    votes = np.zeros_like(grid)
    lines = [y for y, strength in level_transitions(image) if strength > 0.7]
    if lines:
        over = (grid - max(lines) - 0.02 * rows) / (0.03 * rows)
        votes -= np.where(over > 0, np.minimum(over, 4), 0)
    return votes


def weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """The value that halves the total weight."""
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weights[order]) / weights.sum()
    return float(values[order][int(np.searchsorted(share, 0.5))])
