"""Ground between wheels leaves a mask; panels and colours that the thing has itself do not."""

import numpy as np

from physagent_studio.reconstruction.masks.ground_spill import without_ground


def _picture() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A red body on two black wheels over grey, sandy ground, the thing's mask, and the gap."""
    noise = np.random.default_rng(1).normal(0, 6, (200, 300, 1))
    photo = np.full((200, 300, 3), (150, 145, 140)) + noise
    thing = np.zeros((200, 300), bool)
    thing[60:130, 70:230] = True
    photo[60:130, 70:230] = (200, 30, 30)
    photo[70:90, 100:200] = (15, 15, 15)
    wheels = np.zeros_like(thing)
    wheels[125:150, 85:110] = True
    wheels[125:150, 190:215] = True
    photo[wheels] = (15, 15, 15)
    gap = np.zeros_like(thing)
    gap[130:148, 110:190] = True
    return np.clip(photo, 0, 255).astype(np.uint8), thing | wheels, gap


def test_the_ground_between_two_wheels_is_taken_off_and_the_wheels_stay():
    photo, thing, gap = _picture()
    found = without_ground(photo, thing | gap, np.zeros_like(thing))
    assert found[gap].mean() < 0.1
    assert found[thing].mean() > 0.97


def test_a_mask_that_has_no_ground_stays_as_it_is():
    photo, thing, _ = _picture()
    assert without_ground(photo, thing, np.zeros_like(thing)) is thing


def test_a_dark_foot_in_a_colour_of_the_thing_stays():
    photo, thing, gap = _picture()
    photo[gap] = (15, 15, 15)
    whole = thing | gap
    assert without_ground(photo, whole, np.zeros_like(thing))[gap].mean() > 0.95
