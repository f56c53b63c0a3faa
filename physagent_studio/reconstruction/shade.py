"""Shade that things keep around their foot: dark ground beside them that fills should not copy."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import BoolArray, bounds, grow, without_pinholes
from physagent_studio.records.case import Image

FloatImage = NDArray[np.float32]
SIDE = 208
"""Longer side of the picture in which shade is looked for."""
DARKER = 7.0
"""How much darker than lit ground shade is at least, in L* of 0 … 100."""
FAINT = 1.6
"""The same at its faint rim."""
GRAINS = (3.0, 1.0)
"""The same in units of how uneven the lit ground is itself."""
REACH = 1.5
"""How far from a thing its shade is looked for, in sizes of it."""
ENDS = 6
"""Pixels far out on a side from which darkness reaches that far."""
TINT = 9.0
"""How far its colour may differ from that of the ground for its lightness, in a*, b*."""
BOUNCE = 0.6
"""The same for each L* of darkness: there, light thrown back by the thing is most of it."""
BARE = 0.7
"""Share of the rim of a shade that has the ground's colour, at least."""
POCKET = 0.1
"""Largest gap in shade that belongs to it, as a share of it."""
ABOVE = (0.3, 0.9)
"""Shade begins this share of a thing's height above its foot, and ends below that one."""


def shaded(photo: Image, masks: Sequence[BoolArray], hole: BoolArray) -> BoolArray:
    """(H, W) ground around the feet of the masked things that looks as if they shaded it."""
    factor = min(1.0, SIDE / max(hole.shape))
    size = (max(8, round(hole.shape[1] * factor)), max(8, round(hole.shape[0] * factor)))
    small = cv2.resize(photo, size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    lab = np.asarray(cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 1.0), cv2.COLOR_RGB2LAB), "f4")
    inside = cv2.resize(hole.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    out = np.zeros(inside.shape, bool)
    for mask in masks:
        own = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_AREA) > 0
        if own.any():
            out |= _around(lab, own, inside)
    wide = cv2.resize(out.astype(np.float32), hole.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.asarray(cv2.GaussianBlur(wide, (0, 0), 0.7 / factor) > 0.4)


def _around(lab: FloatImage, own: BoolArray, inside: BoolArray) -> BoolArray:
    """Shade of one thing: dark, of the ground's colour, and joined to the thing at its foot."""
    x0, y0, x1, y1 = bounds(own)
    side = max(x1 - x0, y1 - y0)
    rows = np.arange(own.shape[0])[:, None] * np.ones(own.shape[1])
    low = rows >= y1 - round(ABOVE[0] * (y1 - y0))
    ground = rows >= y1 - round(ABOVE[1] * (y1 - y0))
    near = ground & grow(own, round(REACH * side)) & ~inside
    far = low & grow(own, round(1.2 * side)) & ~grow(own, round(0.25 * side)) & ~inside
    if np.count_nonzero(far) < 30 or not near.any():
        return np.zeros_like(own)
    lit, uneven = _lit(lab, far | (near & low))
    darker = lit[..., 0] - lab[..., 0]
    # In shade a colour keeps its hue and pales with its lightness.
    share = (lab[..., :1] / np.maximum(lit[..., :1], 1)).clip(0, 1)
    tint = _of_the_ground(lab[..., 1:] - lit[..., 1:] * share, darker, _own_tint(lab, own, lit))
    dark = near & (darker > max(DARKER, GRAINS[0] * uneven)) & tint
    mine = _joined_to(dark, own | inside, own, low)
    if _goes_on(mine, near & ~grow(own, round(0.55 * side)), x0, x1):
        return np.zeros_like(own)
    # Shade fades out: its faint rim belongs to it.
    smooth = np.asarray(cv2.blur(darker, (3, 3)))
    faint = near & tint & (smooth > max(FAINT, GRAINS[1] * uneven))
    wide = mine
    for _ in range(max(2, side // 4)):
        wide = mine | (grow(wide, 1) & faint)
    wide = without_pinholes(grow(wide, 1) & near | inside, POCKET) & near
    # Shade ends on lit ground; what ends at another colour is paint.
    rim = grow(wide, 3) & ~grow(wide, 1) & ground & ~inside
    return wide if rim.any() and tint[rim].mean() > BARE else np.zeros_like(own)


def _own_tint(lab: FloatImage, own: BoolArray, lit: FloatImage) -> FloatImage:
    """The direction (a*, b*) from the ground's colour to the thing's; zero where they are alike."""
    apart = lab[own, 1:].mean(0) - lit[own, 1:].mean(0)
    far = float(np.hypot(*apart))
    return (apart / far if far > TINT else apart * 0).astype(np.float32)


def _of_the_ground(off: FloatImage, darker: FloatImage, own: FloatImage) -> BoolArray:
    """Whether colours (H, W, 2) off the ground's may be its own, or what the thing throws back.

    own: the direction to the thing's colour.
    """
    far = np.abs(off).max(-1)
    thrown = (off @ own > 0.8 * np.linalg.norm(off, axis=-1)) & (far < TINT + BOUNCE * darker)
    return (far < TINT) | thrown


def _joined_to(dark: BoolArray, through: BoolArray, own: BoolArray, low: BoolArray) -> BoolArray:
    """What is dark and hangs together with the thing at its foot."""
    joined = dark | ((grow(own, 2) | through) & low)
    _, labels = cv2.connectedComponents(joined.astype(np.uint8))
    return np.isin(labels, np.unique(labels[own & low])) & dark


def _goes_on(dark: BoolArray, outer: BoolArray, left: int, right: int) -> bool:
    """Whether what is dark reaches far out on both sides, as a belt or a wall: light has a side."""
    rim = dark & outer
    return bool(rim[:, :left].sum() > ENDS and rim[:, right:].sum() > ENDS)


def _lit(lab: FloatImage, ground: BoolArray) -> tuple[FloatImage, float]:
    """(H, W, 3) the ground without shade, a smooth surface through its lighter half.

    Also how uneven the lit ground is, in L*.
    """
    rows, columns = np.nonzero(ground)
    scale = float(max(ground.shape))
    terms = np.stack([np.ones(len(rows)), columns / scale, rows / scale], 1)
    values = lab[rows, columns].astype(float)
    weight = np.ones(len(rows))
    fit = np.zeros((3, 3))
    for _ in range(8):
        root = np.sqrt(weight)[:, None]
        fit = np.linalg.lstsq(terms * root, values * root, rcond=None)[0]
        rest = values[:, 0] - terms @ fit[:, 0]
        spread = max(1.5 * float(np.median(np.abs(rest))), 2.0)
        weight = 1 / (1 + (rest / np.where(rest < 0, spread, 2 * spread)) ** 2)
    rest = values[:, 0] - terms @ fit[:, 0]
    # Shade makes the dark side of the spread wide, so it is the light side that tells.
    uneven = 1.5 * float(np.median(np.abs(rest[rest > 0]))) if (rest > 0).any() else 0.0
    y, x = np.indices(ground.shape) / scale
    return (np.stack([np.ones_like(x), x, y], -1) @ fit).astype(np.float32), uneven
