"""Small things that stick out of the outlines of masks: twigs, leaves, flaps, dark seams.

They differ from the ground that lies all around them, hang on to the thing, and end close by.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.background.harmonic_fill import from_steps
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.records.case import Image

FloatImage = NDArray[np.float32]
SIDE = 180
"""Longer side of the picture around a thing in which they are looked for."""
REACH = 0.16
"""How far they stick out at most, as a share of the thing's larger extent."""
STRANGE = 11.0
"""How far their colour is from that of the ground at least, in L*a*b*."""
GRAINS = 5.0
"""The same in units of how uneven the ground is there."""
ALSO = 0.12
"""How much ground of its colour may lie around a thing that sticks out, in its own area."""
SAME = 0.3
"""Share of the thing beside it that is of its colour where it is surely a part of the thing."""
LARGEST = 0.06
"""Their area at most, as a share of the thing's."""


def islands(photo: Image, masks: Sequence[BoolArray], hole: BoolArray) -> BoolArray:
    """(H, W) pixels beside the hole (H, W) that stick out of the masked things."""
    out = np.zeros(hole.shape, bool)
    for mask in masks:
        if not mask.any():
            continue
        x0, y0, x1, y1 = bounds(mask)
        margin = round(2.2 * REACH * max(x1 - x0, y1 - y0)) + 12
        rows = slice(max(0, y0 - margin), y1 + margin)
        window = rows, slice(max(0, x0 - margin), x1 + margin)
        found = _beside(photo[window], mask[window], hole[window])
        out[window] |= found
    return out & ~hole


def _beside(photo: Image, mask: BoolArray, hole: BoolArray) -> BoolArray:
    factor = min(1.0, SIDE / max(hole.shape))
    size = (max(8, round(hole.shape[1] * factor)), max(8, round(hole.shape[0] * factor)))
    small = cv2.resize(photo, size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    lab = np.asarray(cv2.cvtColor(small, cv2.COLOR_RGB2LAB), np.float32)
    taken = cv2.resize(hole.astype(np.uint8), size, interpolation=cv2.INTER_AREA) > 0
    own = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    if not own.any():
        return np.zeros_like(hole)
    x0, y0, x1, y1 = bounds(own)
    reach = max(4, round(REACH * max(x1 - x0, y1 - y0)))
    mine = taken & grow(own, reach)
    wide = taken | grow(own, reach + 4)
    ring = wide & ~taken
    if wide.all() or not ring.any():
        return np.zeros_like(hole)
    ground = from_steps(lab, wide)
    off = np.linalg.norm(lab - ground, axis=-1)
    strange = ring & (off > max(STRANGE, GRAINS * float(np.median(off[ring]))))
    # Their own soft rim belongs to them.
    count, labels, stats, _ = cv2.connectedComponentsWithStats(strange.astype(np.uint8))
    rim = strange & ~grow(own, reach)
    beyond = set(np.unique(labels[rim]).tolist()) | {0}
    touching = np.unique(labels[grow(mine, 2) & strange]).tolist()
    most = LARGEST * np.count_nonzero(own)
    free = ~taken & ~strange
    kept = [
        k
        for k in touching
        if k not in beyond
        and stats[k, cv2.CC_STAT_AREA] <= most
        and not _usual(lab, labels == k, free, own, reach)
    ]
    found = grow(np.isin(labels, kept), 1) if count > 1 and kept else np.zeros_like(taken)
    whole = cv2.resize(found.astype(np.float32), hole.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.asarray(whole > 0.4)


def _usual(lab: FloatImage, part: BoolArray, free: BoolArray, own: BoolArray, reach: int) -> bool:
    """Whether the ground around is of a part's colour too, so that the part is of the ground.

    own: (H, W) the thing. Where it is of that colour beside the part, as foliage is before the
    sky, only the ground close by tells.
    """
    colour = np.median(lab[part], axis=0)
    joined = own & grow(part, max(3, reach // 3))
    same = np.linalg.norm(lab[joined] - colour, axis=-1) < STRANGE
    surely = same.any() and same.mean() > SAME
    around = free & grow(part, reach // 3 if surely else 2 * reach)
    like = np.linalg.norm(lab[around] - colour, axis=-1) < STRANGE
    return bool(np.count_nonzero(like) > max(2, ALSO * np.count_nonzero(part)))
