"""A closer look where a small thing is doubtful.

On a picture that is brought to working size a small thing is few pixels wide: its stripes, its
neck or its rim are lost, and methods disagree. It is then looked at once more on a piece of the
picture around the clicks, and the masks of both looks are offered, led by the surer one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, zip_longest

import cv2
import numpy as np

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.choice import CANDIDATES, Scored
from physagent_studio.reconstruction.masks.draft_score import Draft
from physagent_studio.reconstruction.masks.task import View
from physagent_studio.reconstruction.masks.variants import VARIANT
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, iou

SURE = 0.72
"""Estimated IoU of the first mask from which there is no doubt."""
EARLY = 0.62
"""The same for the best of the first drafts, before more of them raise it."""
CLEARER = 0.05
"""By how much the closer look has to be surer to lead: from close by, estimates scatter more."""
SMALL = 0.3
"""Longer side of the smallest mask, as a share of the picture's, from which a thing is large."""
PIECE = 0.45
"""Side of the piece of picture, as a share of the picture's longer side."""
SAME = 0.92
"""IoU, at working size, from which masks of two looks are one."""


@dataclass(frozen=True, eq=False, slots=True)
class Look:
    """What was found on one view of the picture, best first."""

    view: View
    found: list[Scored]


def is_doubtful(look: Look) -> bool:
    """Whether a closer look may show more."""
    if not look.found or look.found[0][1] >= SURE:
        return False
    # What is large at first sight may be the ground of something thin.
    return min(_extents(look)) <= SMALL * max(look.view.lab.shape[:2])


def piece_around(grounding: Grounding, shape: tuple[int, ...]) -> tuple[int, int, int, int] | None:
    """The piece (x0, y0, x1, y1) of a picture to look at from closer; None if it held not all
    clicks."""
    inside = np.array([(click.x, click.y) for click in grounding.points if click.label])
    if not len(inside):
        return None
    x, y = inside.mean(axis=0)
    half = PIECE / 2 * max(shape[:2])
    left, top = int(max(0, x - half)), int(max(0, y - half))
    right, low = int(min(shape[1], x + half)), int(min(shape[0], y + half))
    held = (inside >= (left, top)) & (inside < (right, low))
    return (left, top, right, low) if held.all() else None


def _extents(look: Look) -> list[int]:
    """The longer side of each mask, pixels of the view."""
    boxes = [bounds(draft.mask) for draft, _ in look.found]
    return [max(x1 - x0, y1 - y0) for x0, y0, x1, y1 in boxes]


def merged(far: Look, near: Look) -> list[tuple[Scored, View]]:
    """Up to four masks of two looks, each with its view: the surer look leads, both have a say."""
    if not near.found:
        return [(item, far.view) for item in far.found]
    leads = near.found[0][1] > far.found[0][1] + CLEARER
    shaded = [item for item in (near if leads else far).found if item[0].method == "with shadow"]
    out: list[tuple[Scored, View]] = []
    kept: list[BoolArray] = []
    for (draft, value), view in chain(_in_turn(far, near, leads), _all(far), _all(near)):
        room = CANDIDATES - (bool(shaded) and all(d.method != "with shadow" for (d, _), _ in out))
        mask = _as_seen(draft, view, far.view)
        if len(out) >= room or any(iou(mask, other) > SAME for other in kept):
            continue
        kept.append(mask)
        out.append(((draft, min(value, out[-1][0][1]) if out else value), view))
    if shaded and len(out) < CANDIDATES:
        value = min(shaded[0][1], out[-1][0][1])
        out.append(((shaded[0][0], value), near.view if leads else far.view))
    return out


def _in_turn(far: Look, near: Look, leads: bool) -> Iterator[tuple[Scored, View]]:
    """Two of the near look for one of the far one, which comes first unless the near one leads."""
    first, second = (_plain(near), near.view), (_plain(far), far.view)
    if not leads:
        yield from ((item, far.view) for item in second[0][:1])
        second = (second[0][1:], far.view)
    pairs = zip_longest(first[0][::2], first[0][1::2], second[0])
    for one, other, own in pairs:
        for item, view in ((one, near.view), (other, near.view), (own, far.view)):
            if item is not None:
                yield item, view


def _plain(look: Look) -> Sequence[Scored]:
    return [item for item in look.found if item[0].family != VARIANT]


def _all(look: Look) -> Iterator[tuple[Scored, View]]:
    return ((item, look.view) for item in look.found if item[0].method != "with shadow")


def _as_seen(draft: Draft, view: View, other: View) -> BoolArray:
    """A mask of one view at the size and place of another that holds it."""
    if view is other:
        return draft.mask
    corners = np.array([view.part[:2], view.part[2:]], float) - other.part[:2]
    (x0, y0), (x1, y1) = np.rint(corners * other.factor).astype(int)
    rows, columns = other.lab.shape[:2]
    x1, y1 = min(int(x1), columns), min(int(y1), rows)
    out = np.zeros((rows, columns), bool)
    size = (x1 - int(x0), y1 - int(y0))
    small = cv2.resize(draft.mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    out[int(y0) : y1, int(x0) : x1] = np.asarray(small) > 0.5
    return out
