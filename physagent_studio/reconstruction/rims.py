"""Rims of cups, bowls and cans: a level circle whose far half ends the silhouette above."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.reconstruction.camera import Disc
from physagent_studio.reconstruction.masks import BoolArray, bounds
from physagent_studio.reconstruction.names import words_of
from physagent_studio.reconstruction.vessels import is_vessel

FLAT_TOPPED = frozenset(["can", "tin", "drum", "plate", "dish", "saucer", "puck", "cylinder"])
"""Closed things whose top is a level disc."""
OFF = 0.012
"""How far the silhouette may lie off the ellipse, root mean square, as a share of its width."""
FLATTEST, ROUNDEST = 0.06, 0.9
"""Height over width of an ellipse that says something."""
SURE = 1.5
"""How surely a rim tells the slope at which it is seen, degrees."""
WIDEST = 0.96
"""Share of the width of the whole that the rim has: such things are widest there."""
NARROWEST = 24
"""Pixels across from which on a rim is looked at."""


def has_a_rim(name: str) -> bool:
    """Whether a thing of that name ends above in a level circle."""
    words = words_of(name)
    return bool(words) and (is_vessel(name, "") or words[-1] in FLAT_TOPPED)


def rim_of(mask: BoolArray) -> Disc | None:
    """The ellipse whose upper half ends a silhouette above; None where there is none."""
    x0, y0, x1, y1 = bounds(mask)
    if x1 - x0 < NARROWEST:
        return None
    part = mask[y0:y1, x0:x1]
    wide = np.flatnonzero(part.sum(1) >= WIDEST * (x1 - x0))
    if not len(wide):
        return None
    ends = np.flatnonzero(part[wide[0]])
    half, middle = (ends[-1] + 1 - ends[0]) / 2, (ends[-1] + 1 + ends[0]) / 2
    # Near its ends an ellipse is steep, and a pixel to the side is many pixels down.
    across = (np.arange(x1 - x0) + 0.5 - middle) / half
    inner = (np.abs(across) < 0.93) & part.any(0)
    bulge = np.sqrt(1 - across[inner] ** 2)
    top = part.argmax(0)[inner].astype(float)
    (row, rise), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(bulge), -bulge]), top)
    off = float(np.sqrt(np.mean((top - row + rise * bulge) ** 2))) / (2 * half)
    flatness = float(rise) / half
    if off > OFF + 0.3 / half or not -FLATTEST < flatness < ROUNDEST or row > 1.2 * (x1 - x0):
        return None
    sigma = math.hypot(SURE, math.degrees(1 / half))
    return Disc(y0 + float(row), max(flatness, 0.0), sigma, either=True)
