"""Thin parts found beside a mask on a piece of the picture: put in their place, or barred."""

from __future__ import annotations

import cv2
import numpy as np

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, resized


def with_part(
    mask: BoolArray, window: tuple[slice, slice], own: BoolArray, new: BoolArray
) -> BoolArray:
    """The mask (H, W) with a part found on a window of the picture at another size.

    own, new: (h, w) the mask and the part there.
    """
    out = mask.copy()
    # A pixel of the mask around keeps the part from coming loose when it is brought to size.
    joint = new | (own & cv2.dilate(new.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool))
    out[window] |= resized(joint, (mask[window].shape[1], mask[window].shape[0]))
    return out


def is_barred(new: BoolArray, grounding: Grounding) -> bool:
    """Whether a part (H, W) holds a click outside or leaves the box."""
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
