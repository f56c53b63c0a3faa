"""Masks widened and narrowed by much are as a disc would make them."""

import cv2
import numpy as np
import pytest

from physagent_studio.reconstruction.photo.regions import disc, grow, iou, shrink


@pytest.mark.parametrize("radius", [17, 40, 75])
def test_by_distances_as_by_a_disc(radius: int) -> None:
    mask = np.zeros((400, 500), np.uint8)
    cv2.ellipse(mask, (180, 210), (150, 120), 20, 0, 360, 1, -1)
    cv2.rectangle(mask, (300, 0), (420, 200), 1, -1)
    seen = mask.astype(bool)
    assert iou(grow(seen, radius), cv2.dilate(mask, disc(radius)).astype(bool)) > 0.998
    assert iou(shrink(seen, radius), cv2.erode(mask, disc(radius)).astype(bool)) > 0.98


def test_nothing_and_everything_stay_as_they_are() -> None:
    nothing = np.zeros((50, 60), bool)
    assert not grow(nothing, 30).any()
    assert shrink(~nothing, 30).all()
