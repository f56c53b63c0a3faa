"""Bars across the free ends of a mask's poles join it: handlebars, heads of hammers and signs."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from physagent_studio.program.scene import Grounding
from physagent_studio.reconstruction.crossbars import ALONG, REACH, UNIT, bar_at
from physagent_studio.reconstruction.grabcut import cut
from physagent_studio.reconstruction.masks import BoolArray, bounds, resized
from physagent_studio.reconstruction.pole_ends import PoleEnd, pole_ends
from physagent_studio.records.case import Image

FINER, ENLARGED = 1.5, 3.0
"""How much finer than it is sought a bar's outline is settled; enlargement of a picture at most."""


def with_crossbars(image: Image, mask: BoolArray, grounding: Grounding) -> BoolArray | None:
    """The mask (H, W) with the bars across the free ends of its poles; None without any.

    What holds a click outside, or leaves a box, is none.
    """
    out = mask
    for end in pole_ends(mask):
        found = _with_bar(image, mask, end)
        if found is not None and not _barred(found & ~mask, grounding):
            out = out | found
    return None if out is mask else out


def _with_bar(image: Image, mask: BoolArray, end: PoleEnd) -> BoolArray | None:
    """The mask with the bar at an end of it, its outline settled by GrabCut; None without one."""
    reach = (REACH + ALONG) * end.width
    x0, y0 = np.maximum(np.floor(end.tip - reach).astype(int), 0)
    x1, y1 = np.ceil(end.tip + reach).astype(int)
    window = (slice(y0, max(y0 + 1, y1)), slice(x0, max(x0 + 1, x1)))
    factor = min(FINER * UNIT / end.width, ENLARGED)
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    piece = cv2.resize(image[window], None, fx=factor, fy=factor, interpolation=how)
    piece = np.ascontiguousarray(piece, np.uint8)
    own = resized(mask[window], (piece.shape[1], piece.shape[0]))
    tip = (end.tip + 0.5 - (x0, y0)) * factor - 0.5
    bar = bar_at(piece, own, replace(end, tip=tip, width=end.width * factor))
    if bar is None:
        return None
    core = bar.drawn(own.shape, likely=False)
    trimap = np.full(own.shape, cv2.GC_BGD, np.uint8)
    trimap[bar.drawn(own.shape, likely=True)] = cv2.GC_PR_FGD
    trimap[own | core] = cv2.GC_FGD
    found = cut(piece, trimap, 3)
    new = (core if found is None else found | core) & ~own
    out = mask.copy()
    # A pixel of the mask around keeps the new part from coming loose when it is brought to size.
    joint = new | (own & cv2.dilate(new.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool))
    out[window] |= resized(joint, (mask[window].shape[1], mask[window].shape[0]))
    return out


def _barred(new: BoolArray, grounding: Grounding) -> bool:
    """Whether a bar holds a click outside or leaves the box."""
    x0, y0, x1, y1 = bounds(new)
    for click in grounding.points:
        x, y = int(click.x), int(click.y)
        if not click.label and new[max(0, y - 2) : y + 3, max(0, x - 2) : x + 3].any():
            return True
    if grounding.box is None:
        return False
    left, right = sorted(grounding.box[::2])
    top, low = sorted(grounding.box[1::2])
    return x0 < left - 3 or y0 < top - 3 or x1 > right + 3 or y1 > low + 3
