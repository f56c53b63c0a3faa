"""Which of many drafts a person is offered: the likeliest, then what makes up for its mistakes.

Scores say how likely each draft is the thing. After the first, that one is offered which raises
the expected IoU of the best on offer the most: where a part, the whole and a group of things are
all likely, each is there, instead of four readings of the likeliest.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.draft_score import Draft, likeness
from physagent_studio.reconstruction.masks.variants import shadowed, variants
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.reconstruction.switches import at_work

Scored = tuple[Draft, float]


@dataclass(frozen=True, slots=True)
class ChoiceSettings:
    """How many masks are offered, and which of them are worth it."""

    max_offers_count: int = 4  # 2..8: as many as are told apart at a glance
    same_ratio: float = 0.95  # 0.8..1: IoU from which two need not both be offered
    # score, 0.02..0.5: by which a draft is e times as likely as another, as scores err by it
    likelier_by: float = 0.1
    min_gain_ratio: float = 0.004  # 0..0.05: IoU expected of another offer, less is not worth it


CHOICE = ChoiceSettings()


def agreed(ranked: Sequence[Scored], lab: NDArray[np.float32]) -> list[Scored]:
    """Up to four drafts that differ, the best first.

    Where methods agree, other readings of the first are offered (lab (H, W, 3)).
    """
    if not ranked:
        return []
    like = likeness([draft for draft, _ in ranked])
    scores = np.array([value for _, value in ranked])
    out: list[Scored] = []
    for k in _hopeful(like, scores):
        draft, value = ranked[k]
        if _differs(draft, out):
            out.append((draft, min(value, out[-1][1]) if out else value))
    return _filled_up(out, lab)


def _hopeful(like: NDArray[np.float64], scores: NDArray[np.float64]) -> list[int]:
    """Up to four drafts such that the best of them is expected to fit well, each by its gain.

    like: (N, N) IoU of any two. Each draft is taken to be the thing with a chance that its score
    says; what is expected of some is the mean IoU of the best of them with it. Greedily chosen.
    """
    if not at_work("expected gain"):
        return [int(k) for k in np.argsort(-scores, kind="stable")[: CHOICE.max_offers_count]]
    chance = np.exp((scores - scores.max()) / CHOICE.likelier_by)
    chance /= chance.sum()
    chosen = [int(scores.argmax())]
    reached = like[chosen[0]]
    while len(chosen) < CHOICE.max_offers_count:
        gain = np.maximum(like - reached, 0) @ chance
        gain[(like[chosen] >= CHOICE.same_ratio).any(axis=0)] = 0.0
        best = int(gain.argmax())
        if gain[best] < CHOICE.min_gain_ratio:
            break
        chosen.append(best)
        reached = np.maximum(reached, like[best])
    return chosen


def _filled_up(chosen: list[Scored], lab: NDArray[np.float32]) -> list[Scored]:
    """Where few drafts are worth a place, variants of the first."""
    if not at_work("variants"):
        return chosen
    first, value = chosen[0]
    for draft in variants(lab, first) if len(chosen) < CHOICE.max_offers_count else ():
        if len(chosen) == CHOICE.max_offers_count:
            break
        if _differs(draft, chosen) and np.count_nonzero(draft.mask) > 12:
            chosen.append((draft, min(0.5 * value, chosen[-1][1])))
    return _with_shade(chosen, lab)


def _with_shade(chosen: list[Scored], lab: NDArray[np.float32]) -> list[Scored]:
    """The choice with the first mask and its shadow in it: in place of the last, if need be."""
    shaded = shadowed(lab, chosen[0][0]) if len(chosen) == CHOICE.max_offers_count else None
    if shaded is None or not _differs(shaded, chosen):
        return chosen
    return [*chosen[:-1], (shaded, chosen[-1][1])]


def _differs(draft: Draft, chosen: Sequence[Scored]) -> bool:
    return all(iou(draft.mask, other.mask) < CHOICE.same_ratio for other, _ in chosen)
