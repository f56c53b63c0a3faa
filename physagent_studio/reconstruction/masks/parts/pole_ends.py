"""The free ends of the poles of a mask: where it is farthest from its body, if thin there."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds

FloatArray = NDArray[np.float64]
SIDE = 300
"""Longer side in pixels at which a mask is walked along."""
PIECES = (0.15, 0.25, 0.4)
"""Lengths of the piece of a pole that is looked at, in sides of the mask, until one is slim."""
SLIM, EVEN = 3.5, 1.0
"""Length over width of it at least, and how wide its widest place is over its width at most."""


@dataclass(frozen=True, eq=False, slots=True)
class PoleEnd:
    """tip: (2,) x, y in the picture. outward: (2,) unit vector of the pole there. width: pixels."""

    tip: FloatArray
    outward: FloatArray
    width: float

    @property
    def aside(self) -> FloatArray:
        """(2,) across the pole, to the right of outward."""
        return np.array([-self.outward[1], self.outward[0]])


def pole_ends(mask: BoolArray) -> tuple[PoleEnd, ...]:
    """Up to two free ends of poles of a mask (H, W)."""
    x0, y0, x1, y1 = bounds(mask)
    side = max(x1 - x0, y1 - y0)
    if side < 24:
        return ()
    factor = min(1.0, SIDE / side)
    size = (max(1, round((x1 - x0) * factor)), max(1, round((y1 - y0) * factor)))
    crop = mask[y0:y1, x0:x1].astype(np.uint8)
    small = np.pad(cv2.resize(crop * 255, size, interpolation=cv2.INTER_AREA) > 100, 1)
    deep = cv2.distanceTransform(small.astype(np.uint8), cv2.DIST_L2, 3)
    first = _farthest(small, np.unravel_index(int(np.argmax(deep)), deep.shape))
    places = [first, _farthest(small, first)]
    found = [_end_at(small, place, max(size)) for place in places]
    corner = np.array([x0, y0])
    return tuple(
        PoleEnd((end.tip - 0.5) / factor + corner - 0.5, end.outward, end.width / factor)
        for end in found
        if end is not None
    )


def _steps(mask: BoolArray, place: tuple, most: float = np.inf) -> NDArray[np.int32]:
    """(h, w) steps within the mask from a place, -1 where it is not reached in so many."""
    out = np.full(mask.shape, -1, np.int32)
    front = np.zeros(mask.shape, np.uint8)
    front[place] = 1
    inside = mask.astype(np.uint8)
    out[place] = 0
    shapes = (cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)), np.ones((3, 3), np.uint8))
    step = 0
    while step < most:
        step += 1
        wider = np.minimum(cv2.dilate(front, shapes[step % 2]), inside)
        fresh = wider != front
        if not fresh.any():
            break
        out[fresh] = step
        front = wider
    return out


def _farthest(mask: BoolArray, place: tuple) -> tuple:
    """The place of a mask that is the most steps from another."""
    steps = _steps(mask, place)
    return np.unravel_index(int(np.argmax(steps)), steps.shape)


def _end_at(mask: BoolArray, place: tuple, side: float) -> PoleEnd | None:
    """The end of a pole at a place of the mask; None where the mask is not slim there."""
    steps = _steps(mask, place, max(PIECES) * side)
    ends = (_end_of((steps >= 0) & (steps <= length * side), place) for length in PIECES)
    return next((end for end in ends if end is not None), None)


def _end_of(piece: BoolArray, place: tuple) -> PoleEnd | None:
    """The end of a piece (h, w) that begins at a place of it; None where it is not slim."""
    rows, columns = np.nonzero(piece)
    points = np.stack([columns, rows], 1).astype(float)
    middle = points.mean(0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    outward = axes[0] * np.sign((np.array([place[1], place[0]]) - middle) @ axes[0])
    along, aside = (points - middle) @ outward, (points - middle) @ axes[1]
    extent = float(np.ptp(along)) + 1
    width = len(points) / extent
    if extent < SLIM * width or float(np.ptp(aside)) + 1 > (1 + EVEN) * width:
        return None
    near = along > along.max() - 2 * width
    centre = outward * (along.max() + 0.5) + axes[1] * float(np.median(aside[near]))
    return PoleEnd(middle + centre, outward, width)
