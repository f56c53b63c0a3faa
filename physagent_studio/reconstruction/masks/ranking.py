"""Which drafts lead: the score of each, what the name and the box say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.draft_score import Draft, Scorer
from physagent_studio.reconstruction.masks.task import Task
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, iou, solidity
from physagent_studio.reconstruction.switches import at_work

DENIED = 0.5
"""What a draft loses that covers all clicks outside."""
OTHER_COLOUR, MIXED = 0.3, 0.5
"""What a draft loses that has none of the named colour, and how much less of it costs nothing."""
FULL, OPEN = 0.8, 0.5
"""What a draft of a slender thing loses that fills its hull, and how much of it may be filled."""


def ranked(scorer: Scorer, drafts: Sequence[Draft], task: Task) -> list[tuple[Draft, float]]:
    """Drafts with their scores, best first."""
    if task.box is not None:
        graded = _in_box(scorer, drafts, task, task.box)
    else:
        graded = scorer.scores(drafts)
        if task.aspect is not None and at_work("usual proportions"):
            graded = graded - _odd_proportions(drafts, task.aspect)
        if task.named is not None:
            graded = graded - _odd_colours(drafts, task.named)
    if task.slender and at_work("slender names"):
        graded = graded - _too_full(drafts)
    order = np.argsort(-graded, kind="stable")
    return [(drafts[int(k)], max(float(graded[k]), 0.0)) for k in order]


def _in_box(
    scorer: Scorer,
    drafts: Sequence[Draft],
    task: Task,
    box: tuple[float, float, float, float],
) -> NDArray[np.float64]:
    """Estimated IoU of drafts in a box, from what each shows by itself.

    Four weights, regressed on the reference outlines of 14 photographs and rounded; with each
    photograph left out in turn, drafts of .85 in the mean and .935 in the median are chosen.
    """
    out = np.zeros(len(drafts))
    area = max((box[2] - box[0]) * (box[3] - box[1]), 1.0)
    for k, draft in enumerate(drafts):
        own = scorer.alone(draft)
        value = 0.2 + 0.2 * fills(draft.mask, box) + 0.3 * own["weakest"]
        value += 0.5 * min(np.count_nonzero(draft.mask) / area, 1.0) - 0.35 * own["colour overlap"]
        out[k] = value * own["covered"] - DENIED * _denied(draft.mask, task)
    return np.clip(out, 0.0, 1.0)


def _denied(mask: BoolArray, task: Task) -> float:
    """Share of a person's clicks outside that a mask covers all the same."""
    if not task.outside:
        return 0.0
    return float(np.mean([mask[int(y), int(x)] for x, y in task.outside]))


def _odd_proportions(drafts: Sequence[Draft], aspect: tuple[float, float]) -> NDArray[np.float64]:
    """What drafts lose whose height over width is unusual for the name."""
    usual, spread = aspect
    out = np.zeros(len(drafts))
    for k, draft in enumerate(drafts):
        x0, y0, x1, y1 = bounds(draft.mask)
        off = np.log(max(y1 - y0, 1) / max(x1 - x0, 1) / usual) / (spread + 0.1)
        out[k] = 0.04 * min(float(off) ** 2, 4.0)
    return out


def _odd_colours(drafts: Sequence[Draft], named: BoolArray) -> NDArray[np.float64]:
    """What drafts lose of which much less may be called by the colour in the name than of others.

    A name's colour need not be everywhere: a red car has black tyres.
    """
    shares = np.array([float(named[draft.mask].mean()) for draft in drafts])
    return OTHER_COLOUR * np.clip(shares.max(initial=0.0) - shares - MIXED, 0, 1)


def _too_full(drafts: Sequence[Draft]) -> NDArray[np.float64]:
    """What drafts of poles and frames lose that fill the hull around them."""
    return np.array([FULL * max(solidity(draft.mask) - OPEN, 0.0) for draft in drafts])


def distinct(
    ranked: Sequence[tuple[Draft, float]], count: int, alike: float
) -> list[tuple[Draft, float]]:
    """The first `count` drafts that overlap the earlier ones by less than `alike`."""
    chosen: list[tuple[Draft, float]] = []
    for draft, value in ranked:
        if all(iou(draft.mask, other.mask) < alike for other, _ in chosen):
            chosen.append((draft, value))
        if len(chosen) == count:
            break
    return chosen


def fills(mask: BoolArray, box: tuple[float, float, float, float]) -> float:
    """How well a mask reaches all four sides of a box, 0 … 1."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = max(box[2] - box[0], 1.0), max(box[3] - box[1], 1.0)
    # Boxes are drawn a little wide: a gap of a twentieth on each side is none.
    gaps = np.array([(x0 - box[0]), (box[2] - x1)]) / width
    gaps = np.append(gaps, np.array([(y0 - box[1]), (box[3] - y1)]) / height)
    return float(np.prod(1 - np.clip(np.maximum(gaps - 0.06, 0), 0, 1)))
