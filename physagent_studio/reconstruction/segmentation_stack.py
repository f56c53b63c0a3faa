"""Things of one kind in a stack: found as one, then cut apart along the seams between them.

Books, boxes and slabs on one another look alike, and each is of several colours itself: alone, a
click on one finds its cover, or its neighbour. Together they are easy to tell from what is
around them, and as many seams as there are clicks less one run through the whole stack from side
to side. The lower rim of a block is seen as two straight lines that meet at its nearest corner,
so such bent lines are sought along edges and thin dark lines; those are taken that end where the
outline of the stack steps in, part layers of a sensible thickness, and lie between the clicks,
which may be a little off.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, pairwise

import cv2
import numpy as np
from scipy.optimize import linear_sum_assignment

from physagent_studio.program.scene import Click, Grounding
from physagent_studio.reconstruction.masks import BoolArray, Pixel, bounds, iou, shrink
from physagent_studio.reconstruction.names import words_of
from physagent_studio.reconstruction.seams import Seam, seams_of, settled
from physagent_studio.reconstruction.segmentation_task import View, part_around, view_of
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate

SIDE = 280
"""Longest side in pixels of the picture of a stack on which seams are found."""
FEWEST, LEAST = 3, 12
"""Things in a stack, and pixels of a layer, below which there is none."""
WHOLE, TWICE = 0.92, 1.1
"""IoU of what masks cover with the stack, and how often they do, from which they part it."""
SLIVER = 0.3
"""Share of its like's area below which a mask is a part of a thing, not one."""
METHOD = "stack"
WORST = 0.6
"""Cost of a seam from which there is none."""


def stacked(
    image: Image,
    groundings: Sequence[tuple[str, Grounding]],
    offers: Mapping[str, tuple[Candidate, ...]],
    whole: Callable[[Grounding], tuple[Candidate, ...]],
) -> dict[str, tuple[Candidate, ...]]:
    """The offers, led by layers for things of one kind in a stack whose own masks do not part it.

    whole: candidates for a grounding that holds the clicks on all of them.
    """
    out = {name: alone(own) for name, own in offers.items()}
    for names in _groups(groundings):
        said = dict(groundings)
        points = {name: next(c for c in said[name].points if c.label) for name in names}
        own = {name: out[name][0].mask for name in names if out.get(name)}
        found = whole(Grounding(points=tuple(points.values())))
        if not found or len(own) < len(names) or _parted(found[0].mask, list(own.values())):
            continue
        clicks = [(point.x, point.y) for point in points.values()]
        layers = layers_of(image, found[0].mask, clicks)
        for name, layer in zip(names, layers or (), strict=False):
            if np.count_nonzero(layer) > LEAST:
                out[name] = (Candidate(layer, out[name][0].score, METHOD), *out[name])
    return out


def alone(offers: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """The candidates that a thing's own clicks give."""
    return tuple(offer for offer in offers if offer.method != METHOD)


def _groups(groundings: Sequence[tuple[str, Grounding]]) -> list[list[str]]:
    """Names of three or more things of one kind that were clicked above one another."""
    kinds: dict[str, list[tuple[str, Click]]] = {}
    for name, said in groundings:
        inside = [click for click in said.points if click.label]
        plain = len(inside) == len(said.points) == 1 and said.box is None and not said.strokes
        if plain and not said.settled and not said.proposed:
            kinds.setdefault(words_of(name)[-1], []).append((name, inside[0]))
    return [
        [name for name, _ in members]
        for members in kinds.values()
        if len(members) >= FEWEST and _upright([(c.x, c.y) for _, c in members])
    ]


def _upright(clicks: Sequence[Pixel]) -> bool:
    """Whether clicks lie above one another rather than beside."""
    spots = np.array(sorted(clicks, key=lambda spot: spot[1]))
    step = np.diff(spots, axis=0)
    return bool(np.ptp(spots[:, 0]) < np.ptp(spots[:, 1]) and (step[:, 1] > 3).all())


def _parted(stack: BoolArray, masks: Sequence[BoolArray]) -> bool:
    """Whether masks are the parts of a stack already, or the stack is none."""
    count, _ = cv2.connectedComponents(shrink(stack, 1).astype(np.uint8))
    covered = np.any(masks, axis=0)
    areas = np.array([np.count_nonzero(mask) for mask in masks], float)
    shared = areas.sum() / max(int(np.count_nonzero(covered)), 1)
    alike = bool(areas.min() > SLIVER * np.median(areas))
    return count != 2 or (alike and iou(covered, stack) > WHOLE and bool(shared < TWICE))


def layers_of(image: Image, stack: BoolArray, clicks: Sequence[Pixel]) -> list[BoolArray] | None:
    """The layer (H, W) of a stack's mask that each click means; None where no seams are seen."""
    box = bounds(stack)
    if len(clicks) < 2 or box[2] - box[0] < 12 or box[3] - box[1] < 12:
        return None
    part = part_around((float(box[0]), float(box[1]), float(box[2]), float(box[3])), image.shape)
    view = view_of(image, part, SIDE)
    size = (view.lab.shape[1], view.lab.shape[0])
    crop = stack[part[1] : part[3], part[0] : part[2]].astype(np.float32)
    small = np.asarray(cv2.resize(crop, size, interpolation=cv2.INTER_AREA) > 0.5)
    points = [view.inward(x, y) for x, y in clicks]
    chosen = _chosen(seams_of(view.lab, small), small, points)
    if chosen is None or max(seam.cost for seam in chosen[0]) > WORST:
        return None
    layers = _cut(stack, [settled(seam, view.lab, small) for seam in chosen[0]], view, small)
    return [layers[k] for k in chosen[1]]


# --- the choice --------------------------------------------------------------------------------


def _chosen(
    seams: Sequence[Seam], stack: BoolArray, clicks: Sequence[Pixel]
) -> tuple[list[Seam], list[int]] | None:
    """The seams that part the stack, from the top down, and the layer of each click."""
    count = len(clicks) - 1
    if len(seams) < count:
        return None
    x0 = bounds(stack)[0]
    best, least = None, np.inf
    for some in combinations(sorted(seams, key=lambda s: float(s.rows.mean())), count):
        loss, layers = _loss(some, stack, clicks, x0)
        if loss < least:
            best, least = (list(some), layers), loss
    return best


def _loss(
    some: Sequence[Seam], stack: BoolArray, clicks: Sequence[Pixel], x0: int
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
    off = np.zeros((len(clicks), len(clicks)))
    for number, (x, y) in enumerate(clicks):
        k = int(np.clip(round(x) - x0, 0, len(some[0].rows) - 1))
        rims = np.array([-np.inf, *(seam.rows[k] for seam in some), np.inf])
        away = np.maximum(np.maximum(rims[:-1] - y, y - rims[1:]), 0.0) / usual
        off[number] = 1.2 * away**2 / (0.15 + away)
    _, layers = linear_sum_assignment(np.minimum(off, 50.0))
    loss += float(off[np.arange(len(clicks)), layers].sum())
    return loss, [int(k) for k in layers]


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
