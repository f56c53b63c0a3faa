"""What stands on what, read from the masks alone, before anything is placed in space."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import cv2
import numpy as np

from physagent_studio.knowledge import words_of
from physagent_studio.language import SceneHints
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds

_ORDER = {"top": 0, "upper": 0, "topmost": 0, "uppermost": 0, "first": 1, "second": 2, "third": 3}
_ORDER |= {"middle": 10, "centre": 10, "center": 10, "fourth": 4, "fifth": 5, "sixth": 6}
_ORDER |= {"lower": 20, "bottom": 21, "lowest": 21, "bottommost": 21}
"""Words that say where in a stack a thing is, from above."""
TOLD_NOTHING = SceneHints()


@dataclass(frozen=True, slots=True)
class Stance:
    """Where an object's silhouette ends below, and what is there. Pixels.

    box: (x0, y0, x1, y1). foot: middle of its lowest part. on: the object that it stands on,
    seen directly under it. over: the object below it across a gap. aloft: the words say that
    it hangs or floats. leans: they say that it leans. lands: they say that it drops, or comes down
    onto something.
    """

    name: str
    box: tuple[int, int, int, int]
    foot: tuple[float, float]
    on: str | None = None
    over: str | None = None
    aloft: bool = False
    leans: bool = False
    lands: bool = False

    @property
    def width(self) -> int:
        """Width of the silhouette, pixels."""
        return self.box[2] - self.box[0]

    @property
    def height(self) -> int:
        """Height of the silhouette, pixels."""
        return self.box[3] - self.box[1]

    @property
    def extent(self) -> int:
        """The longer visible side, pixels."""
        return max(self.width, self.height)


def read(masks: Mapping[str, BoolArray], told: SceneHints = TOLD_NOTHING) -> dict[str, Stance]:
    """The stance of every object whose mask is not empty."""
    found: dict[str, Stance] = {}
    for name, mask in masks.items():
        if np.count_nonzero(mask) < 12:
            continue
        box = bounds(mask)
        foot = foot_of(mask)
        on = _directly_below(name, mask, masks)
        over = None if on else _across_gap(name, box, masks)
        aloft, leans, lands = (name in own for own in (told.aloft, told.leaning, told.landing))
        found[name] = Stance(name, box, foot, on, over, aloft, leans, lands)
    return {**found, **_named_stacks(found)}


def _named_stacks(found: Mapping[str, Stance]) -> dict[str, Stance]:
    """Stances of things whose names say their order in a stack: top, second, …, bottom.

    Only where the picture shows them above one another; masks that run into each other then no
    longer decide what lies on what.
    """
    stacks: dict[str, list[tuple[int, Stance]]] = {}
    for name, stance in found.items():
        words = words_of(name)
        rank = next((_ORDER[word] for word in words if word in _ORDER), None)
        if rank is not None:
            kind = " ".join(word for word in words if word not in _ORDER)
            stacks.setdefault(kind, []).append((rank, stance))
    out: dict[str, Stance] = {}
    for members in stacks.values():
        order = [stance for _, stance in sorted(members, key=lambda pair: pair[0])]
        if len({rank for rank, _ in members}) < len(members):
            continue
        if all(_is_above(upper, lower) for upper, lower in pairwise(order)):
            for upper, lower in pairwise(order):
                out[upper.name] = replace(upper, on=lower.name, over=None)
            below = order[-1]
            if below.on in {stance.name for stance in order}:
                out[below.name] = replace(below, on=None)
    return out


def _is_above(upper: Stance, lower: Stance) -> bool:
    """Whether two silhouettes could be a thing lying on another: side by side they are not."""
    shared = min(upper.box[2], lower.box[2]) - max(upper.box[0], lower.box[0])
    overlap = shared > 0.5 * min(upper.width, lower.width)
    gap = lower.box[1] - upper.box[3]
    higher = upper.box[1] + upper.box[3] < lower.box[1] + lower.box[3]
    return overlap and higher and gap < 0.1 * max(upper.height, lower.height)


def foot_of(mask: BoolArray) -> tuple[float, float]:
    """Middle (x, y) of the lowest part of a mask; y is the lower edge of its lowest pixels."""
    rows = np.flatnonzero(mask.any(1))
    # A few stray pixels below the object shall not move its foot.
    counts = np.cumsum(mask.sum(1)[::-1])[::-1]
    solid = rows[counts[rows] >= max(2, 0.002 * counts[0])]
    bottom = int(solid[-1]) if len(solid) else int(rows[-1])
    band = max(2, round(0.03 * (rows[-1] - rows[0] + 1)))
    columns = np.flatnonzero(mask[max(0, bottom - band) : bottom + 1].any(0))
    return float(columns[0] + columns[-1] + 1) / 2, float(bottom + 1)


def _lower_edge(mask: BoolArray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and the row just below the mask in each of them, where the mask faces down."""
    columns = np.flatnonzero(mask.any(0))
    last = mask.shape[0] - 1 - mask[::-1, columns].argmax(0)
    lowest = last.max()
    height = lowest - np.flatnonzero(mask.any(1))[0] + 1
    # Only the part that could touch something: not the overhanging flanks.
    low = last >= lowest - max(3, 0.3 * height)
    return columns[low], last[low] + 1


def _directly_below(name: str, mask: BoolArray, masks: Mapping[str, BoolArray]) -> str | None:
    columns, rows = _lower_edge(mask)
    x0, y0, x1, y1 = bounds(mask)
    reach = max(4, round(0.05 * (y1 - y0)))
    middle, least_share = (x0 + x1) / 2, 0.3
    found: list[tuple[float, str, float]] = []
    for other, below in masks.items():
        if other == name or not below.any():
            continue
        ox0, oy0, ox1, oy1 = bounds(below)
        beneath = [
            below[np.clip(rows + step, 0, mask.shape[0] - 1), columns] for step in range(reach)
        ]
        share = float(np.mean(np.any(beneath, axis=0)))
        # What stands in front of a thing also ends it below, but reaches far up beside it.
        deep = (y1 - oy0) / max(oy1 - oy0, 1)
        off = min(ox1 - middle, 0.0) + max(ox0 - middle, 0.0)
        if (deep < 0.5 or (deep < 1 and _is_notched(mask, below))) and oy1 > y1:
            found.append((share, other, off))
    best = max((one for one in found if one[0] > least_share and not one[2]), default=None)
    if best is None:
        # It may stand on two that are side by side, one foot on each.
        sides = [max((o for o in found if o[2] * way > 0), default=None) for way in (-1, 1)]
        pair = [one for one in sides if one is not None and one[0] > least_share / 2]
        best = max(pair) if len(pair) == 2 else None
    return best[1] if best else None


def _is_notched(mask: BoolArray, other: BoolArray) -> bool:
    """Whether the foot of a thing cuts into another's outline: it stands on that, not behind it.

    As an orange on a plate. What hides the foot of a thing is whole itself.
    """
    corners = np.argwhere(other)[:, ::-1].astype(np.int32)
    hull = cv2.fillConvexPoly(np.zeros(mask.shape, np.uint8), cv2.convexHull(corners), 1)
    _, y0, _, y1 = bounds(mask)
    low = mask.copy()
    foot_share = 0.2  # 0.05..0.5: of a thing's height, from below
    low[: y1 - max(3, round(foot_share * (y1 - y0)))] = False
    min_within_share = 0.9  # 0.6..1: of the foot, within another's outline
    return float(hull[low].mean()) > min_within_share


def _across_gap(
    name: str, box: tuple[int, int, int, int], masks: Mapping[str, BoolArray]
) -> str | None:
    x0, _, x1, y1 = box
    nearest: tuple[int, str] | None = None
    for other, mask in masks.items():
        if other == name or not mask.any():
            continue
        ox0, oy0, ox1, _ = bounds(mask)
        shared = min(x1, ox1) - max(x0, ox0)
        centred = ox0 <= (x0 + x1) / 2 <= ox1
        if oy0 >= y1 - 2 and centred and shared > 0.5 * min(x1 - x0, ox1 - ox0):
            gap = oy0 - y1
            if nearest is None or gap < nearest[0]:
                nearest = (gap, other)
    return nearest[1] if nearest else None
