"""Which drafts lead: the score of each, what the name and the box say, and the vote of its like."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import BoolArray, bounds, iou
from physagent_studio.reconstruction.maskscore import Draft, Scorer
from physagent_studio.reconstruction.segmentation_task import Task

CANDIDATES = 4


def ranked(scorer: Scorer, drafts: Sequence[Draft], task: Task) -> list[tuple[Draft, float]]:
    """Drafts with their scores, best first."""
    graded = scorer.scores(drafts)
    if task.aspect is not None:
        graded = graded - _odd_proportions(drafts, task.aspect)
    if task.box is not None:
        graded = 0.5 * graded + 0.5 * np.array([fills(draft.mask, task.box) for draft in drafts])
    order = np.argsort(-graded, kind="stable")
    return [(drafts[int(k)], float(graded[k])) for k in order]


def _odd_proportions(drafts: Sequence[Draft], aspect: tuple[float, float]) -> NDArray[np.float64]:
    """What drafts lose whose height over width is unusual for the name."""
    usual, spread = aspect
    out = np.zeros(len(drafts))
    for k, draft in enumerate(drafts):
        x0, y0, x1, y1 = bounds(draft.mask)
        off = np.log(max(y1 - y0, 1) / max(x1 - x0, 1) / usual) / (spread + 0.1)
        out[k] = 0.04 * min(float(off) ** 2, 4.0)
    return out


def agreed(ranked: Sequence[tuple[Draft, float]]) -> list[tuple[Draft, float]]:
    """The ranking with each leading draft replaced by the vote of those that are like it."""
    leaders = distinct(ranked, CANDIDATES, 0.8)
    out: list[tuple[Draft, float]] = []
    for leader, value in leaders:
        like = [(d, v) for d, v in ranked if iou(d.mask, leader.mask) > 0.8]
        weight = sum(v for _, v in like)
        if len(like) < 3 or weight <= 0:
            out.append((leader, value))
            continue
        share = sum(v * d.mask.astype(np.float32) for d, v in like) / weight
        out.append((Draft(np.asarray(share > 0.5), leader.method, leader.family), value))
    return out


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
