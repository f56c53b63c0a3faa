"""Bars across the free ends of a mask's poles join it: handlebars, heads of hammers and signs."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.grabcut import part_of
from physagent_studio.reconstruction.masks.parts.closer_pieces import is_barred, with_part
from physagent_studio.reconstruction.masks.parts.crossbars import ALONG, REACH, UNIT, bar_at
from physagent_studio.reconstruction.masks.parts.pole_ends import PoleEnd, pole_ends
from physagent_studio.reconstruction.photo.regions import BoolArray, resized
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
        if found is not None and not is_barred(found & ~mask, grounding):
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
    core, likely = (bar.drawn(own.shape, likely=likely) for likely in (False, True))
    return with_part(mask, window, own, part_of(piece, own, core, likely))
