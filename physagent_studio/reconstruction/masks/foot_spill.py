"""Shade and mirror images at the foot of a thing, which a mask may have taken for a part of it.

A ball covers what a sphere does. The outline of a round fruit is a circle, but for what hides it:
what sticks out at its foot belongs to what it lies on; stems and leaves are left as they are.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import cv2
import numpy as np

from physagent_studio.language import SceneHints
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.masks.ground_spill import without_ground
from physagent_studio.reconstruction.masks.round_outlines import (
    NEAR,
    PIXELS,
    ROUND,
    as_ball,
    round_outline,
)
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image

FOOT = 0.6
"""How far below the middle a foot begins, in radii."""
BIN = 16
"""Width of a bin of colours, in values of 8-bit Lab."""
RATHER = 4.0
"""How many times as usual a colour has to be on a ball as on what seems to be before it."""
MUCH = 0.2
"""Share of the mask from which on what sticks out is no mere shade."""


def sound_masks(
    photo: Image, masks: Mapping[str, BoolArray], objects: Sequence[SceneObject], told: SceneHints
) -> dict[str, BoolArray]:
    """The masks without the ground and shade at their feet where nobody has drawn them."""
    out = dict(masks)
    drawn = {item.name for item in objects if item.grounding.strokes}
    yielding = {item.name for item in objects} - drawn
    for item in objects:
        mask = out.get(item.name)
        if mask is None or item.name in drawn:
            continue
        others = [other for name, other in out.items() if name != item.name]
        beside = np.any(others, axis=0) if others else np.zeros_like(mask)
        shapes = told.usual(item.name).shapes
        if shapes[:1] != ("sphere",):
            out[item.name] = without_ground(photo, mask, beside)
            continue
        if shapes == ("sphere",) and at_work("ball outlines"):
            out |= _with_ball(photo, item.name, out, yielding - {item.name})
        elif at_work("foot spill"):
            out[item.name] = without_spill(mask)
    return out


def _with_ball(
    photo: Image, name: str, masks: Mapping[str, BoolArray], yielding: Collection[str]
) -> dict[str, BoolArray]:
    """The mask of a ball as a sphere covers it, and those that give a panel of it back.

    yielding: whose masks may; what a person has drawn is in front.
    """
    mask, nothing = masks[name], np.zeros_like(masks[name])
    others = {one: other for one, other in masks.items() if one != name}
    soft = np.any([others[one] for one in yielding if one in others] or [nothing], axis=0)
    firm = np.any([other for one, other in others.items() if one not in yielding] or [nothing], 0)
    ball = as_ball(mask, firm | (soft & ~_rather(photo, mask, soft)))
    back = ball & ~mask
    given = {one: others[one] & ~back for one in yielding if one in others}
    return given | {name: ball}


def _rather(photo: Image, mask: BoolArray, others: BoolArray) -> BoolArray:
    """(H, W) where the colours are much rather those of a mask than those of the others'."""
    lab = cv2.cvtColor(np.ascontiguousarray(photo), cv2.COLOR_RGB2LAB) // BIN
    index = (lab[..., 0].astype(int) * 16 + lab[..., 1]) * 16 + lab[..., 2]
    own, other = (
        np.bincount(index[area], minlength=16**3) / max(np.count_nonzero(area), 1)
        for area in (mask, others & ~mask)
    )
    return np.asarray((own > RATHER * other)[index])


def without_spill(mask: BoolArray) -> BoolArray:
    """The mask (H, W) of a ball without what sticks out of its circle at its foot."""
    found = round_outline(mask, stretches=(1.0,))
    if found is None or found.share < ROUND:
        return mask
    rows, columns = np.indices(mask.shape)
    beyond = (
        np.hypot(columns + 0.5 - found.x, rows + 0.5 - found.y)
        > (1 + NEAR / 2) * found.radius + PIXELS
    )
    spill = mask & beyond & (rows > found.y + FOOT * found.radius)
    share = np.count_nonzero(spill) / np.count_nonzero(mask)
    return mask & ~spill if 0 < share < MUCH else mask
