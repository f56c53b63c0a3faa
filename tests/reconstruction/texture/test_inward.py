"""What hidden sides show: neither the rim of a thing nor what is on it once."""

import cv2
import numpy as np

from physagent_studio.reconstruction.texture.inward import calmed, led_inward, without_features


def test_the_rim_shows_what_lies_inside_of_it():
    y, x = np.indices((90, 90))
    away = np.hypot(x - 45, y - 45)
    picture = np.where((away < 36)[..., None], (200, 40, 40), (30, 150, 40)).astype(np.uint8)
    led = led_inward(picture, away < 38, 0.06)
    assert (led[away < 44][:, 0] > 180).all()


def test_a_face_is_there_once_and_stripes_stay():
    y, x = np.indices((120, 120))
    own = np.hypot(x - 60, y - 60) < 50
    plain = np.full((120, 120, 3), (200, 150, 60), np.uint8)
    face = plain.copy()
    for spot in ((45, 50), (75, 50), (60, 70)):
        cv2.circle(face, spot, 5, (20, 20, 20), -1)
    assert np.abs(without_features(face, own)[own].astype(int) - plain[own]).max() < 12
    striped = np.where((x // 8 % 2 == 0)[..., None], (20, 60, 180), plain).astype(np.uint8)
    assert (without_features(striped, own) == striped).all()


def test_along_its_outline_a_thing_is_even_and_within_as_it_was():
    y, x = np.indices((120, 120))
    away = np.hypot(x - 60, y - 60)
    striped = np.where((y // 3 % 2 == 0)[..., None], 60, 200) * np.ones((120, 120, 3))
    calm = calmed(striped.astype(np.uint8), away < 50).astype(float)
    rim, middle = (away < 50) & (away > 48), away < 40
    assert calm[rim].std() < 0.6 * striped[rim].std()
    assert (calm[middle] == striped[middle]).all()
