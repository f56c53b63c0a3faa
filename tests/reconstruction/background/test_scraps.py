"""Small bits that a mask has missed leave with its thing; what goes on behind it stays."""

import cv2
import numpy as np

from physagent_studio.reconstruction.background.leftovers import scraps
from physagent_studio.reconstruction.background.mosaic import mosaic
from physagent_studio.reconstruction.background.plate import background, hole_of
from physagent_studio.reconstruction.background.structure import Structure

SHAPE = (200, 260)


def wall(grain: float = 1.5) -> np.ndarray:
    """(H, W, 3) a grey wall."""
    noise = np.random.default_rng(3).normal(0, grain, (*SHAPE, 3))
    return (np.full((*SHAPE, 3), 190.0) + noise).clip(0, 255).astype(np.uint8)


def with_fruit(picture: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A round orange before it, and its mask."""
    mask = cv2.circle(np.zeros(SHAPE, np.uint8), (130, 110), 40, 1, -1).astype(bool)
    out = picture.copy()
    out[mask] = (220, 120, 30)
    return out, mask


def test_the_tip_of_a_stem_leaves_with_the_fruit():
    photo, mask = with_fruit(wall())
    tip = np.zeros(SHAPE, bool)
    tip[63:68, 129:133] = True
    photo[tip] = (90, 70, 40)
    found = scraps(photo, [mask], hole_of([mask], SHAPE))
    assert (found & tip).sum() > 0.6 * tip.sum()
    wide = cv2.dilate(tip.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
    assert not (found & ~wide).any()
    plate = background(photo, [mask])
    assert np.abs(plate[tip].astype(float) - 190).mean() < 8


def test_what_goes_on_or_is_one_of_many_is_no_scrap():
    photo, mask = with_fruit(wall())
    photo[60:63, :] = np.where(mask[60:63, :, None], photo[60:63], 90)
    assert not scraps(photo, [mask], hole_of([mask], SHAPE)).any()
    rough, mask = with_fruit(wall(30.0))
    assert not scraps(rough, [mask], hole_of([mask], SHAPE)).any()


def test_a_face_is_filled_from_the_same_face():
    """Two floors of nearly one colour, one with marks on it: none of them gets onto the other."""
    rows, columns = np.indices(SHAPE)
    faces = (rows >= 100).astype(np.int64)
    picture = np.where((rows < 100)[..., None], 150.0, 158.0) * np.ones((*SHAPE, 3))
    picture[(rows < 100) & (columns % 20 < 3) & (rows % 20 < 3)] = 60.0
    hole = np.zeros(SHAPE, bool)
    hole[70:150, 90:170] = True
    picture += np.random.default_rng(0).normal(0, 2, picture.shape)
    seen = picture.astype(np.float32)
    filled = mosaic(seen, hole, hole, Structure(np.zeros((0, 2, 2))), None, 1.0, faces)
    assert filled[(rows >= 104) & hole].min() > 120
