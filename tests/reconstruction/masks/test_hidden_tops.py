"""What carries something goes on behind it, from one side of it to the other."""

from __future__ import annotations

import numpy as np

from physagent_studio.reconstruction.masks.hidden_tops import with_hidden_tops

ROWS, COLUMNS = np.indices((100, 120))


def _block(x0: int, x1: int, y0: int, y1: int) -> np.ndarray:
    return (x0 <= COLUMNS) & (x1 > COLUMNS) & (y0 <= ROWS) & (y1 > ROWS)


def test_a_seat_goes_on_behind_the_box_on_it():
    seat, box = _block(20, 100, 50, 70), _block(40, 80, 20, 58)
    masks = with_hidden_tops({"stool": seat & ~box, "box": box}, {"box": "stool"})
    assert np.array_equal(masks["stool"], seat)
    assert np.array_equal(masks["box"], box)


def test_a_narrow_gap_that_is_in_no_mask_is_of_the_seat():
    seat, box = _block(20, 100, 50, 70), _block(40, 80, 20, 58)
    slit, below_legs = _block(40, 80, 58, 61), _block(40, 80, 58, 68)
    for gap, whole in ((slit, True), (below_legs, False)):
        masks = {"stool": seat & ~box & ~gap, "box": box}
        found = with_hidden_tops(masks, {"box": "stool"})["stool"]
        assert np.array_equal(found, seat if whole else seat & ~gap)


def test_what_is_as_wide_as_its_carrier_hides_nothing_that_is_known():
    lower, upper = _block(40, 80, 50, 90), _block(38, 82, 20, 50)
    masks = with_hidden_tops({"lower": lower, "upper": upper}, {"upper": "lower"})
    assert np.array_equal(masks["lower"], lower)


def test_what_stands_elsewhere_changes_nothing():
    seat, box = _block(20, 100, 50, 70), _block(40, 80, 20, 58)
    masks = {"stool": seat & ~box, "box": box}
    out = with_hidden_tops(masks, {"box": "floor", "stool": "floor"})
    assert all(np.array_equal(out[name], masks[name]) for name in masks)
