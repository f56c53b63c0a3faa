"""To which of two things a pixel belongs that both of their masks cover."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from physagent_studio.reconstruction.masks.ranking import Box
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.switches import at_work

_NONE: Mapping[str, BoolArray] = {}
_NO_BOXES: Mapping[str, Box] = {}


@dataclass(frozen=True, slots=True)
class CompetitionSettings:
    """When a thing takes what a smaller one claims."""

    # share, 0..0.2: of its width, by which the box of what stands on another may reach beyond that
    beyond_share: float = 0.05


COMPETITION = CompetitionSettings()


def compete(
    masks: Mapping[str, BoolArray],
    owned: Mapping[str, BoolArray] = _NONE,
    boxes: Mapping[str, Box] = _NO_BOXES,
) -> dict[str, BoolArray]:
    """Every pixel belongs to one object: where masks (H, W) overlap, the smaller one keeps it,
    unless boxes around them say that the larger one stands on it: a cup hides some of its saucer.

    owned: pixels that a person gave to an object; no other takes them. boxes: drawn around things.
    """
    claims = dict(masks)
    for name, mask in masks.items():
        for other, own in owned.items():
            if other != name:
                mask = mask & ~(own & ~owned.get(name, np.zeros_like(own)))
        claims[name] = mask
    order = sorted(masks, key=lambda name: int(np.count_nonzero(masks[name])))
    out: dict[str, BoolArray] = {}
    for name in masks:
        left = claims[name]
        for other in order:
            small, large = sorted((name, other), key=order.index)
            if other != name and _yields(name, small, large, claims, boxes):
                left = left & ~claims[other]
        out[name] = left
    return out


def _yields(
    name: str, small: str, large: str, masks: Mapping[str, BoolArray], boxes: Mapping[str, Box]
) -> bool:
    """Whether of two things the one of that name gives up what both cover."""
    if not (masks[small] & masks[large]).any():
        return False
    boxed = small in boxes and large in boxes and at_work("upon another")
    upon = boxed and _stands_on(boxes[large], boxes[small])
    return name == (small if upon else large)


def _stands_on(upper: Box, lower: Box) -> bool:
    """Whether a thing stands on or in another, by boxes drawn around them: its foot is seen within
    the other, and hides what is behind it of that."""
    spare = COMPETITION.beyond_share * (upper[2] - upper[0])
    within = lower[0] - spare <= upper[0] and upper[2] <= lower[2] + spare
    return within and upper[1] < lower[1] < upper[3] < lower[3]
