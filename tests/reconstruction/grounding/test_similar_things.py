"""Unmarked things like a marked one are found, and said where the fill goes over them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.reconstruction.grounding.similar_things import covered, similar

TABLE, CREAM, RED = (60, 120, 110), (220, 205, 150), (190, 40, 40)
PLACES = ((60, 80), (120, 82), (180, 84))
SIZE = (30, 60)


def picture() -> np.ndarray:
    """Three dominoes and a ball on a table, with a little noise."""
    image = np.full((200, 320, 3), TABLE, np.uint8)
    for x, y in PLACES:
        cv2.rectangle(image, (x, y), (x + SIZE[0] - 1, y + SIZE[1] - 1), CREAM, -1)
        cv2.circle(image, (x + 15, y + 15), 4, (20, 20, 20), -1)
    cv2.circle(image, (260, 110), 25, RED, -1)
    noise = np.random.default_rng(0).normal(0, 3, image.shape)
    return np.clip(image + noise, 0, 255).astype(np.uint8)


def mask_of(at: int) -> np.ndarray:
    mask = np.zeros((200, 320), bool)
    x, y = PLACES[at]
    mask[y : y + SIZE[1], x : x + SIZE[0]] = True
    return mask


def test_like_things_are_found_nearest_first() -> None:
    found = similar(picture(), "domino", {"domino": mask_of(0)})
    assert [box[0] for box in found] == pytest.approx([120, 180], abs=3)
    for box, (x, y) in zip(found, PLACES[1:], strict=True):
        assert box == pytest.approx((x, y, x + SIZE[0], y + SIZE[1]), abs=3)
    # What is marked already is not found again.
    both = {"domino": mask_of(0), "domino_2": mask_of(1)}
    assert len(similar(picture(), "domino", both)) == 1


def test_like_things_as_light_as_the_ground_are_found_by_their_hue() -> None:
    image = picture()
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    # A table of another hue that is as light as the dominoes.
    image[np.abs(image.astype(int) - TABLE).max(axis=-1) < 20] = (180, 200, 235)
    assert abs(float(np.mean(grey[mask_of(0)])) - 200) < 15
    found = similar(image, "domino", {"domino": mask_of(0)})
    assert [box[0] for box in found] == pytest.approx([120, 180], abs=3)


def test_it_is_said_where_the_fill_goes_over_one() -> None:
    image = picture()
    plate = image.copy()
    plate[mask_of(0)] = TABLE
    assert covered(image, plate, {"domino": mask_of(0)}) == {}
    x, y = PLACES[1]
    plate[y : y + 20, x : x + SIZE[0]] = TABLE
    told = covered(image, plate, {"domino": mask_of(0)})
    assert [box[0] for box in told["domino"]] == pytest.approx([x], abs=3)
