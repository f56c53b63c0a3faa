"""What is in focus and what is not, along the outlines of a thing and of what is beside it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.reconstruction.masks.parts.evidence import Patch
from physagent_studio.reconstruction.masks.parts.focus import Focus

THING, BESIDE = (slice(60, 160), slice(60, 130)), (slice(80, 140), slice(130, 190))


def _focus(behind: float, beside: float, size: float = 1.0) -> tuple[Focus, Patch]:
    """A thing and a patch that touches it before a chequered wall; blurred by so many pixels."""
    wall = np.kron(np.indices((10, 12)).sum(0) % 2, np.ones((20, 20)))
    image = np.repeat((110 + 80 * wall)[..., None], 3, axis=2)
    image = cv2.GaussianBlur(image, (0, 0), behind) if behind else image
    share = np.zeros(image.shape[:2])
    share[BESIDE] = 1.0
    share = cv2.GaussianBlur(share, (0, 0), beside) if beside else share
    image = image * (1 - share[..., None]) + share[..., None] * (60, 90, 40)
    image[THING] = (220, 60, 40)
    mask, region = np.zeros(share.shape, bool), np.zeros(share.shape, bool)
    mask[THING] = region[BESIDE] = True
    crop = cv2.resize(image, None, fx=size, fy=size, interpolation=cv2.INTER_CUBIC)
    rows, columns = np.nonzero(region)
    patch = Patch.at(rows, columns, region.shape)
    return Focus(np.clip(crop, 0, 255).astype(np.uint8), mask), patch


@pytest.mark.parametrize(
    ("behind", "beside", "lost", "stands_out"),
    [(0.0, 0.0, False, False), (5.0, 0.0, False, True), (5.0, 5.0, True, False)],
)
@pytest.mark.parametrize("size", [1.0, 2.0])
def test_sharp_before_blurred_stands_out_and_blurred_is_lost(
    behind: float, beside: float, lost: bool, stands_out: bool, size: float
) -> None:
    """Also where the picture is larger than the size at which parts are sought."""
    focus, patch = _focus(behind, beside, size)
    assert focus.is_lost(patch) == lost
    assert focus.stands_out(patch) == stands_out


def test_nothing_is_said_of_outlines_without_edges() -> None:
    focus, patch = _focus(0.0, 0.0)
    plain = Focus(np.full_like(focus.crop, 128), focus.mask)
    assert not plain.is_lost(patch)
    assert not plain.stands_out(patch)
