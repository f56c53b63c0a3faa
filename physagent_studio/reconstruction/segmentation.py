"""Masks from clicks and boxes: several methods offer candidates, the objects compete.

Every object gets up to four candidate masks, best first, so that a person can take another
one. Everything is seeded: the same picture and clicks give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene import Grounding
from physagent_studio.reconstruction import contour, grabcut
from physagent_studio.reconstruction.masks import (
    BoolArray,
    Pixel,
    bounds,
    grow,
    holding,
    iou,
    resized,
    shrink,
    smooth,
    without_pinholes,
)
from physagent_studio.reconstruction.maskscore import Draft, Scorer, window_share
from physagent_studio.reconstruction.names import usual_size
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate

SIDE = 240
"""Longest side in pixels of the picture on which candidates are found."""
CANDIDATES = 4


class Segmenter(Protocol):
    """Turns clicks and boxes into candidate masks, best first, for each named thing."""

    def segment(
        self,
        image: Image,
        groundings: Sequence[tuple[str, Grounding]],
        cancelled: Callable[[], bool] | None = None,
    ) -> dict[str, tuple[Candidate, ...]]: ...


@dataclass(frozen=True, eq=False, slots=True)
class _Task:
    """One thing to segment, in pixels of the small picture."""

    inside: tuple[Pixel, ...]
    outside: tuple[Pixel, ...]
    box: tuple[float, float, float, float] | None
    aspect: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class EmbeddedSegmenter:
    """GrabCut at several scales, the contour of greatest contrast, and their agreement."""

    side: int = SIDE

    def segment(
        self,
        image: Image,
        groundings: Sequence[tuple[str, Grounding]],
        cancelled: Callable[[], bool] | None = None,
    ) -> dict[str, tuple[Candidate, ...]]:
        """Candidates (H, W) at the size of `image`; empty where nothing was clicked."""
        whole = _view(image, (0, 0, image.shape[1], image.shape[0]), self.side)
        out: dict[str, tuple[Candidate, ...]] = {}
        for name, grounding in groundings:
            if cancelled is not None and cancelled():
                return out
            box = grounding.box
            view = whole if box is None else _view(image, _around(box, image.shape), self.side)
            task = _task(name, groundings, view)
            if not task.inside and task.box is None:
                out[name] = ()
                continue
            scorer = Scorer(view.lab, task.inside)
            ranked = _ranked(scorer, _drafts(view.small, view.lab, task, scorer), task)
            out[name] = tuple(_full_size(image, item, view) for item in _agreed(ranked))
        return out


@dataclass(frozen=True, eq=False, slots=True)
class _View:
    """A part of the picture at working size: (x0, y0, x1, y1) of the part and the factor."""

    part: tuple[int, int, int, int]
    factor: float
    small: NDArray[np.uint8]
    lab: NDArray[np.float32]

    def inward(self, x: float, y: float) -> Pixel:
        """A pixel of the picture as one of the view."""
        return (x - self.part[0]) * self.factor, (y - self.part[1]) * self.factor


def _view(image: Image, part: tuple[int, int, int, int], side: int) -> _View:
    x0, y0, x1, y1 = part
    crop = image[y0:y1, x0:x1]
    factor = min(1.5, side / max(crop.shape[:2]))
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    small = cv2.resize(crop, None, fx=factor, fy=factor, interpolation=how)
    small = np.ascontiguousarray(small).astype(np.uint8)
    lab = cv2.cvtColor(cv2.bilateralFilter(small, 5, 30, 5), cv2.COLOR_RGB2LAB)
    return _View(part, factor, small, lab.astype(np.float32))


def _around(
    box: tuple[float, float, float, float], shape: tuple[int, ...]
) -> tuple[int, int, int, int]:
    """A person's box with its surroundings, which say what the background looks like."""
    x0, x1 = sorted((box[0], box[2]))
    y0, y1 = sorted((box[1], box[3]))
    margin = 0.35 * max(x1 - x0, y1 - y0) + 8
    low_x, low_y = max(0, int(x0 - margin)), max(0, int(y0 - margin))
    high_x = min(shape[1], int(x1 + margin) + 1)
    high_y = min(shape[0], int(y1 + margin) + 1)
    return low_x, low_y, max(high_x, low_x + 8), max(high_y, low_y + 8)


def _task(name: str, groundings: Sequence[tuple[str, Grounding]], view: _View) -> _Task:
    """The clicks of one thing; those inside the others lie outside of it."""
    inside: list[Pixel] = []
    outside: list[Pixel] = []
    box = None
    for other, grounding in groundings:
        for click in grounding.points:
            pixel = view.inward(click.x, click.y)
            if other == name:
                (inside if click.label else outside).append(pixel)
            elif click.label:
                outside.append(pixel)
        if other == name and grounding.box is not None:
            (x0, y0), (x1, y1) = (view.inward(*grounding.box[k : k + 2]) for k in (0, 2))
            box = (min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))
    rows, columns = view.lab.shape[:2]
    outside = [(x, y) for x, y in outside if 0 <= x < columns and 0 <= y < rows]
    return _Task(tuple(inside), tuple(outside), box, usual_size(name).aspect)


def _drafts(
    small: NDArray[np.uint8], lab: NDArray[np.float32], task: _Task, scorer: Scorer
) -> list[Draft]:
    if task.box is not None:
        return _box_drafts(small, lab, task, task.box, scorer)
    windows = grabcut.at_scales(small, lab, task.inside, task.outside)
    drafts: list[Draft] = []
    cleaned = [_clean(window.mask, task) for window in windows]
    for k, (window, mask) in enumerate(zip(windows, cleaned, strict=True)):
        if np.count_nonzero(mask) < 30:
            continue
        share = window_share(mask, window.box)
        drafts.append(Draft(mask, f"grabcut-{k}", "colour", share))
    contours = _contours(lab, task, drafts, scorer)
    return drafts + contours + _recoloured(small, task, contours, scorer)


def _contours(
    lab: NDArray[np.float32], task: _Task, drafts: Sequence[Draft], scorer: Scorer
) -> list[Draft]:
    """Contours around the clicks' middle, then again from the middles of the best masks."""
    middle = np.array(task.inside).mean(0)
    start: Pixel = (float(middle[0]), float(middle[1]))
    out = _as_drafts(contour.around(lab, start, task.outside), "contour", task)
    for turn in range(2):
        best = _distinct(_ranked(scorer, [*drafts, *out], task), 5 if turn == 0 else 3, 0.85)
        for draft, _ in best:
            name = f"contour-again-{turn}"
            out += _as_drafts(contour.again(lab, draft.mask, task.outside), name, task)
        for draft, _ in best[:2]:
            grown = contour.beyond(lab, draft.mask, task.outside)
            out += _as_drafts(grown, f"contour-beyond-{turn}", task)
    return out


def _as_drafts(masks: Iterator[BoolArray], method: str, task: _Task) -> list[Draft]:
    """Different masks that hold the clicks."""
    out: list[Draft] = []
    for mask in masks:
        part = holding(mask, task.inside)
        if np.count_nonzero(part) > 40 and all(iou(part, d.mask) < 0.97 for d in out):
            out.append(Draft(part, method, "contour"))
    return out


def _recoloured(
    small: NDArray[np.uint8], task: _Task, drafts: Sequence[Draft], scorer: Scorer
) -> list[Draft]:
    """The best contours with their outline settled by colour."""
    out: list[Draft] = []
    for draft, _ in _distinct(_ranked(scorer, drafts, task), 4, 0.9):
        band = max(2, round(0.08 * float(np.sqrt(np.count_nonzero(draft.mask)))))
        mask = _clean(_settled(small, draft.mask, band, 0.6), task)
        if np.count_nonzero(mask) > 30:
            out.append(Draft(mask, f"{draft.method}-colour", "contour"))
    return out


def _box_drafts(
    small: NDArray[np.uint8],
    lab: NDArray[np.float32],
    task: _Task,
    box: tuple[float, float, float, float],
    scorer: Scorer,
) -> list[Draft]:
    """Drafts inside a person's box."""
    x0, y0, x1, y1 = box
    rows, columns = lab.shape[:2]
    within = np.zeros((rows, columns), bool)
    within[max(0, int(y0)) : int(np.ceil(y1)) + 1, max(0, int(x0)) : int(np.ceil(x1)) + 1] = True
    around = grow(within, max(4, int(0.15 * max(x1 - x0, y1 - y0)))) & ~within
    ratio = grabcut.likelihood_ratio(lab, within, around) if around.any() else None
    cores: dict[str, BoolArray | None] = {"box": None}
    if ratio is not None:
        cores |= {"box-colour": ratio > 0, "box-sure": ratio > 1.0}
    drafts: list[Draft] = []
    for method, core in cores.items():
        mask = grabcut.in_box(small, box, task.inside, task.outside, core)
        if mask is not None:
            # A box says that all of its object lies inside: loose parts may belong to it.
            drafts.append(Draft(_tidy(mask) & within, method, "colour"))
            if task.inside:
                drafts.append(Draft(_clean(mask, task) & within, f"{method}-part", "colour"))
    contours = [
        Draft(mask & within, "box-contour", "contour")
        for mask in contour.again(lab, within, task.outside)
    ]
    best = [d for d, _ in _distinct(_ranked(scorer, _solid([*drafts, *contours]), task), 3, 0.9)]
    for draft in best:
        for mask in contour.again(lab, draft.mask, task.outside):
            contours.append(Draft(mask & within, "box-contour-again", "contour"))
    drafts += contours
    for draft in [d for d, _ in _distinct(_ranked(scorer, _solid(drafts), task), 3, 0.9)]:
        band = max(2, round(0.06 * float(np.sqrt(np.count_nonzero(draft.mask)))))
        mask = _tidy(_settled(small, draft.mask, band, 0.6)) & within
        drafts.append(Draft(mask, f"{draft.method}-settled", draft.family))
    return _solid(drafts)


def _solid(drafts: Sequence[Draft]) -> list[Draft]:
    return [draft for draft in drafts if np.count_nonzero(draft.mask) >= 30]


def _tidy(mask: BoolArray) -> BoolArray:
    """The mask without specks smaller than a fiftieth of its largest part."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    if count < 2:
        return mask
    areas = stats[1:, cv2.CC_STAT_AREA]
    kept = 1 + np.flatnonzero(areas > 0.02 * areas.max())
    return without_pinholes(np.isin(labels, kept), 0.01)


def _clean(mask: BoolArray, task: _Task) -> BoolArray:
    """The clicked part, without hairs, its small holes filled."""
    part = holding(mask, task.inside)
    part = without_pinholes(smooth(part), 0.02)
    return holding(part, task.inside)


def _ranked(scorer: Scorer, drafts: Sequence[Draft], task: _Task) -> list[tuple[Draft, float]]:
    graded = scorer.scores(drafts)
    if task.aspect is not None:
        graded = graded - _odd_proportions(drafts, task.aspect)
    if task.box is not None:
        graded = 0.5 * graded + 0.5 * np.array([_fills(draft.mask, task.box) for draft in drafts])
    order = np.argsort(-graded, kind="stable")
    return [(drafts[int(k)], float(graded[k])) for k in order]


def _fills(mask: BoolArray, box: tuple[float, float, float, float]) -> float:
    """How well a mask reaches all four sides of a box, 0 … 1."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = max(box[2] - box[0], 1.0), max(box[3] - box[1], 1.0)
    # Boxes are drawn a little wide: a gap of a twentieth on each side is none.
    gaps = np.array([(x0 - box[0]), (box[2] - x1)]) / width
    gaps = np.append(gaps, np.array([(y0 - box[1]), (box[3] - y1)]) / height)
    return float(np.prod(1 - np.clip(np.maximum(gaps - 0.06, 0), 0, 1)))


def _odd_proportions(drafts: Sequence[Draft], aspect: tuple[float, float]) -> NDArray[np.float64]:
    """What drafts lose whose height over width is unusual for the name."""
    usual, spread = aspect
    out = np.zeros(len(drafts))
    for k, draft in enumerate(drafts):
        x0, y0, x1, y1 = bounds(draft.mask)
        off = np.log(max(y1 - y0, 1) / max(x1 - x0, 1) / usual) / (spread + 0.1)
        out[k] = 0.04 * min(float(off) ** 2, 4.0)
    return out


def _agreed(ranked: Sequence[tuple[Draft, float]]) -> list[tuple[Draft, float]]:
    """The ranking with each leading draft replaced by the vote of those that are like it."""
    leaders = _distinct(ranked, CANDIDATES, 0.8)
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


def _distinct(
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


def _full_size(image: Image, item: tuple[Draft, float], view: _View) -> Candidate:
    """The draft at the picture's size, its outline settled there by GrabCut in a band."""
    draft, value = item
    x0, y0, x1, y1 = view.part
    rough = np.zeros(image.shape[:2], bool)
    rough[y0:y1, x0:x1] = resized(draft.mask, (x1 - x0, y1 - y0))
    mask = _settled(image, rough, max(2, round(1.6 / view.factor)))
    return Candidate(mask, value, draft.method)


def _settled(image: Image, mask: BoolArray, band: int, least: float = 0.85) -> BoolArray:
    """The outline moved within `band` pixels to where the colours part.

    The mask as it was if less than `least` of it (IoU) would be left.
    """
    outer, inner = grow(mask, band), shrink(mask, band)
    rows, columns = np.flatnonzero(outer.any(1)), np.flatnonzero(outer.any(0))
    if not len(rows):
        return mask
    pad = 3 * band + 8
    crop = (
        slice(max(0, rows[0] - pad), rows[-1] + pad + 1),
        slice(max(0, columns[0] - pad), columns[-1] + pad + 1),
    )
    trimap = np.full(mask.shape, cv2.GC_BGD, np.uint8)
    trimap[outer] = cv2.GC_PR_BGD
    trimap[mask] = cv2.GC_PR_FGD
    trimap[inner] = cv2.GC_FGD
    part = grabcut.cut(
        np.ascontiguousarray(image[crop]), np.ascontiguousarray(trimap[crop]), rounds=1
    )
    if part is None:
        return mask
    out = np.zeros_like(mask)
    out[crop] = part
    # Where the band held no edge, GrabCut frays the outline: keep what changed little.
    return out if iou(out, mask) > least else mask


def compete(masks: Mapping[str, BoolArray]) -> dict[str, BoolArray]:
    """Every pixel belongs to one object: where masks overlap, the smaller one keeps it."""
    order = sorted(masks, key=lambda name: int(np.count_nonzero(masks[name])))
    taken: BoolArray | None = None
    out: dict[str, BoolArray] = {}
    for name in order:
        mask = masks[name]
        free = mask if taken is None else mask & ~taken
        out[name] = free
        taken = free.copy() if taken is None else taken | free
    return {name: out[name] for name in masks}


def choose(
    candidates: Mapping[str, tuple[Candidate, ...]],
    groundings: Sequence[tuple[str, Grounding]],
    shape: tuple[int, int],
) -> dict[str, BoolArray]:
    """The chosen candidate of each object (`Grounding.candidate`), after competition."""
    picked: dict[str, BoolArray] = {}
    for name, grounding in groundings:
        offers = candidates.get(name, ())
        index = min(grounding.candidate, len(offers) - 1)
        picked[name] = offers[index].mask if offers else np.zeros(shape, bool)
    return compete(picked)


def with_mask(candidate: Candidate, mask: BoolArray) -> Candidate:
    """The same candidate with another mask."""
    return replace(candidate, mask=mask)
