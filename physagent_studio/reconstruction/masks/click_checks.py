"""Whether clicks make sense: on something that stands out, and one name to a thing."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Grounding, SceneObject, SceneState
from physagent_studio.reconstruction.masks.draft_score import outline_contrast
from physagent_studio.reconstruction.masks.thing_map import WORKED_ON, ThingMap, thing_map
from physagent_studio.reconstruction.photo.regions import BoolArray, grow, iou
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Finding

Bounds = tuple[float, float, float, float]
FAINT = 10.0
"""Median step of colour (Lab, 0 … 255 each) across an outline, from which there is one."""
NEAR = 1.5
"""Distance of clicks, in roots of the larger area, from which things are surely two."""
SAME = 0.75
"""Least overlap of two masks for one thing with two names."""
HELD_BY = 0.75
"""Share of looks at a thing that hold clicks on another, from which they may be one."""
SIDE = 480


def measure(state: SceneState, image: Image, masks: Mapping[str, BoolArray]) -> list[Finding]:
    """What is wrong with the clicks on objects; nothing where they make sense.

    masks: (H, W) of the objects, at the size of `image`. What a person has settled is not asked.
    """
    factor = min(1.0, SIDE / max(image.shape[:2]))
    size = (round(image.shape[1] * factor), round(image.shape[0] * factor))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32)
    asked = [o for o in state.objects if o.name in masks and not o.grounding.settled]
    found: list[Finding] = []
    twice: set[str] = set()
    alone: dict[str, ThingMap | None] = {}
    for one, other in combinations(asked, 2):
        if not _near(one, other, masks):
            continue
        for item in (one, other):
            if item.name not in alone:
                alone[item.name] = _alone(image, item)
        same = _one_thing(one, other, alone, min(1.0, WORKED_ON / max(image.shape[:2])))
        found += same
        twice |= {one.name, other.name} if same else set()
    for item in asked:
        if item.name not in twice:
            mask = cv2.resize(masks[item.name].astype(np.uint8), size).astype(bool)
            found += _on_nothing(item.name, lab, mask)
    return found


def _on_nothing(name: str, lab: NDArray[np.float32], mask: BoolArray) -> list[Finding]:
    """A click on bare ground: what it gives has no outline."""
    if np.count_nonzero(mask) < 12:
        return []
    step, _ = outline_contrast(lab, mask)
    if step >= FAINT:
        return []
    text = f"nothing stands out where {name} is clicked; click on it, or draw a box around it"
    return [Finding("stands out", name, step, FAINT, "Lab", False, "points", text)]


def _near(one: SceneObject, other: SceneObject, masks: Mapping[str, BoolArray]) -> bool:
    """Whether two things are clicked so close together that they could be one, and meet."""
    if _boxed_apart(one.grounding.box, other.grounding.box):
        return False
    mine, theirs = masks[one.name], masks[other.name]
    sizes = sorted((np.count_nonzero(mine), np.count_nonzero(theirs)))
    if sizes[0] > 0.1 * sizes[1] and not (grow(mine, 3) & theirs).any():
        return False
    reach = NEAR * float(np.sqrt(sizes[1]))
    return any(
        np.hypot(a.x - b.x, a.y - b.y) < reach
        for a in one.grounding.points
        for b in other.grounding.points
        if a.label and b.label
    )


def _boxed_apart(one: Bounds | None, other: Bounds | None) -> bool:
    """Whether a person has drawn two boxes that are not about the same."""
    if one is None or other is None:
        return False
    width = min(one[2], other[2]) - max(one[0], other[0])
    height = min(one[3], other[3]) - max(one[1], other[1])
    shared = max(width, 0.0) * max(height, 0.0)
    area = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (one, other)) - shared
    return shared < SAME * area


def _alone(image: Image, item: SceneObject) -> ThingMap | None:
    """What a thing's own clicks show, as if it were the only one."""
    return thing_map(image, Grounding(points=tuple(c for c in item.grounding.points if c.label)))


def _one_thing(
    one: SceneObject, other: SceneObject, alone: Mapping[str, ThingMap | None], factor: float
) -> list[Finding]:
    """Two names for one thing: each, asked alone, gives the same, and nearly all looks hold both.

    Things in a stack are parted by some of the looks.
    """
    first, second = alone[one.name], alone[other.name]
    if first is None or second is None:
        return []
    shared = iou(first.chance > 0.5, second.chance > 0.5)
    both = min(_held(first, other, factor), _held(second, one, factor))
    if shared < SAME or both < HELD_BY:
        return []
    text = f"{one.name} and {other.name} are clicked on the same thing; take one name away"
    return [Finding("one name", one.name, shared, SAME, "", False, "points", text)]


def _held(seen: ThingMap, item: SceneObject, factor: float) -> float:
    """The share of looks at a thing that hold a click on the other."""
    clicks = [(int(c.y * factor), int(c.x * factor)) for c in item.grounding.points if c.label]
    looks = (seen.chance, *seen.looks)
    return float(np.mean([any(look[y, x] > 0.5 for y, x in clicks) for look in looks]))
