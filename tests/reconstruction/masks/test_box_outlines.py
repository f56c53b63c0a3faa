"""What light has washed out of a box's mask comes back from its other side, and only that."""

from __future__ import annotations

import cv2
import numpy as np

from physagent_studio.reconstruction.masks.box_outlines import as_box
from physagent_studio.reconstruction.photo.regions import BoolArray, iou

NONE = np.zeros((240, 320), bool)
CORNERS = ((120, 60), (170, 50), (200, 64), (200, 180), (150, 190), (120, 176))
"""Of a block that is seen from above and from its side, pixels."""


def _drawn(corners: tuple[tuple[int, int], ...]) -> BoolArray:
    return cv2.fillPoly(NONE.astype(np.uint8), [np.array(corners)], 1).astype(bool)


def _washed_out() -> BoolArray:
    mask = _drawn(CORNERS)
    mask[:115, :185] = False
    return mask


def test_a_side_that_is_lost_comes_back() -> None:
    block, seen = _drawn(CORNERS), _washed_out()
    assert iou(seen, block) < 0.7
    assert iou(as_box(seen, NONE), block) > 0.93


def test_what_another_thing_may_hide_is_not_filled() -> None:
    other = NONE.copy()
    other[70:100, 130:160] = True
    seen = _washed_out()
    assert as_box(seen, other) is seen


def test_a_whole_block_and_what_is_none_stay() -> None:
    bent = _drawn(((100, 60), (130, 60), (130, 160), (220, 160), (220, 190), (100, 190)))
    for mask in (_drawn(CORNERS), bent, NONE):
        assert as_box(mask, NONE) is mask
