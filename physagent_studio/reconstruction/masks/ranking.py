"""Which drafts lead: what each shows by itself and how it lies in its box."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.draft_score import Draft, shown_by
from physagent_studio.reconstruction.masks.task import Task
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class RankingSettings:
    """What clicks outside cost a draft."""

    denied_loss: float = 0.5  # score, 0.1..1: of a draft that covers all of them
    spot_px: int = 8  # 2..20: of the view, about a click: a person points no better


RANKING = RankingSettings()


def ranked(
    lab: NDArray[np.float32], drafts: Sequence[Draft], task: Task, box: Box
) -> list[tuple[Draft, float]]:
    """Drafts in a box with their estimated IoU, from what each shows by itself, best first.

    Four weights, regressed on the reference outlines of 14 photographs and rounded; with each
    photograph left out in turn, drafts of .85 in the mean and .935 in the median are chosen.
    """
    area = max((box[2] - box[0]) * (box[3] - box[1]), 1.0)
    graded: list[tuple[Draft, float]] = []
    for draft, own in zip(drafts, shown_by(drafts, lab, task.inside), strict=True):
        value = 0.2 + 0.2 * fills(draft.mask, box) + 0.3 * own.weakest - 0.35 * own.overlap
        value += 0.5 * min(np.count_nonzero(draft.mask) / area, 1.0)
        value = value * own.covered - denied(draft.mask, task)
        graded.append((draft, float(np.clip(value, 0.0, 1.0))))
    return sorted(graded, key=lambda scored: -scored[1])


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


def fills(mask: BoolArray, box: Box) -> float:
    """How well a mask reaches all four sides of a box, 0 … 1."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = max(box[2] - box[0], 1.0), max(box[3] - box[1], 1.0)
    # Boxes are drawn a little wide: a gap of a twentieth on each side is none.
    gaps = np.array([(x0 - box[0]), (box[2] - x1)]) / width
    gaps = np.append(gaps, np.array([(y0 - box[1]), (box[3] - y1)]) / height)
    return float(np.prod(1 - np.clip(np.maximum(gaps - 0.06, 0), 0, 1)))
