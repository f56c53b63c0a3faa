"""Shade and mirror images at the foot of a thing, which a mask may have taken for a part of it.

A plain body has no openings: what a mask leaves out within it, a dial or a label, belongs to it;
the windows of a car go along with it, whatever is seen through them. A ball covers what a sphere
does. The outline of a round fruit is a circle, but for what hides it: what sticks out at its foot
belongs to what it lies on; stems and leaves are left as they are.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.knowledge.things import Usual
from physagent_studio.language import SceneHints
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.masks.box_outlines import as_box
from physagent_studio.reconstruction.masks.round_outlines import (
    ROUND,
    as_ball,
    round_outline,
)
from physagent_studio.reconstruction.photo.regions import BoolArray, without_pinholes
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class FootSettings:
    """What is shade at a round thing's foot, and what is a panel of it."""

    foot_ratio: float = 0.6  # 0.2..0.9: below the middle, in radii, where a foot begins
    bin_levels: int = 16  # 4..32: of 8-bit Lab, in which colours count as one
    min_own_factor: float = 4.0  # 1.5..10: as usual on a ball as on what seems to be before it
    max_spill_share: float = 0.2  # 0.05..0.4: of the mask: more that sticks out is no mere shade


FOOT = FootSettings()


def sound_masks(
    photo: Image, masks: Mapping[str, BoolArray], objects: Sequence[SceneObject], told: SceneHints
) -> dict[str, BoolArray]:
    """The masks of balls and boxes as such things cover, where nobody has drawn them."""
    out = dict(masks)
    drawn = {item.name for item in objects if item.grounding.strokes}
    yielding = {item.name for item in objects} - drawn
    for item in objects:
        mask = out.get(item.name)
        if mask is None or item.name in drawn:
            continue
        others = [other for name, other in out.items() if name != item.name]
        beside = np.any(others, axis=0) if others else np.zeros_like(mask)
        usual = told.usual(item.name)
        shapes = usual.shapes
        if _is_closed(usual) and at_work("closed bodies"):
            out[item.name] = mask = mask | (without_pinholes(mask, math.inf) & ~beside)
        if shapes[:1] != ("sphere",):
            if shapes == ("box",) and at_work("box outlines"):
                out[item.name] = as_box(mask, beside)
            continue
        if shapes == ("sphere",) and at_work("ball outlines"):
            out |= _with_ball(photo, item.name, out, yielding - {item.name})
        elif at_work("foot spill"):
            out[item.name] = without_spill(photo, mask)
    return out


def _is_closed(usual: Usual) -> bool:
    """Whether its outline has no holes: a plain body, or a car, without a handle or a frame."""
    plain = bool(usual.shapes) and usual.shapes[0] not in ("inflated", "torus")
    return (plain or usual.drives) and not usual.parts


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
    lab = cv2.cvtColor(np.ascontiguousarray(photo), cv2.COLOR_RGB2LAB) // FOOT.bin_levels
    index = (lab[..., 0].astype(int) * 16 + lab[..., 1]) * 16 + lab[..., 2]
    own, other = (
        np.bincount(index[area], minlength=16**3) / max(np.count_nonzero(area), 1)
        for area in (mask, others & ~mask)
    )
    return np.asarray((own > FOOT.min_own_factor * other)[index])


def without_spill(photo: Image, mask: BoolArray) -> BoolArray:
    """The mask (H, W) of a ball without what sticks out of its circle at its foot, where the edge
    in the photo is rather along the circle."""
    found = round_outline(mask, stretches=(1.0,))
    if found is None or found.share < ROUND.min_share:
        return mask
    rows, columns = np.indices(mask.shape)
    beyond = (
        np.hypot(columns + 0.5 - found.x, rows + 0.5 - found.y)
        > (1 + ROUND.near_ratio / 2) * found.radius + ROUND.near_px
    )
    spill = mask & beyond & (rows > found.y + FOOT.foot_ratio * found.radius)
    share = np.count_nonzero(spill) / np.count_nonzero(mask)
    if not 0 < share < FOOT.max_spill_share or _edge_beyond(photo, mask, spill):
        return mask
    return mask & ~spill


def _edge_beyond(photo: Image, mask: BoolArray, spill: BoolArray) -> bool:
    """Whether the edge of a thing is around what sticks out of it, and not before that."""
    # By colour: shade is darker than the ground, and no more colourful.
    colour = cv2.cvtColor(np.ascontiguousarray(photo), cv2.COLOR_RGB2LAB)[..., 1:].astype(
        np.float32
    )
    steep = np.hypot(*(cv2.Scharr(colour, cv2.CV_32F, *way) for way in ((1, 0), (0, 1)))).sum(-1)
    beside = cv2.dilate(spill.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    on_circle, around = beside & mask & ~spill, beside & ~mask
    if not on_circle.any() or not around.any():
        return False
    return float(steep[around].mean()) > float(steep[on_circle].mean())
