"""Shafts between two straight edges, and which parts prolong the mask they touch."""

import cv2
import numpy as np
import pytest

from physagent_studio.reconstruction.masks.parts.attached import with_attached
from physagent_studio.reconstruction.masks.parts.evidence import Patch
from physagent_studio.reconstruction.masks.parts.shafts import (
    Strips,
    edges_of,
    runs_on,
    shafts_beside,
    strips_of,
)
from physagent_studio.reconstruction.photo.regions import iou
from tests.reconstruction.masks.parts.test_attached import (
    NOTHING,
    _line,
    _painted,
    _polygon,
    _scene,
)

DECK = _polygon((110, 226), (290, 226), (290, 250), (110, 250))
POLE = _line((278, 230), (250, 90), 9)


def _tube(image: np.ndarray) -> None:
    """A round metal pole: dark on one side, light on the other, with a collar."""
    _painted(image, POLE, (58, 74, 120))
    _painted(image, POLE & np.roll(POLE, 4, 1), (122, 150, 214))
    _painted(image, POLE & _line((0, 172), (399, 172), 5), (40, 44, 60))


def _lab(image: np.ndarray) -> np.ndarray:
    picture = np.clip(image, 0, 255).astype(np.uint8)
    return cv2.cvtColor(picture, cv2.COLOR_RGB2LAB).astype(np.float32)


def _strips(image: np.ndarray) -> Strips:
    return strips_of(edges_of(_lab(image)), 30.0)


def _found(image: np.ndarray, mask: np.ndarray, name: str = "") -> np.ndarray:
    picture = np.clip(image, 0, 255).astype(np.uint8)
    found = with_attached(picture, mask, NOTHING, name)
    return mask if found is None else found


def test_a_pole_that_changes_its_shine_on_the_way_is_one_shaft() -> None:
    image = 0.75 * _scene()
    _tube(image)
    shafts = shafts_beside(_strips(image), DECK, np.zeros_like(DECK))
    # Up to its collar; what is above it goes on from there.
    lower = POLE & ~DECK & (np.arange(len(POLE)) > 174)[:, None]
    assert max(iou(shaft.region, lower) for shaft in shafts) > 0.7


def test_a_pole_of_tint_alone_is_one_shaft() -> None:
    """As light as what is behind it: only its tint tells it from the ground."""
    image = _scene(grain=1.0)
    grey = np.zeros((1, 1, 3), np.uint8)
    grey[0, 0] = round(float(_lab(image)[200:, :, 0].mean())), 128, 104
    blue = cv2.cvtColor(grey, cv2.COLOR_LAB2RGB)[0, 0]
    image[:] = (150, 128, 104)
    image[POLE] = blue
    shafts = list(shafts_beside(_strips(image), DECK, np.zeros_like(DECK)))
    assert max(iou(shaft.region, POLE & ~DECK) for shaft in shafts) > 0.7


def test_a_thing_made_of_poles_takes_the_pole_and_not_the_kerb_behind_it() -> None:
    image = _scene()
    image[150:170] = (176, 172, 166)
    _tube(image)
    _painted(image, DECK, (214, 60, 50))
    found = _found(image, DECK, name="scooter")
    assert found[POLE].mean() > 0.8
    assert (found & ~(DECK | POLE)).sum() < 0.3 * POLE.sum()


@pytest.mark.parametrize("name", ["", "scooter"])
def test_what_passes_behind_does_not_join(name: str) -> None:
    body = _polygon((190, 70), (212, 70), (212, 262), (190, 262))
    image = _scene()
    for x, shade in ((0, 0.9), (110, 1.0), (240, 1.1)):
        piece = _line((0, 155), (399, 124), 14)
        piece[:, :x] = piece[:, x + 125 :] = False
        _painted(image, piece, (int(150 * shade), int(116 * shade), int(80 * shade)))
    _painted(image, body, (190, 40, 48))
    found = _found(image, body, name)
    assert iou(found, body) > 0.95


def test_a_head_above_a_stripe_prolongs_the_body() -> None:
    """Nothing of its own tells that it is one; it joins once the stripe between them has."""
    body = _polygon((186, 176), (214, 176), (232, 214), (226, 264), (174, 264), (168, 214))
    stripe = _polygon((187, 160), (213, 160), (214, 176), (186, 176))
    head = _polygon((187, 160), (180, 132), (188, 112), (212, 112), (220, 132), (213, 160))
    image = 0.7 * _scene()
    _painted(image, body, (236, 232, 222))
    _painted(image, head, (232, 228, 218))
    _painted(image, stripe, (206, 44, 40))
    found = _found(image, body)
    assert found[head].mean() > 0.8
    assert iou(found, body | stripe | head) > 0.92


def test_what_prolongs_runs_on_and_what_is_behind_meets_at_corners() -> None:
    body = _polygon((160, 150), (240, 150), (240, 262), (160, 262))
    for left, right, runs in ((160, 240, True), (190, 210, False)):
        above = _polygon((left, 100), (right, 100), (right, 149), (left, 149))
        rows, columns = np.nonzero(above)
        assert runs_on(Patch.at(rows, columns, body.shape), body) == runs


def test_what_reaches_the_rim_or_is_barred_is_no_shaft() -> None:
    image = _scene()
    _painted(image, _line((200, 0), (200, 230), 10), (30, 30, 36))
    strips = _strips(image)
    assert not any(s.region[:60].any() for s in shafts_beside(strips, DECK, np.zeros_like(DECK)))
    image = _scene()
    _painted(image, POLE, (30, 30, 36))
    barred = np.zeros_like(DECK)
    barred[150:160, 255:270] = True
    shafts = shafts_beside(_strips(image), DECK, barred)
    assert not any((shaft.region & barred).any() for shaft in shafts)


@pytest.mark.parametrize(("name", "least", "most"), [("", 0.0, 0.1), ("lamp", 0.85, 1.0)])
def test_a_stem_is_followed_beyond_what_is_around_the_body(
    name: str, least: float, most: float
) -> None:
    """Grey as the floor it leads to; that things of the name have a stem makes it one."""
    body = _polygon((180, 40), (220, 40), (220, 80), (180, 80))
    stem = _polygon((196, 81), (204, 81), (204, 230), (196, 230))
    image = _scene(grain=2.0)
    _painted(image, stem, (126, 118, 112))
    _painted(image, body, (206, 44, 40))
    found = _found(image, body, name)
    assert least <= found[stem & ~body].mean() <= most
