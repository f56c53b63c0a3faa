"""Whether the camera was held askew: upright edges that all lean the same way say so.

Upright edges run towards the point straight below the camera. For each tilt to the side and each
tilt down they would run in certain directions, which the edges of the picture agree with or not.
Pictures are mostly level, and much else leans: the answer is "level" unless many edges agree on
something else, and far fewer on that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.camera.estimate import Horizon, usual_focal
from physagent_studio.reconstruction.camera.right_angles import Edges
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]

ROLLS = np.radians(np.arange(-12.0, 12.05, 0.1))
"""Turns of the camera about its axis that are tried, and the tilts down for each."""
PITCHES = np.radians(np.arange(-5.0, 42.0, 2.5))
LEANING, BENT, SHORTEST = math.radians(25.0), math.radians(6.0), 0.04
"""Edges that are looked at: lean and bend at most, and share of the diagonal at least."""
SHARP = math.radians(0.6)
"""Standard deviation of an edge's direction."""
LONGEST = 0.25
"""Share of the diagonal from which an edge counts no more for being longer."""
EDGES, SHARE, WEIGHT = 5, 0.55, 0.4
"""What speaks for a turn at least: edges, their share of all that were looked at, by length, and
their length in diagonals."""
CLEAR, LEAST = 0.6, math.radians(1.5)
"""Share of the edges that agree with a turn up to which may agree with a level picture, and the
least turn that is told from one."""


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
    looked = (np.abs(lean) < LEANING) & (found.bend < BENT) & (found.length > SHORTEST * diagonal)
    if np.count_nonzero(looked) < EDGES:
        return 0.0
    weight = np.minimum(found.length[looked] / diagonal, LONGEST)
    middle = found.ends[looked].mean(1) - np.array(size) / 2
    agree = _agreement(lean[looked], middle, usual_focal(size))
    votes = agree @ weight
    pitch, best = (int(k) for k in np.unravel_index(int(votes.argmax()), votes.shape))
    most, level = votes[pitch, best], votes[:, int(np.abs(ROLLS).argmin())].max()
    clear = most > max(SHARE * weight.sum(), WEIGHT) and level < CLEAR * most
    many = np.count_nonzero(agree[pitch, best] > 0.5) >= EDGES
    roll = float(ROLLS[best])
    return roll if clear and many and LEAST < abs(roll) < abs(ROLLS[0]) - SHARP else 0.0


@dataclass(frozen=True, slots=True)
class Levelled:
    """A picture of some size (width, height), turned about its middle until it is level.

    roll: radians by which its camera was turned clockwise.
    """

    size: tuple[int, int]
    roll: float

    def image(self, image: Image) -> Image:
        """The picture (H, W, 3), with its rim drawn out where it shows nothing."""
        if not self.roll:
            return image
        width, height = self.size
        turn = cv2.getRotationMatrix2D((width / 2, height / 2), -math.degrees(self.roll), 1.0)
        out = cv2.warpAffine(image, turn, (width, height), borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(out, np.uint8)

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
    return np.exp(-0.5 * (off / SHARP) ** 2)
