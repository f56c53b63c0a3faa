"""Lines that cross behind what is taken out of a picture: which of them end at which.

The two edges of a beam part wood from wall over their whole length. What runs up to both of them,
as the joints of the wall do, is hidden by the beam and not seen on it.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]
BROAD = (5, 9, 13, 17)
"""How far off a line its sides are compared, pixels: wider than joints and painted stripes."""
BEFORE = (4, 8, 12, 16, 20, 24, 28)
"""How far before the ends of its hidden part, pixels."""
WEIGHTS = (0.4, 1.0, 1.0)
"""What L*, a*, b* count, 0 … 255 each: bricks differ in lightness, wood from brick in colour."""
PARTS = 10.0
"""Least difference of what a line parts, in these."""
MORE = 1.6
"""How much more than another one it has to part, to be in front of it."""


def without_hidden(photo: Image, hole: BoolArray, lines: FloatArray) -> FloatArray:
    """Lines (N, 2, 2), pixels, without the pieces that lie behind what others bound.

    hole: (H, W) what hides them all.
    """
    if len(lines) < 3:
        return lines
    soft = cv2.GaussianBlur(photo, (0, 0), 1.5)
    lab = cv2.cvtColor(soft, cv2.COLOR_RGB2LAB).astype(np.float32) * np.array(WEIGHTS, np.float32)
    parts = np.array([_parted(lab, hole, line) for line in lines])
    out = []
    for index, line in enumerate(lines):
        front = (parts > PARTS) & (parts > MORE * parts[index])
        met = sorted(
            share
            for other in lines[front]
            if (share := _met(line, other)) is not None and 0.02 < share < 0.98
        )
        if len(met) < 2:
            out.append(line)
            continue
        way = line[1] - line[0]
        out += [(line[0], line[0] + met[0] * way), (line[0] + met[-1] * way, line[1])]
    return np.array(out).reshape(-1, 2, 2)


def _parted(lab: NDArray[np.float32], hole: BoolArray, line: FloatArray) -> float:
    """How much what lies on the two sides of a line differs, at one of its ends."""
    way = (line[1] - line[0]) / max(float(np.linalg.norm(line[1] - line[0])), 1e-9)
    normal = np.array([-way[1], way[0]])
    steps = []
    for end, back in ((line[0], -way), (line[1], way)):
        before = end + np.array(BEFORE)[:, None] * back
        both = []
        for sign in (1, -1):
            spots = (before[:, None] + sign * np.array(BROAD)[None, :, None] * normal).astype(int)
            x, y = spots[..., 0].ravel(), spots[..., 1].ravel()
            inside = (x >= 0) & (y >= 0) & (x < hole.shape[1]) & (y < hole.shape[0])
            x, y = x[inside], y[inside]
            free = ~hole[y, x]
            if np.count_nonzero(free) < 8:
                return 0.0
            both.append(np.median(lab[y[free], x[free]], axis=0))
        steps.append(both[0] - both[1])
    # At one end something else may lie beside it, but not the other way round.
    sizes = [float(np.linalg.norm(step)) for step in steps]
    return max(sizes) if float(steps[0] @ steps[1]) > -0.25 * max(sizes) ** 2 else 0.0


def _met(line: FloatArray, other: FloatArray) -> float | None:
    """Where on a line, as a share of it, another one crosses it; None where it does not."""
    u, v = line[1] - line[0], other[1] - other[0]
    turn = float(u[0] * v[1] - u[1] * v[0])
    if abs(turn) < 0.1 * float(np.linalg.norm(u) * np.linalg.norm(v)):
        return None
    gap = other[0] - line[0]
    share = float(gap[0] * v[1] - gap[1] * v[0]) / turn
    along = float(gap[0] * u[1] - gap[1] * u[0]) / turn
    return share if -0.02 < along < 1.02 else None
