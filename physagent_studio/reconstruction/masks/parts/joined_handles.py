"""Thin handles join the mask of things that have some: arches on lids, buckets and baskets."""

from __future__ import annotations

import cv2
import numpy as np

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.grabcut import part_of
from physagent_studio.reconstruction.masks.parts.closer_pieces import is_barred, with_part
from physagent_studio.reconstruction.masks.parts.handles import CLEAR, handle_of
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.records.case import Image

SIDE, ENLARGED = 260, 2.0
"""Longer side in pixels of a mask where its handles are sought, and enlargement at most."""
REACH = 0.75
"""How far around the mask is looked at, in sides of it: its surroundings tell what is usual."""
MOST = 2
"""Handles of one thing."""
WITHIN, BEYOND = -0.4, 3.0
"""Share of its thickness that is no sure part of a handle, and pixels that it may be thicker."""


def with_handles(image: Image, mask: BoolArray, grounding: Grounding) -> BoolArray | None:
    """The mask (H, W) with its thin handles; None without any.

    What holds a click outside, or leaves a box, is none.
    """
    out = mask
    for _ in range(MOST):
        found = _with_handle(image, out)
        if found is None or is_barred(found & ~out, grounding):
            break
        out = found
    return None if out is mask else out


def _with_handle(image: Image, mask: BoolArray) -> BoolArray | None:
    """The mask with its clearest handle, its outline settled by GrabCut; None without one."""
    x0, y0, x1, y1 = bounds(mask)
    side = max(x1 - x0, y1 - y0)
    if side < 24:
        return None
    reach = int(REACH * side) + 4
    window = (
        slice(max(0, y0 - reach), y1 + reach),
        slice(max(0, x0 - reach), x1 + reach),
    )
    factor = min(ENLARGED, SIDE / side)
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    piece = cv2.resize(image[window], None, fx=factor, fy=factor, interpolation=how)
    piece = np.ascontiguousarray(piece, np.uint8)
    size = (piece.shape[1], piece.shape[0])
    large = cv2.resize(mask[window].astype(np.uint8) * 255, size, interpolation=cv2.INTER_AREA)
    own = np.asarray(large > 127)
    handle, clear = handle_of(piece, own, side * factor)
    if clear < CLEAR:
        return None
    thick = float(handle.thick[0])
    core, likely = (handle.drawn(own.shape, wider) for wider in (WITHIN * thick, BEYOND))
    return with_part(mask, window, own, part_of(piece, own, core, likely))
