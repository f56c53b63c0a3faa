"""How sure a mask is: the probability that it covers its thing with an IoU above .8.

A logistic function of what can be measured without knowing the thing: whether the candidates agree,
what the network shows that is given the mask's own box, whether the same colours go on beyond it,
whether what it encloses hangs together and has a usual shape. Weights for masks from clicks and for
masks from a box were fitted by `tools/fit_sureness.py`, which also says how well they are
calibrated on scenes that it keeps out of the fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.knowledge.things import usual_size
from physagent_studio.program.scene.state import Grounding, SceneObject
from physagent_studio.reconstruction.masks.draft_score import outline_contrast
from physagent_studio.reconstruction.masks.task import view_of
from physagent_studio.reconstruction.masks.thing_map import expected_iou, soft_iou, thing_map
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    bounds,
    grow,
    iou,
    resized,
    solidity,
)
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate, Finding, Scene

Features = dict[str, float]

# What is left out weighs less than .1. Clicks and boxes: 199 masks each, 125 of many-part things,
# 42 of things of one colour, 32 of stacks. The constants are .3 less than fitted: since any two
# drafts compete as one more, masks look surer than they are.
CLICK_WEIGHTS: Mapping[str, float] = {
    "constant": -0.83,
    "score": 2.75,
    "agreement": 1.01,
    "rival": -1.03,
    "larger": -1.24,
    "smaller": -1.50,
    "contrast": -0.91,
    "colours go on": -1.63,
    "mixed": -0.76,
    "solidity": -0.99,
    "scattered": 0.49,
    "size": 1.21,
    "size squared": 0.10,
    "odd proportions": -0.59,
    "off centre": -1.82,
    "seen again": 2.66,
    "clear": 1.24,
}
BOX_WEIGHTS: Mapping[str, float] = {
    "constant": -2.04,
    "score": 2.32,
    "agreement": 0.62,
    "rival": -0.22,
    "larger": -1.19,
    "contrast": -0.85,
    "colours go on": -2.02,
    "mixed": -1.21,
    "solidity": 2.03,
    "scattered": -0.96,
    "size": 1.10,
    "size squared": 1.05,
    "odd proportions": 0.57,
    "fills box": -0.65,
    "share of box": 1.28,
    "seen again": 3.01,
    "clear": 1.23,
}


@dataclass(frozen=True, slots=True)
class SurenessSettings:
    """What of a mask is measured."""

    look_side_px: int = 320  # 120..640: the longer side of the piece around it that is looked at
    look_margin_ratio: float = 0.6  # 0.2..1.5: of its longer side, what that piece shows around it
    # score, 0.02..0.5: by which a candidate is e times as likely as another, as in the choice
    likelier_by: float = 0.1
    # share, 0.2..0.8: of a box reached on its four sides, below which a mask is a part the surer
    least_fill_share: float = 0.5
    faint_probability: float = 0.45  # probability, 0.1..0.5: at most, of what hardly stands out
    board_probability: float = 0.3  # probability, 0.1..0.5: at most, of what no kind of shape shows
    other_reading_ratio: float = 0.8  # 0.5..0.95: IoU below which a candidate is another reading


SURENESS = SurenessSettings()


def sureness(
    image: Image,
    masks: Mapping[str, BoolArray],
    candidates: Mapping[str, Sequence[Candidate]],
    groundings: Sequence[tuple[str, Grounding]],
    previous: Scene | None = None,
) -> dict[str, float]:
    """The probability of each mask (H, W) that nobody chose or drew by hand.

    previous: an earlier scene of the picture; what it says of a mask is true of the same one.
    """
    known = {} if previous is None else _still_true(previous, masks, candidates, groundings)
    return {
        name: known[name]
        if name in known
        else probability(image, masks[name], candidates.get(name, ()), grounding, name)
        for name, grounding in groundings
        if name in masks and not is_chosen(grounding) and masks[name].any()
    }


def _still_true(
    previous: Scene,
    masks: Mapping[str, BoolArray],
    candidates: Mapping[str, Sequence[Candidate]],
    groundings: Sequence[tuple[str, Grounding]],
) -> dict[str, float]:
    """The probabilities of an earlier scene whose mask, candidates and marks are as they were."""
    before = {o.name: o.grounding for o in previous.state.objects if o.form != "board"}
    return {
        name: previous.sureness[name]
        for name, grounding in groundings
        if name in previous.sureness
        and name in masks
        and candidates.get(name) is previous.candidates.get(name)
        and before.get(name) == grounding
        and np.array_equal(masks[name], previous.masks[name])
    }


def doubting(
    sure: Mapping[str, float], objects: Sequence[SceneObject], failing: Sequence[Finding]
) -> dict[str, float]:
    """The probabilities with those doubted that hardly stand out, or are only boards."""
    faint = {one.subject for one in failing if one.name == "stands out" and not one.ok}
    least = dict.fromkeys(faint, SURENESS.faint_probability)
    least |= {o.name: SURENESS.board_probability for o in objects if o.form == "board"}
    return dict(sure) | {name: min(value, sure.get(name, 1.0)) for name, value in least.items()}


def is_chosen(grounding: Grounding) -> bool:
    """Whether a person has chosen this mask among the candidates, or corrected it.

    What the planner takes in place of a mask that fits badly is no surer for that.
    """
    return grounding.settled or bool(grounding.strokes)


def probability(
    image: Image, mask: BoolArray, offers: Sequence[Candidate], grounding: Grounding, name: str
) -> float:
    """The probability (0 … 1) that the IoU of a mask (H, W) with its thing is above .8."""
    weights = CLICK_WEIGHTS if grounding.box is None else BOX_WEIGHTS
    found = features(image, mask, offers, grounding, name)
    value = sum(weight * found[key] for key, weight in weights.items())
    sure = float(1.0 / (1.0 + np.exp(-np.clip(value, -12.0, 12.0))))
    # A part of a thing may look whole by itself; the box says where the thing ends.
    return sure * min(1.0, found.get("fills box", 1.0) / SURENESS.least_fill_share)


def features(
    image: Image, mask: BoolArray, offers: Sequence[Candidate], grounding: Grounding, name: str
) -> Features:
    """What is weighed of a mask, each about −1 … 1."""
    out = {"constant": 1.0}
    out |= _agreement(mask, offers)
    out |= _outline(image, mask)
    out |= _form(mask, name)
    out |= _marks(mask, grounding)
    out |= _again(image, mask)
    return out


def _again(image: Image, mask: BoolArray) -> Features:
    """What the network says that sees the mask's own box, as if a person had drawn it there."""
    x0, y0, x1, y1 = (float(side) for side in bounds(mask))
    seen = thing_map(image, Grounding(box=(x0, y0, x1, y1)))
    if seen is None:
        return {"seen again": 0.0, "clear": 0.0}
    size = (seen.chance.shape[1], seen.chance.shape[0])
    own = resized(mask, size) if size != mask.shape[::-1] else mask
    return {"seen again": soft_iou(own, seen.chance), "clear": expected_iou(seen.chance)}


def _agreement(mask: BoolArray, offers: Sequence[Candidate]) -> Features:
    """Whether the candidates show the same, and whether a larger or a smaller one is as likely."""
    if not offers:
        return {"score": 0.0, "agreement": 0.0, "rival": 1.0, "larger": 1.0, "smaller": 1.0}
    overlaps = np.array([iou(mask, offer.mask) for offer in offers])
    scores = np.array([offer.score for offer in offers])
    lead = float(scores[int(overlaps.argmax())])
    chance = np.exp((scores - scores.max()) / SURENESS.likelier_by)
    area = max(np.count_nonzero(mask), 1)
    larger = smaller = 0.0
    for offer, overlap in zip(offers, overlaps, strict=True):
        if overlap < SURENESS.other_reading_ratio:
            share = float(np.exp(min(offer.score - lead, 0.0) / SURENESS.likelier_by))
            bigger = np.count_nonzero(offer.mask) > area
            larger = max(larger, share) if bigger else larger
            smaller = smaller if bigger else max(smaller, share)
    return {
        "score": lead,
        "agreement": float((chance * overlaps).sum() / chance.sum()),
        "rival": max(larger, smaller),
        "larger": larger,
        "smaller": smaller,
    }


def _outline(image: Image, mask: BoolArray) -> Features:
    """Whether the outline runs along edges, and whether the colours inside go on beyond it."""
    x0, y0, x1, y1 = bounds(mask)
    margin = int(SURENESS.look_margin_ratio * max(x1 - x0, y1 - y0)) + 4
    height, width = mask.shape
    left, top = max(0, x0 - margin), max(0, y0 - margin)
    right, bottom = min(width, x1 + margin), min(height, y1 + margin)
    view = view_of(image, (left, top, right, bottom), SURENESS.look_side_px)
    own = mask[top:bottom, left:right].astype(np.uint8)
    size = (view.lab.shape[1], view.lab.shape[0])
    small = cv2.resize(own, size, interpolation=cv2.INTER_AREA).astype(bool)
    if not small.any():
        return {"contrast": 0.0, "colours go on": 1.0, "mixed": 0.0}
    middle = outline_contrast(view.lab, small)
    inside, ring = _palettes(view.lab, small)
    return {
        "contrast": float(np.tanh(middle / 25)),
        "colours go on": float(np.sqrt(inside * ring).sum()),
        "mixed": float(1.0 - (inside**2).sum()),
    }


def _palettes(lab: NDArray[np.float32], mask: BoolArray) -> tuple[NDArray, NDArray]:
    """Shares of 512 colours inside the mask, and in a ring around it."""
    bins = np.clip((lab / 256 * 8).astype(int), 0, 7)
    index = (bins[..., 0] * 8 + bins[..., 1]) * 8 + bins[..., 2]
    reach = max(4, int(np.sqrt(np.count_nonzero(mask)) * 0.25))
    ring = grow(mask, reach) & ~grow(mask, 2)
    inside = np.bincount(index[mask], minlength=512) / max(np.count_nonzero(mask), 1)
    return inside, np.bincount(index[ring], minlength=512) / max(np.count_nonzero(ring), 1)


def _form(mask: BoolArray, name: str) -> Features:
    """Whether what it encloses hangs together, is compact, and has the name's usual proportions."""
    count, _, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    area = max(np.count_nonzero(mask), 1)
    largest = max((int(s[cv2.CC_STAT_AREA]) for s in stats[1:count]), default=0)
    x0, y0, x1, y1 = bounds(mask)
    aspect = usual_size(name).aspect
    odd = 0.0
    if aspect is not None:
        odd = abs(np.log(max(y1 - y0, 1) / max(x1 - x0, 1) / aspect[0])) / (aspect[1] + 0.1)
    share = float(np.log10(area / mask.size + 1e-5))
    return {
        "solidity": solidity(mask),
        "scattered": 1.0 - largest / area,
        "size": share / 2.0 + 1.0,
        "size squared": (share / 2.0 + 1.0) ** 2,
        "odd proportions": float(min(odd, 3.0) / 3.0),
    }


def _marks(mask: BoolArray, grounding: Grounding) -> Features:
    """How the mask lies about the clicks or within the box."""
    x0, y0, x1, y1 = bounds(mask)
    inside = [click for click in grounding.points if click.label]
    off = 0.0
    if inside:
        across = np.mean([c.x for c in inside]) - (x0 + x1) / 2
        along = np.mean([c.y for c in inside]) - (y0 + y1) / 2
        off = float(np.hypot(across / max(x1 - x0, 1), along / max(y1 - y0, 1)))
    out = {"off centre": min(off, 1.0)}
    if grounding.box is not None:
        left, top, right, bottom = grounding.box
        room = max((right - left) * (bottom - top), 1.0)
        out["fills box"] = _fills(mask, grounding.box)
        out["share of box"] = min(np.count_nonzero(mask) / room, 1.0)
    return out


def _fills(mask: BoolArray, box: tuple[float, float, float, float]) -> float:
    """How well a mask reaches all four sides of a box, 0 … 1."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = max(box[2] - box[0], 1.0), max(box[3] - box[1], 1.0)
    # Boxes are drawn a little wide: a gap of a twentieth on each side is none.
    gaps = np.array([(x0 - box[0]), (box[2] - x1)]) / width
    gaps = np.append(gaps, np.array([(y0 - box[1]), (box[3] - y1)]) / height)
    return float(np.prod(1 - np.clip(np.maximum(gaps - 0.06, 0), 0, 1)))
