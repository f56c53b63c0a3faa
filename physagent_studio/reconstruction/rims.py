"""Rims of cups, bowls and cans: a level circle whose far half ends the silhouette above."""

from __future__ import annotations

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
    columns = np.arange(x1 - x0) + 0.5
    top = np.where(part.any(0), part.argmax(0), np.nan).astype(float)
    best: tuple[float, Disc] | None = None
    for row in range(2, min(y1 - y0, round(0.6 * (x1 - x0)))):
        wide = np.flatnonzero(part[row])
        if len(wide) < WIDEST * (x1 - x0):
            continue
        left, right = float(wide[0]), float(wide[-1] + 1)
        half, middle = (right - left) / 2, (left + right) / 2
        # Near its ends an ellipse is steep, and a pixel to the side is many pixels down.
        across = (columns - middle) / half
        inner = np.abs(across) < 0.93
        high = float(np.nanmin(top[inner])) if np.isfinite(top[inner]).any() else np.nan
        rise = row + 0.5 - high
        if not np.isfinite(rise) or rise <= 0:
            continue
        ellipse = row + 0.5 - rise * np.sqrt(1 - across[inner] ** 2)
        off = float(np.sqrt(np.nanmean((top[inner] - ellipse) ** 2))) / (2 * half)
        if best is None or off < best[0]:
            best = (off, Disc(y0 + row + 0.5, rise / half))
    if best is None or best[0] > OFF + 0.7 / (x1 - x0):
        return None
    return best[1] if FLATTEST < best[1].flatness < ROUNDEST else None
