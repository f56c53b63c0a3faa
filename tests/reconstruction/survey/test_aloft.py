"""What is seen against a wall does not stand on the floor before it."""

import numpy as np

from physagent_studio.reconstruction.supports.stances import read
from physagent_studio.reconstruction.survey.aloft import before_no_ground


def _scene(wall, floor, stripe=None):
    """A disc over another one, between them the line where `wall` ends and `floor` begins."""
    y, x = np.indices((240, 320))
    image = np.where(y[..., None] < 120, wall, floor).astype(float)
    if stripe is not None:
        image[118:124] = stripe
    image += np.random.default_rng(5).normal(0, 2, image.shape)
    masks = {
        "upper": np.hypot(x - 160, y - 60) < 20,
        "lower": np.hypot(x - 165, y - 180) < 30,
    }
    image[masks["upper"] | masks["lower"]] = (200, 40, 40)
    covered = masks["upper"] | masks["lower"]
    return np.clip(image, 0, 255).astype(np.uint8), read(masks), covered


def test_a_wall_behind_it_says_that_it_is_in_the_air():
    assert before_no_ground(*_scene((190, 190, 195), (150, 120, 90))) == {"upper"}


def test_a_stripe_on_the_ground_and_plain_ground_say_nothing():
    ground = (150, 150, 140)
    assert before_no_ground(*_scene(ground, ground, (240, 240, 240))) == set()
    assert before_no_ground(*_scene(ground, ground)) == set()


def test_without_another_below_nothing_is_said():
    image, stances, covered = _scene((190, 190, 195), (150, 120, 90))
    assert before_no_ground(image, {"upper": stances["upper"]}, covered) == set()
