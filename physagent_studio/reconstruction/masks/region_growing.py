"""Drafts from clicks by growing: all that is connected to a click and coloured much like it.

A thing of one colour is found whole however thin it is. How unlike its pixels may be is not known,
so that the tolerance is raised step by step: where the region hardly grows for a while, it has
come up against an edge on all sides (the idea of maximally stable extremal regions; Matas et al.,
"Robust wide-baseline stereo from maximally stable extremal regions", 2004).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import BoolArray, Pixel, holding, iou

FloatArray = NDArray[np.float64]

TOLERANCES = tuple(float(t) for t in np.geomspace(5, 64, 18))
"""Colour steps (OpenCV's Lab, 0 … 255) up to which a pixel counts as like the click."""
LIGHTNESS = 0.45
"""Weight of a step in lightness: one thing is lit and shaded."""
SPOT = 2
"""Pixels around a click that say its colour."""
LARGEST = 0.5
"""Share of the picture above which a region is the background."""
STEADY = 1.2
"""Growth over one step of the tolerance below which a region stands still."""


def regions(lab: NDArray[np.float32], inside: tuple[Pixel, ...]) -> list[BoolArray]:
    """The regions around the clicks where growing halts, the steadiest first; lab (H, W, 3)."""
    if not inside:
        return []
    unlike = _unlike(lab, inside)
    grown = [holding(unlike <= t, list(inside)) for t in TOLERANCES]
    sizes = np.array([max(np.count_nonzero(mask), 1) for mask in grown], float)
    rates = sizes[1:] / sizes[:-1]
    found: list[tuple[float, BoolArray]] = []
    for k in range(1, len(grown)):
        share = sizes[k] / unlike.size
        halts = rates[k - 1] < STEADY
        goes_on = k < len(rates) and rates[k] < rates[k - 1]
        if not halts or goes_on or share > LARGEST or sizes[k] < 12:
            continue
        if all(iou(grown[k], other) < 0.9 for _, other in found):
            found.append((float(rates[k - 1]), grown[k]))
    return [mask for _, mask in sorted(found, key=lambda item: item[0])]


def _unlike(lab: NDArray[np.float32], inside: tuple[Pixel, ...]) -> FloatArray:
    """(H, W) colour step to the nearest of the clicks' colours."""
    rows, columns = lab.shape[:2]
    out = np.full((rows, columns), np.inf)
    for x, y in inside:
        column, row = int(min(max(x, 0), columns - 1)), int(min(max(y, 0), rows - 1))
        low_y, low_x = max(0, row - SPOT), max(0, column - SPOT)
        spot = lab[low_y : row + SPOT + 1, low_x : column + SPOT + 1].reshape(-1, 3)
        # The pixel itself may be a highlight, its surroundings may hold an edge.
        near = spot[np.linalg.norm(spot - lab[row, column], axis=1) < 25]
        step = (lab - np.median(near, axis=0)) * (LIGHTNESS, 1, 1)
        out = np.minimum(out, np.sqrt(np.einsum("ijk,ijk->ij", step, step)))
    return out
