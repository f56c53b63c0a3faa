"""Masks of a learned model among the embedded ones, ranked by the IoU expected of each."""

from collections.abc import Sequence

from physagent_studio.reconstruction.masks.choice import CHOICE
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.records.scene import Candidate


def ranked_together(
    embedded: Sequence[Candidate], learned: Sequence[Candidate]
) -> tuple[Candidate, ...]:
    """As many as a person is offered, best first; of two that are almost one the better is kept.

    Scores of both are expected IoUs, 0 … 1: ours of `draft_score`, the network's its own
    prediction. Where they are equal the embedded one leads.
    """
    if not learned:
        return tuple(embedded)
    out: list[Candidate] = []
    for one in sorted((*embedded, *learned), key=lambda candidate: -candidate.score):
        if len(out) < CHOICE.max_offers_count and all(
            iou(one.mask, other.mask) < CHOICE.same_ratio for other in out
        ):
            out.append(one)
    return tuple(out)
