"""The top of what carries something, where that hides it: from one side of it to the other."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.reconstruction.switches import at_work


def with_hidden_tops(masks: Mapping[str, BoolArray], on: Mapping[str, str]) -> dict[str, BoolArray]:
    """The masks (H, W), those of carriers with what is hidden of their tops.

    on: what each thing stands on. Where a seat shows on both sides of the box on it, it goes on
    behind the box: no dip in it is as wide as the box.
    """
    out = dict(masks)
    if not at_work("hidden tops"):
        return out
    for name, carrier in on.items():
        if name in masks and carrier in masks:
            out[carrier] = out[carrier] | _hidden(masks[carrier], masks[name])
    return out


def _hidden(below: BoolArray, above: BoolArray) -> BoolArray:
    """(H, W) of the pixels of what stands there, and of a narrow gap below it that is in no mask,
    those that lie below the line between the tops of the carrier on both sides of it, and above
    what is seen of the carrier."""
    side_ratio = 0.12  # 0.03..0.4: over the width of what stands there: how much is seen beside it
    gap_ratio = 0.1  # 0.02..0.2: over that width: higher gaps are open, between legs
    none = np.zeros_like(below)
    x0, y0, x1, y1 = bounds(above)
    reach = max(3, round(side_ratio * (x1 - x0)))
    tops = np.where(below.any(0), below.argmax(0), below.shape[0])
    left, right = tops[max(0, x0 - reach) : x0], tops[x1 : x1 + reach]
    if len(left) < reach or len(right) < reach:
        return none
    ends = [int(np.median(side)) for side in (left, right)]
    # What stands in front of a carrier, or beside its foot, hides no top of it.
    if not all(y0 < end < y1 for end in ends):
        return none
    columns = np.arange(x0, x1)
    line = np.interp(columns, (x0 - 1, x1), ends)
    rows = np.arange(below.shape[0])[:, None]
    part = (rows >= line) & (rows < tops[x0:x1])
    own = above[:, x0:x1]
    foot = np.where(own.any(0), below.shape[0] - own[::-1].argmax(0), below.shape[0])
    narrow = tops[x0:x1] - foot <= max(3, round(gap_ratio * (x1 - x0)))
    none[:, x0:x1] = part & (own | ((rows >= foot) & narrow))
    return none
