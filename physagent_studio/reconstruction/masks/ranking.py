"""Which drafts lead: what each shows by itself, and whether a network shows the same."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.choice import Scored
from physagent_studio.reconstruction.masks.draft_score import Draft, shown_by
from physagent_studio.reconstruction.masks.task import Task
from physagent_studio.reconstruction.masks.thing_map import soft_iou
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.reconstruction.switches import at_work

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class RankingSettings:
    """What a draft gains and loses by what is seen of it; the first four make up a score."""

    start_score: float = 0.1  # score, 0..0.5: what a draft has before anything is seen of it
    # weight, 0..1: of colours inside that are around as well, against it
    overlap_weight: float = 0.5
    area_weight: float = 0.4  # weight, 0..1: of the box's area that it takes
    # share, 0..1: of the box that counts less for each box that a draft is larger than it
    beyond_loss: float = 0.3
    # weight, 0..2: of its IoU with the network's map, times how sure the map is
    map_weight: float = 0.65
    # share, 0.02..0.2: of a box that a person drew, by which a thing may end before a side of it
    loose_share: float = 0.09
    short_loss: float = 1.2  # weight, 0..2: of what it ends before the sides beyond that
    frame_gain: float = 0.1  # score, 0..0.2: of a rectangle that a box is drawn closely around
    denied_loss: float = 0.5  # score, 0.1..1: of a draft that covers all clicks outside
    spot_px: int = 8  # 2..20: of the view, about a click: a person points no better


RANKING = RankingSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """What a network shows of the thing: chance (h, w), and how sure it is of that, 0 … 1."""

    chance: NDArray[np.float32]
    sure: float


def ranked(
    lab: NDArray[np.float32], drafts: Sequence[Draft], task: Task, box: Box, seen: Seen
) -> list[Scored]:
    """Drafts in a box with their scores, best first.

    From the colours that each parts, how much of the box it takes, and how far the network's map
    shows the same, as far as that is sure of itself: of things that the network has seen nothing
    like, colours say more. Three weights, fitted on 136 cut-outs of photographs before other
    photographs, 27 things of the known photographs and 45 of generated pictures.
    """
    area = max((box[2] - box[0]) * (box[3] - box[1]), 1.0)
    graded: list[Scored] = []
    for draft, own in zip(drafts, shown_by(drafts, lab, task.inside), strict=True):
        taken = np.count_nonzero(draft.mask) / area
        # What a click's other looks show may reach far beyond the box of the best one.
        taken = min(taken, 1.0) - RANKING.beyond_loss * max(taken - 1.0, 0.0)
        value = (
            RANKING.start_score
            - RANKING.overlap_weight * own.overlap
            + RANKING.area_weight * taken
            + RANKING.map_weight * seen.sure * soft_iou(draft.mask, seen.chance)
        )
        if draft.method == "frame":
            value += RANKING.frame_gain
        value = value * own.covered - denied(draft.mask, task)
        if task.tight and at_work("tight boxes"):
            value -= RANKING.short_loss * _short_of(draft.mask, box)
        graded.append((draft, float(value)))
    graded.sort(key=lambda scored: -scored[1])
    return [(draft, min(max(value, 0.0), 1.0)) for draft, value in graded]


def _short_of(mask: BoolArray, box: Box) -> float:
    """How far a mask ends before the sides of a box drawn around the thing, in shares of the box,
    summed over its sides; what a box may be drawn too wide by is none."""
    return sum(max(gap - RANKING.loose_share, 0.0) for gap in gaps(mask, box))


def gaps(mask: BoolArray, box: Box) -> tuple[float, float, float, float]:
    """How far a mask ends before the left, right, upper and lower side of a box, as its shares."""
    left, top, right, low = bounds(mask)
    wide, high = max(box[2] - box[0], 1.0), max(box[3] - box[1], 1.0)
    return (
        (left - box[0]) / wide, (box[2] - right) / wide,
        (top - box[1]) / high, (box[3] - low) / high,
    )  # fmt: skip


def denied(mask: BoolArray, task: Task) -> float:
    """What a mask loses for what it covers around a person's clicks outside.

    Around them: a cut leaves out the very spot that was clicked, if need be as a hole.
    """
    if not task.outside:
        return 0.0
    shares = []
    for x, y in task.outside:
        spot = cv2.circle(np.zeros(mask.shape, np.uint8), (int(x), int(y)), RANKING.spot_px, 1, -1)
        shares.append(float(mask[spot.astype(bool)].mean()) if spot.any() else 0.0)
    return RANKING.denied_loss * float(np.mean(shares))
