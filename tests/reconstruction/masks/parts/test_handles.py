"""Thin handles on things, before surroundings of their own pattern."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.parts.joined_handles import with_handles
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter
from physagent_studio.reconstruction.masks.task import looks_for_handles
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.case import Image

SIZE = (320, 260)
NOTHING = Grounding()


def _street(seed: int) -> Image:
    """Grainy asphalt with a paler kerb across it."""
    rng = np.random.default_rng(seed)
    grey = 150 + cv2.GaussianBlur(rng.normal(0, 1, (SIZE[1], SIZE[0])), (0, 0), 1.2) * 25
    grey[60:72] += 35
    return (grey[..., None] * (1.0, 0.98, 0.93)).clip(0, 255).astype(np.uint8)


def _bin(image: Image) -> BoolArray:
    """A blue-grey bin, drawn; its mask."""
    mask = np.zeros(image.shape[:2], np.uint8)
    cv2.fillPoly(mask, [np.array([(105, 90), (215, 90), (200, 230), (120, 230)])], 1)
    body = mask.astype(bool)
    columns = np.nonzero(body)[1]
    image[body] = np.stack([80 + columns % 9 * 4, 95 + columns % 9 * 4, 115 + columns % 9 * 4], 1)
    return body


def _arch(image: Image, at: tuple[int, int], half: int, high: int, thick: int = 4) -> BoolArray:
    """A bent rod with both feet at one level, drawn; where it is."""
    x, y = at
    turn = np.linspace(np.pi, 2 * np.pi, 80)
    power = 0.6
    line = np.stack(
        [
            x + half * np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** power,
            y - high * np.abs(np.sin(turn)) ** power,
        ],
        1,
    )
    drawn = np.zeros(image.shape[:2], np.uint8)
    cv2.polylines(drawn, [np.rint(line * 16).astype(np.int32)], False, 1, thick, shift=4)
    rows = np.nonzero(drawn)[0]
    image[drawn.astype(bool)] = np.stack([70 + (rows % 3) * 30] * 2 + [95 + (rows % 3) * 30], 1)
    return drawn.astype(bool)


@pytest.mark.parametrize(("seed", "half", "high"), [(0, 16, 14), (1, 24, 20), (2, 50, 45)])
def test_an_arch_on_a_lid_joins_and_stays_open(seed: int, half: int, high: int) -> None:
    image = _street(seed)
    arch = _arch(image, (165, 92), half, high)
    body = _bin(image)
    found = with_handles(image, body, NOTHING)
    assert found is not None
    assert iou(found & ~body, arch & ~body) > 0.6
    assert not found[92 - high // 2, 165]


@pytest.mark.parametrize("seed", range(4))
def test_a_thing_without_a_handle_gets_none(seed: int) -> None:
    image = _street(seed)
    body = _bin(image)
    assert with_handles(image, body, NOTHING) is None


def test_a_disc_behind_a_thing_is_no_handle() -> None:
    image = _street(0)
    cv2.circle(image, (165, 90), 22, (60, 60, 90), -1)
    body = _bin(image)
    assert with_handles(image, body, NOTHING) is None


def test_a_click_outside_says_that_it_is_none() -> None:
    image = _street(1)
    _arch(image, (165, 92), 24, 20)
    body = _bin(image)
    click = Grounding(points=(Click(x=165, y=72, label=0),))
    assert with_handles(image, body, click) is None


def test_names_of_things_with_handles() -> None:
    assert looks_for_handles("the trash can")
    assert looks_for_handles("red bucket")
    assert not looks_for_handles("soccer ball")


def test_masks_without_thin_parts_are_told_while_these_are_looked_for() -> None:
    image = _street(1)
    _bin(image)
    click = Grounding(points=(Click(x=160, y=150, label=1),))
    told: dict[str, list[BoolArray]] = {"bin": [], "block": []}
    found = {
        name: EmbeddedSegmenter().candidates(
            image, name, click, lambda name, offers: told[name].append(offers()[0].mask)
        )
        for name in told
    }
    assert len(told["bin"]) == len(told["block"]) + 1
    assert iou(told["bin"][-1], found["bin"][0].mask) > 0.95
