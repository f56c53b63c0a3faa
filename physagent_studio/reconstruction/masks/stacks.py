"""Things of one kind in a stack: found as one, then cut apart along the seams between them.

Books, boxes and slabs on one another look alike, and each is of several colours itself: alone, a
click on one finds its cover, or its neighbour. Together they are easy to tell from what is
around them, and as many seams as there are clicks less one run through the whole stack from side
to side. The lower rim of a block is seen as two straight lines that meet at its nearest corner,
so such bent lines are sought along edges and thin dark lines; those are taken that end where the
outline of the stack steps in, part layers of a sensible thickness, and lie between the clicks,
which may be a little off.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import cv2
import numpy as np
from scipy.optimize import linear_sum_assignment

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.grounding.same_kind import kind_name
from physagent_studio.reconstruction.masks.stack_seams import Seam, seams_of, settled
from physagent_studio.reconstruction.masks.task import View, part_around, view_of
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, iou, shrink
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate

METHOD = "stack"


@dataclass(frozen=True, slots=True)
class StackSettings:
    """What a stack is, and when it is parted."""

    side_px: int = 280  # 140..560: its longer side on the picture on which seams are found
    min_layers_count: int = 3  # 2..6: two things above one another are told apart by themselves
    min_layer_px: int = 12  # 4..100: less of a layer is none
    parted_ratio: float = 0.92  # 0.7..1: IoU of what masks cover with the stack that they part
    max_covered_ratio: float = 1.1  # 1..1.5: of their areas and what they cover, likewise
    min_alike_share: float = 0.3  # 0.1..0.8: of its like's area; below, a mask is a part of a thing
    min_box_ratio: float = 0.6  # 0.3..0.9: IoU of a layer's bounds with the box drawn for it
    max_seam_cost: float = 0.6  # cost, 0.2..1: beyond, nothing is seen to part there


STACK = StackSettings()


@dataclass(frozen=True, slots=True)
class Mark:
    """Where a layer is: a pixel of it, and the rows (top, low) of a box around it, if drawn."""

    x: float
    y: float
    rows: tuple[float, float] | None = None


def stacked(
    image: Image,
    groundings: Sequence[tuple[str, Grounding]],
    offers: Mapping[str, tuple[Candidate, ...]],
    whole: Callable[[Grounding], BoolArray | None],
) -> dict[str, tuple[Candidate, ...]]:
    """The offers, led by layers for things of one kind in a stack whose own masks do not part it.

    whole: the mask (H, W) for one of `stacks_of`, a grounding that means all of them.
    """
    out = {name: alone(own) for name, own in offers.items()}
    said = dict(groundings)
    for spots in _groups(groundings):
        names = list(spots)
        own = {name: out[name][0].mask for name in names if out.get(name)}
        found = whole(_together([said[name] for name in names]))
        if found is None or len(own) < len(names) or _parted(found, list(own.values())):
            continue
        layers = layers_of(image, found, list(spots.values()))
        if layers is None or not _in_boxes(layers, [said[name].box for name in names]):
            continue
        for name, layer in zip(names, layers, strict=True):
            if np.count_nonzero(layer) > STACK.min_layer_px:
                out[name] = (Candidate(layer, out[name][0].score, METHOD), *out[name])
    return out


def stacks_of(groundings: Sequence[tuple[str, Grounding]]) -> list[Grounding]:
    """For each stack that is marked, one grounding that means all of its layers."""
    said = dict(groundings)
    return [_together([said[name] for name in spots]) for spots in _groups(groundings)]


def companions(groundings: Sequence[tuple[str, Grounding]], name: str) -> tuple[str, ...]:
    """The things marked as layers of one stack with that of a name, itself included; or none."""
    found = (tuple(spots) for spots in _groups(groundings) if name in spots)
    return next(found, ())


def alone(offers: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """The candidates that a thing's own clicks give."""
    return tuple(offer for offer in offers if offer.method != METHOD)


def _groups(groundings: Sequence[tuple[str, Grounding]]) -> list[dict[str, Mark]]:
    """Names and spots of three or more things of one kind that are marked above one another."""
    kinds: dict[tuple[str, bool], dict[str, Mark]] = {}
    for name, said in groundings:
        inside = [click for click in said.points if click.label]
        mark = None
        if said.box is not None:
            x0, y0, x1, y1 = said.box
            mark = Mark((x0 + x1) / 2, (y0 + y1) / 2, (y0, y1))
        elif len(inside) == len(said.points) == 1:
            mark = Mark(inside[0].x, inside[0].y)
        if mark is not None and not (said.strokes or said.settled or said.proposed):
            kind = kind_name(name).split()[-1]
            kinds.setdefault((kind, said.box is not None), {})[name] = mark
    found = [spots for spots in kinds.values() if len(spots) >= STACK.min_layers_count]
    found = [spots for spots in found if _upright(list(spots.values()))]
    return found if found and at_work("stacks") else []


def _in_boxes(
    layers: Sequence[BoolArray], boxes: Sequence[tuple[float, float, float, float] | None]
) -> bool:
    """Whether each layer fills the box that was drawn for it, where there is one."""
    for layer, box in zip(layers, boxes, strict=True):
        if box is None:
            continue
        drawn = np.zeros_like(layer)
        drawn[int(box[1]) : int(np.ceil(box[3])), int(box[0]) : int(np.ceil(box[2]))] = True
        x0, y0, x1, y1 = bounds(layer)
        reach = np.zeros_like(layer)
        reach[y0:y1, x0:x1] = True
        if iou(drawn, reach) < STACK.min_box_ratio:
            return False
    return True


def _upright(marks: Sequence[Mark]) -> bool:
    """Whether marks lie above one another rather than beside."""
    spots = np.array(sorted(((mark.x, mark.y) for mark in marks), key=lambda spot: spot[1]))
    step = np.diff(spots, axis=0)
    return bool(np.ptp(spots[:, 0]) < np.ptp(spots[:, 1]) and (step[:, 1] > 3).all())


def _together(said: Sequence[Grounding]) -> Grounding:
    """One grounding that means all of them."""
    points = tuple(click for item in said for click in item.points if click.label)
    boxes = np.array([item.box for item in said if item.box is not None])
    if not len(boxes):
        return Grounding(points=points)
    x, y = boxes[:, ::2], boxes[:, 1::2]
    box = (float(x.min()), float(y.min()), float(x.max()), float(y.max()))
    return Grounding(points=points, box=box)


def _parted(stack: BoolArray, masks: Sequence[BoolArray]) -> bool:
    """Whether masks are the parts of a stack already, or the stack is none."""
    count, _ = cv2.connectedComponents(shrink(stack, 1).astype(np.uint8))
    covered = np.any(masks, axis=0)
    areas = np.array([np.count_nonzero(mask) for mask in masks], float)
    shared = areas.sum() / max(int(np.count_nonzero(covered)), 1)
    alike = bool(areas.min() > STACK.min_alike_share * np.median(areas))
    return count != 2 or (
        alike
        and iou(covered, stack) > STACK.parted_ratio
        and bool(shared < STACK.max_covered_ratio)
    )


def layers_of(image: Image, stack: BoolArray, marks: Sequence[Mark]) -> list[BoolArray] | None:
    """The layer (H, W) of a stack's mask that each mark means; None where no seams are seen."""
    box = bounds(stack)
    if len(marks) < 2 or box[2] - box[0] < 12 or box[3] - box[1] < 12:
        return None
    part = part_around((float(box[0]), float(box[1]), float(box[2]), float(box[3])), image.shape)
    view = view_of(image, part, STACK.side_px)
    size = (view.lab.shape[1], view.lab.shape[0])
    crop = stack[part[1] : part[3], part[0] : part[2]].astype(np.float32)
    small = np.asarray(cv2.resize(crop, size, interpolation=cv2.INTER_AREA) > 0.5)
    inward = [_inward(mark, view) for mark in marks]
    chosen = _chosen(seams_of(view.lab, small), small, inward)
    if chosen is None or max(seam.cost for seam in chosen[0]) > STACK.max_seam_cost:
        return None
    layers = _cut(stack, [settled(seam, view.lab, small) for seam in chosen[0]], view, small)
    return [layers[k] for k in chosen[1]]


def _inward(mark: Mark, view: View) -> Mark:
    x, y = view.inward(mark.x, mark.y)
    if mark.rows is None:
        return Mark(x, y)
    return Mark(x, y, (view.inward(0, mark.rows[0])[1], view.inward(0, mark.rows[1])[1]))


# --- the choice --------------------------------------------------------------------------------


def _chosen(
    seams: Sequence[Seam], stack: BoolArray, marks: Sequence[Mark]
) -> tuple[list[Seam], list[int]] | None:
    """The seams that part the stack, from the top down, and the layer of each mark."""
    count = len(marks) - 1
    if len(seams) < count:
        return None
    x0 = bounds(stack)[0]
    best, least = None, np.inf
    for some in combinations(sorted(seams, key=lambda s: float(s.rows.mean())), count):
        loss, layers = _loss(some, stack, marks, x0)
        if loss < least:
            best, least = (list(some), layers), loss
    return best


def _loss(
    some: Sequence[Seam], stack: BoolArray, marks: Sequence[Mark], x0: int
) -> tuple[float, list[int]]:
    loss = 2.0 * sum(seam.cost for seam in some)
    columns = np.flatnonzero(stack.any(0))
    inner = columns[len(columns) // 5 : -len(columns) // 5 or None]
    for one, other in pairwise(some):
        loss += 3.0 * float(np.mean((other.rows - one.rows < 2)[inner - x0]))
    top = stack[:, inner].argmax(0)
    low = len(stack) - stack[::-1, inner].argmax(0)
    rows = np.stack([top, *(seam.rows[inner - x0] for seam in some), low]).astype(float)
    thick = np.maximum(np.median(np.diff(rows, axis=0), axis=1), 1.0)
    loss += 0.35 * float(np.var(np.log(thick))) * len(thick)
    usual = float(np.median(thick))
    away = np.stack([_away(mark, some, stack, x0) for mark in marks]) / usual
    off = 1.2 * away**2 / (0.15 + away)
    _, layers = linear_sum_assignment(np.minimum(off, 50.0))
    loss += float(off[np.arange(len(marks)), layers].sum())
    return loss, [int(k) for k in layers]


def _away(mark: Mark, some: Sequence[Seam], stack: BoolArray, x0: int) -> FloatArray:
    """(N,) how many rows a mark lies beside each layer, or its box is off the layer's bounds."""
    if mark.rows is None:
        k = int(np.clip(round(mark.x) - x0, 0, len(some[0].rows) - 1))
        rims = np.array([-np.inf, *(seam.rows[k] for seam in some), np.inf])
        return np.maximum(np.maximum(rims[:-1] - mark.y, mark.y - rims[1:]), 0.0)
    _, y0, x1, y1 = bounds(stack)
    columns = np.arange(x0, x1)
    held = [
        seam.rows[stack[np.clip(seam.rows.round().astype(int), 0, len(stack) - 1), columns]]
        for seam in some
    ]
    tops = np.array([y0, *(rows.min(initial=np.inf) for rows in held)])
    lows = np.array([*(rows.max(initial=-np.inf) for rows in held), y1])
    return np.minimum(np.abs(tops - mark.rows[0]) + np.abs(lows - mark.rows[1]), 1e3)


def _cut(stack: BoolArray, seams: Sequence[Seam], view: View, small: BoolArray) -> list[BoolArray]:
    """The stack's pixels at full size, by the seams that they lie between."""
    x0, y0, x1, y1 = view.part
    columns = (np.arange(x1 - x0) + 0.5) * view.factor - 0.5 - bounds(small)[0]
    number = np.zeros((y1 - y0, x1 - x0), np.int64)
    rows = (np.arange(y1 - y0) + 0.5)[:, None]
    for seam in seams:
        at = np.interp(columns, np.arange(len(seam.rows)), seam.rows + 0.5)
        number += rows > at[None] / view.factor
    out: list[BoolArray] = []
    for k in range(len(seams) + 1):
        layer = np.zeros_like(stack)
        layer[y0:y1, x0:x1] = stack[y0:y1, x0:x1] & (number == k)
        out.append(layer)
    return out
