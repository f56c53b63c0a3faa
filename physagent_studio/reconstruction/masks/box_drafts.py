"""Drafts inside a box, a person's or that of what the map shows, and which of them lead."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import grabcut
from physagent_studio.reconstruction.masks.choice import Scored, agreed
from physagent_studio.reconstruction.masks.draft_score import Draft, likeness
from physagent_studio.reconstruction.masks.ranking import Seen, gaps, ranked
from physagent_studio.reconstruction.masks.task import Task, View
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    bounds,
    holding,
    smooth,
    without_pinholes,
)
from physagent_studio.reconstruction.switches import at_work

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class DraftSettings:
    """What is a draft, and which of its holes are filled."""

    min_draft_px: int = 30  # 10..200: of the view: less is a speck
    min_window_share: float = 0.2  # 0.05..0.5: mean of the map on a hole that belongs to the thing
    max_window_share: float = 0.1  # 0.01..0.3: of the mask, of such a hole
    # share, 0.8..1: of its own bounds, that an upright rectangle fills
    min_filled_share: float = 0.93
    # share, 0.005..0.3: of a box, by which what is framed ends before two sides, and before any
    frame_shares: tuple[float, float] = (0.02, 0.15)
    min_edge_ratio: float = 0.3  # 0.1..1: of a frame's outer edge over its inner one
    same_ratio: float = 0.97  # 0.9..1: IoU of two drafts whose union tells nothing new


DRAFTS = DraftSettings()


def found_in(
    view: View, task: Task, maps: Sequence[NDArray[np.float32]], sure: float
) -> list[Scored]:
    """Up to four masks on a view, best first.

    maps: (h, w) of the thing there, first the one that drafts are weighed by, then those of other
    looks, which are drafts as well. sure: how sure the first is, 0 … 1.
    """
    if task.box is None:
        return []
    shown = [one > 0.5 for one in maps]
    drafts = _cut(view.small, task, task.box, None) + _cut(view.small, task, task.box, shown[0])
    if at_work("rare colours") and (rare := _rare(view, task.box)).any():
        drafts += _cut(view.small, task, task.box, rare)
    drafts += [Draft(mask, "map", "map") for mask in shown]
    drafts = [one for one in drafts if np.count_nonzero(one.mask) >= DRAFTS.min_draft_px]
    drafts = [replace(draft, mask=_without_windows(draft.mask, maps[0])) for draft in drafts]
    if at_work("unions of drafts"):
        drafts += _unions(drafts)
    if task.tight and at_work("framed"):
        drafts += _framed(view.lab, drafts, task.box)
    found = ranked(view.lab, drafts, task, task.box, Seen(maps[0], sure))
    return agreed(found, view.lab)


def _cut(small: NDArray[np.uint8], task: Task, box: Box, likely: BoolArray | None) -> list[Draft]:
    """What GrabCut finds in a box (x0, y0, x1, y1): all of it, and the part that was clicked.

    likely: (h, w) what the thing's colours are taken from, where it is not all that is in the box.
    """
    found = grabcut.in_box(small, box, task.inside, task.outside, likely)
    if found is None:
        return []
    x0, y0, x1, y1 = box
    within = np.zeros(small.shape[:2], bool)
    within[max(0, int(y0)) : int(np.ceil(y1)) + 1, max(0, int(x0)) : int(np.ceil(x1)) + 1] = True
    # A box says that all of its object lies inside: loose parts may belong to it.
    method = "box" if likely is None else "map-cut"
    drafts = [Draft(_tidy(found) & within, method, "colour")]
    if task.inside:
        drafts.append(Draft(clean(found, task) & within, f"{method}-part", "colour"))
    return drafts


def _rare(view: View, box: Box) -> BoolArray:
    """(h, w) what is in a box, of colours that are rarer around it.

    A cut that takes all of a box for the thing learns the ground's colours as the thing's where
    much of it shows: through rings and handles, between legs.
    """
    x0, y0, x1, y1 = (int(side) for side in box)
    within = np.zeros(view.lab.shape[:2], bool)
    within[max(0, y0) : y1 + 1, max(0, x0) : x1 + 1] = True
    if within.all():
        return np.zeros_like(within)
    return within & (grabcut.likelihood_ratio(view.lab, within, ~within) > 0)


def _unions(drafts: Sequence[Draft]) -> list[Draft]:
    """Any two drafts as one: of a thing of many parts each may show another one."""
    if not drafts:
        return []
    like = likeness(drafts)
    return [
        Draft(
            one.mask | other.mask,
            f"{one.method}+{other.method}",
            one.family if one.family == other.family else "union",
        )
        for (i, one), (k, other) in itertools.combinations(enumerate(drafts), 2)
        if like[i, k] < DRAFTS.same_ratio
    ]


def _framed(lab: NDArray[np.float32], drafts: Sequence[Draft], box: Box) -> list[Draft]:
    """What frames an upright rectangle, out to the edges nearest to the sides of its box: a
    picture and its frame, a screen and its rim are parted by a line as sharp as the outer one."""
    rows, columns = lab.shape[:2]
    least, most = DRAFTS.frame_shares
    for draft in drafts:
        left, top, right, low = bounds(draft.mask)
        if np.count_nonzero(draft.mask) < DRAFTS.min_filled_share * (right - left) * (low - top):
            continue
        short = gaps(draft.mask, box)
        if sum(gap > least for gap in short) < 2 or not all(-least < gap < most for gap in short):
            continue
        inner = (left, top, right, low)
        sides = [side for k in range(4) if (side := _side(lab, inner, box, k)) is not None]
        if len(sides) < 4:
            continue
        ends = (columns, rows, columns, rows)
        x0, y0, x1, y1 = (min(max(v, 0), end) for v, end in zip(sides, ends, strict=True))
        frame = np.zeros((rows, columns), bool)
        frame[y0:y1, x0:x1] = True
        return [Draft(frame, "frame", "colour")]
    return []


def _side(lab: NDArray[np.float32], inner: tuple[int, ...], box: Box, k: int) -> int | None:
    """Where the frame of a rectangle ends on its side k: the sharpest edge near the box's side;
    None where none is nearly as sharp as that of the rectangle itself."""
    left, top, right, low = inner
    across = lab[top:low] if k % 2 == 0 else lab[:, left:right].transpose(1, 0, 2)
    step = np.abs(np.diff(across.astype(float), axis=1)).sum(-1).mean(0)
    reach = max(2.0, abs(inner[k] - box[k]) / 2)
    first, last = max(0, int(box[k] - reach)), min(len(step), int(np.ceil(box[k] + reach)))
    own = step[max(0, inner[k] - 3) : inner[k] + 3]
    if last <= first or step[first:last].max() < DRAFTS.min_edge_ratio * own.max(initial=0.0):
        return None
    return first + int(step[first:last].argmax()) + 1


def _without_windows(mask: BoolArray, chance: NDArray[np.float32]) -> BoolArray:
    """The mask with those holes filled of which a map (h, w) half believes that they belong to it.

    As the windows and hub caps of a car; through a handle or a ring the map sees what is behind.
    """
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        (~mask).astype(np.uint8), connectivity=4
    )
    area = np.count_nonzero(mask)
    rows, columns = mask.shape
    out = mask.copy()
    for label in range(1, count):
        x, y, width, height, size = (int(value) for value in stats[label])
        inside = x > 0 and y > 0 and x + width < columns and y + height < rows
        if inside and size < DRAFTS.max_window_share * area:
            hole = labels == label
            out[hole] = float(chance[hole].mean()) > DRAFTS.min_window_share
    return out


def clean(mask: BoolArray, task: Task) -> BoolArray:
    """The clicked part, without hairs, its small holes filled."""
    part = without_pinholes(smooth(holding(mask, task.inside)), 0.02)
    return holding(part, task.inside)


def _tidy(mask: BoolArray) -> BoolArray:
    """The mask without specks smaller than a fiftieth of its largest part."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    if count < 2:
        return mask
    areas = stats[1:, cv2.CC_STAT_AREA]
    kept = 1 + np.flatnonzero(areas > 0.02 * areas.max())
    return without_pinholes(np.isin(labels, kept), 0.01)
