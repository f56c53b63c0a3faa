"""Whether the camera was held askew: upright edges that all lean the same way say so.

Upright edges run towards the point straight below the camera. For each tilt to the side and each
tilt down they would run in certain directions, which the edges of the picture agree with or not.
Pictures are mostly level, and much else leans: the answer is "level" unless many edges agree on
something else, and far fewer on that.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.camera.estimate import Horizon, usual_focal
from physagent_studio.reconstruction.camera.right_angles import Edges
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.switches import at_work


@dataclass(frozen=True, slots=True)
class RollSettings:
    """When upright edges say that the camera was held askew."""

    # -20..20: first, end and step of the turns that are tried: more is done on purpose
    rolls_deg: tuple[float, float, float] = (-12.0, 12.05, 0.1)
    # -10..60: the same of the tilts down: uprights tell little of how steep a view is
    pitches_deg: tuple[float, float, float] = (-5.0, 42.0, 2.5)
    max_lean_rad: float = math.radians(25.0)  # 0.2..0.8: more is no upright edge
    max_bend_rad: float = math.radians(6.0)  # 0.03..0.3: more is no straight edge
    min_edge_ratio: float = 0.04  # 0.01..0.1: length over the diagonal: shorter edges are grain
    edge_spread_rad: float = math.radians(0.6)  # 0.003..0.03: how exactly an edge shows its lean
    # 0.1..0.5: of the diagonal: one long edge must not outvote several
    full_edge_ratio: float = 0.25
    min_edges: int = 5  # count, 3..12: fewer agree by chance
    min_share: float = 0.55  # 0.4..0.9: of all the length looked at, what has to agree
    min_total_ratio: float = 0.4  # 0.2..2: of the diagonal, the length that has to agree
    max_level_share: float = 0.6  # 0.3..0.9: of what agrees with a turn, what may agree with level
    min_roll_rad: float = math.radians(1.5)  # 0.01..0.1: a smaller turn is not told from none


ROLL = RollSettings()

ROLLS = np.radians(np.arange(*ROLL.rolls_deg))
"""Turns of the camera about its axis that are tried, rad, and the tilts down for each."""
PITCHES = np.radians(np.arange(*ROLL.pitches_deg))


def roll_of(found: Segments, size: tuple[int, int]) -> float:
    """Radians by which the camera is turned clockwise; 0 unless upright edges clearly say so.

    size: (width, height) of the picture whose straight edges are given.
    """
    if not at_work("roll"):
        return 0.0
    diagonal = math.hypot(*size)
    along = found.ends[:, 1] - found.ends[:, 0]
    along = np.where(along[:, 1:] < 0, -along, along)
    lean = np.arctan2(along[:, 0], along[:, 1])
    looked = (
        (np.abs(lean) < ROLL.max_lean_rad)
        & (found.bend < ROLL.max_bend_rad)
        & (found.length > ROLL.min_edge_ratio * diagonal)
    )
    if np.count_nonzero(looked) < ROLL.min_edges:
        return 0.0
    weight = np.minimum(found.length[looked] / diagonal, ROLL.full_edge_ratio)
    middle = found.ends[looked].mean(1) - np.array(size) / 2
    agree = _agreement(lean[looked], middle, usual_focal(size))
    votes = agree @ weight
    pitch, best = (int(k) for k in np.unravel_index(int(votes.argmax()), votes.shape))
    most, level = votes[pitch, best], votes[:, int(np.abs(ROLLS).argmin())].max()
    clear = (
        most > max(ROLL.min_share * weight.sum(), ROLL.min_total_ratio)
        and level < ROLL.max_level_share * most
    )
    many = np.count_nonzero(agree[pitch, best] > 0.5) >= ROLL.min_edges
    roll = float(ROLLS[best])
    return (
        roll
        if clear and many and ROLL.min_roll_rad < abs(roll) < abs(ROLLS[0]) - ROLL.edge_spread_rad
        else 0.0
    )


@dataclass(frozen=True, slots=True)
class Levelled:
    """A picture of some size (width, height), turned about its middle until it is level.

    roll: radians by which its camera was turned clockwise.
    """

    size: tuple[int, int]
    roll: float

    def row(self, place: tuple[float, float]) -> float:
        """The row of a place (x, y) in the level picture."""
        if not self.roll:
            return place[1]
        x, y = place[0] - self.size[0] / 2, place[1] - self.size[1] / 2
        return self.size[1] / 2 + x * math.sin(self.roll) + y * math.cos(self.roll)

    def edges(self, found: Edges) -> Edges:
        """Edges, from the middle of the picture."""
        cos, sin = math.cos(self.roll), math.sin(self.roll)
        turn = np.array([[cos, sin], [-sin, cos]])
        return replace(found, ends=found.ends @ turn) if self.roll else found

    def tilted(self, horizon: Horizon) -> Horizon:
        """The horizon of the level picture as it runs through the picture itself."""
        if not self.roll:
            return horizon
        half = self.size[1] / 2
        row = half - (half - horizon.row) / math.cos(self.roll)
        return replace(horizon, row=row, roll=self.roll)


def _agreement(lean: FloatArray, middle: FloatArray, focal: float) -> FloatArray:
    """(P, R, N) 0 … 1: how well each edge is upright for each tilt down and turn.

    lean: (N,) from the vertical, rad. middle: (N, 2) pixels from the middle of the picture.
    """
    cos, sin = np.cos(ROLLS)[:, None], np.sin(ROLLS)[:, None]
    x, y = middle.T
    across, down = x * cos - y * sin, x * sin + y * cos
    slope = np.tan(PITCHES)[:, None, None]
    towards = np.arctan2(-across * slope, focal - down * slope)
    off = lean - ROLLS[:, None] - towards
    return np.exp(-0.5 * (off / ROLL.edge_spread_rad) ** 2)
