"""Whether clicks make sense: on something that stands out, and one name to a thing."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Grounding, SceneObject, SceneState
from physagent_studio.reconstruction.masks.draft_score import outline_contrast
from physagent_studio.reconstruction.masks.thing_map import MAP, ThingMap, thing_map
from physagent_studio.reconstruction.photo.regions import BoolArray, grow, iou
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Finding

Bounds = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class ClickSettings:
    """When a click is on nothing, and when two are on one thing."""

    side_px: int = 480  # 240..960: the picture's longer side on which outlines are looked at
    min_step_lab: float = 10.0  # 3..25: median step across an outline; below, nothing stands out
    max_near_factor: float = 1.5  # 0.5..4: between clicks in roots of the larger area: two beyond
    min_same_ratio: float = 0.75  # 0.5..0.95: IoU of two masks of one thing with two names
    # 0.4..1: of the looks at a thing, holding clicks on another: things in a stack are parted
    min_held_share: float = 0.75


CLICKS = ClickSettings()


def measure(state: SceneState, image: Image, masks: Mapping[str, BoolArray]) -> list[Finding]:
    """What is wrong with the clicks on objects; nothing where they make sense.

    masks: (H, W) of the objects, at the size of `image`. What a person has settled is not asked.
    """
    factor = min(1.0, CLICKS.side_px / max(image.shape[:2]))
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
        same = _one_thing(one, other, alone, min(1.0, MAP.picture_px / max(image.shape[:2])))
        found += same
        twice |= {one.name, other.name} if same else set()
    for item in asked:
        if item.name not in twice:
            mask = cv2.resize(masks[item.name].astype(np.uint8), size).astype(bool)
            found += _on_nothing(item, lab, mask)
    return found


def _on_nothing(item: SceneObject, lab: NDArray[np.float32], mask: BoolArray) -> list[Finding]:
    """A click on bare ground: what it gives has no outline."""
    if np.count_nonzero(mask) < 12:
        return []
    step = outline_contrast(lab, mask)
    if step >= CLICKS.min_step_lab:
        return []
    text = f"nothing stands out where {item.name} is clicked; click on it, or draw a box around it"
    if item.grounding.box is not None:
        text = f"{item.name} hardly stands out in its box"
    return [
        Finding("stands out", item.name, step, CLICKS.min_step_lab, "Lab", False, "points", text)
    ]


def _near(one: SceneObject, other: SceneObject, masks: Mapping[str, BoolArray]) -> bool:
    """Whether two things are clicked so close together that they could be one, and meet."""
    if _boxed_apart(one.grounding.box, other.grounding.box):
        return False
    mine, theirs = masks[one.name], masks[other.name]
    sizes = sorted((np.count_nonzero(mine), np.count_nonzero(theirs)))
    if sizes[0] > 0.1 * sizes[1] and not (grow(mine, 3) & theirs).any():
        return False
    reach = CLICKS.max_near_factor * float(np.sqrt(sizes[1]))
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
    return shared < CLICKS.min_same_ratio * area


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
    if shared < CLICKS.min_same_ratio or both < CLICKS.min_held_share:
        return []
    text = f"{one.name} and {other.name} are clicked on the same thing; take one name away"
    return [Finding("one name", one.name, shared, CLICKS.min_same_ratio, "", False, "points", text)]


def _held(seen: ThingMap, item: SceneObject, factor: float) -> float:
    """The share of looks at a thing that hold a click on the other."""
    clicks = [(int(c.y * factor), int(c.x * factor)) for c in item.grounding.points if c.label]
    looks = (seen.chance, *seen.looks)
    return float(np.mean([any(look[y, x] > 0.5 for y, x in clicks) for look in looks]))
