"""A picture in a frame, boxed, is cut out with its frame; a plain rectangle ends where it ends."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, choose
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.case import Image

BOX = (230, 120, 410, 340)


def hung(rim_px: int, frame: tuple[int, int, int]) -> tuple[Image, BoolArray]:
    """A white sheet with a drawing in a frame of so many pixels on a beige wall, and its mask."""
    x0, y0, x1, y1 = BOX
    photo = np.full((480, 640, 3), (206, 190, 166), np.float64)
    photo[400:] = (110, 74, 50)
    photo[y0:y1, x0:x1] = frame
    photo[y0 + rim_px : y1 - rim_px, x0 + rim_px : x1 - rim_px] = (236, 236, 230)
    cv2.circle(photo, (320, 220), 34, (60, 60, 60), 2)
    photo = cv2.GaussianBlur(photo, (0, 0), 0.8)
    photo += np.random.default_rng(4).normal(0, 2, photo.shape)
    mask = np.zeros(photo.shape[:2], bool)
    mask[y0:y1, x0:x1] = True
    return np.clip(photo, 0, 255).astype(np.uint8), mask


def found(photo: Image, box: tuple[float, float, float, float]) -> BoolArray:
    said = [("picture_frame", Grounding(box=box))]
    offers = EmbeddedSegmenter().segment(photo, said)
    return choose(offers, said, photo.shape[:2], photo)["picture_frame"]


@pytest.mark.parametrize(("rim_px", "frame"), [(9, (190, 166, 134)), (12, (150, 118, 84))])
def test_a_frame_belongs_to_the_picture_in_it(rim_px: int, frame: tuple[int, int, int]) -> None:
    photo, mask = hung(rim_px, frame)
    assert iou(found(photo, (BOX[0] - 1, BOX[1] - 2, BOX[2] + 2, BOX[3] + 1)), mask) > 0.96


def test_what_has_no_frame_gets_none_from_a_box_drawn_too_wide() -> None:
    photo, mask = hung(0, (0, 0, 0))
    wide = (BOX[0] - 12, BOX[1] - 10, BOX[2] + 10, BOX[3] + 14)
    assert iou(found(photo, wide), mask) > 0.96
