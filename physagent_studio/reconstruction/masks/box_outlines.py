"""A box's mask has the outline of a box: what light has washed out of it comes back.

From afar the outline of a box is the same turned by half about its middle: what is missing of one
side is seen on the other.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, solidity


@dataclass(frozen=True, slots=True)
class SymmetrySettings:
    """When a mask has lost a part that the other side shows."""

    min_lost_share: float = 0.1  # 0.02..0.3: of the mask: less is its rough rim
    max_lost_share: float = 1.0  # 0.3..2: of the mask: more than is seen is nobody's guess
    min_solidity: float = 0.94  # share, 0.8..1: of the completed mask, as boxes are convex
    max_solidity: float = 0.93  # share, 0.7..1: of a mask: from there on it has lost nothing
    rim_ratio: float = 0.04  # 0.01..0.2: of √area: strips as narrow are no loss


SYMMETRY = SymmetrySettings()


def as_box(mask: BoolArray, others: BoolArray) -> BoolArray:
    """The mask (H, W) of a box with what it lost, where with it it has the outline of one.

    others: (H, W) of other things: what they may hide is not known to be lost.
    """
    area = np.count_nonzero(mask)
    if not area or solidity(mask) > SYMMETRY.max_solidity:
        return mask
    lost = _wide(_turned(mask) & ~mask, SYMMETRY.rim_ratio * float(np.sqrt(area)))
    share = np.count_nonzero(lost) / area
    if not SYMMETRY.min_lost_share < share < SYMMETRY.max_lost_share or (lost & others).any():
        return mask
    whole = mask | lost
    return whole if solidity(whole) > SYMMETRY.min_solidity else mask


def _turned(mask: BoolArray) -> BoolArray:
    """The mask turned by half about the middle of its bounds."""
    x0, y0, x1, y1 = bounds(mask)
    out = np.zeros_like(mask)
    out[y0:y1, x0:x1] = mask[y0:y1, x0:x1][::-1, ::-1]
    return out


def _wide(area: BoolArray, narrow: float) -> BoolArray:
    """(H, W) what is wider than a strip of so many pixels, with its rim."""
    side = max(3, round(narrow) | 1)
    core = cv2.morphologyEx(area.astype(np.uint8), cv2.MORPH_OPEN, np.ones((side, side), np.uint8))
    return grow(core > 0, side) & area
