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
        small, factor = _shrunk(image, self.side)
        flat = cv2.bilateralFilter(small, 5, 30, 5)
        lab = cv2.cvtColor(flat, cv2.COLOR_RGB2LAB).astype(np.float32)
        size = (image.shape[1], image.shape[0])
        out: dict[str, tuple[Candidate, ...]] = {}
        for name, grounding in groundings:
            if cancelled is not None and cancelled():
                return out
            task = _task(name, groundings, factor)
            if not task.inside and task.box is None:
                out[name] = ()
                continue
            scorer = Scorer(lab, task.inside)
            ranked = _ranked(scorer, _drafts(small, lab, task, scorer), task)
            best = _agreed(ranked)
            out[name] = tuple(_full_size(image, item, task, factor, size) for item in best)
        return out


def _shrunk(image: Image, side: int) -> tuple[NDArray[np.uint8], float]:
    factor = min(1.0, side / max(image.shape[:2]))
    small = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(small).astype(np.uint8), factor


def _task(name: str, groundings: Sequence[tuple[str, Grounding]], factor: float) -> _Task:
    """The clicks of one thing; those inside the others lie outside of it."""
    inside: list[Pixel] = []
    outside: list[Pixel] = []
    box = None
    for other, grounding in groundings:
        for click in grounding.points:
            pixel = (click.x * factor, click.y * factor)
            if other == name:
                (inside if click.label else outside).append(pixel)
            elif click.label:
                outside.append(pixel)
        if other == name and grounding.box is not None:
            x0, y0, x1, y1 = (value * factor for value in grounding.box)
            box = (min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))
    return _Task(tuple(inside), tuple(outside), box, usual_size(name).aspect)


def _drafts(
    small: NDArray[np.uint8], lab: NDArray[np.float32], task: _Task, scorer: Scorer
) -> list[Draft]:
    if task.box is not None:
        return _box_drafts(small, lab, task, task.box)
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
) -> list[Draft]:
    x0, y0, x1, y1 = box
    rows, columns = lab.shape[:2]
    within = np.zeros((rows, columns), bool)
    within[int(y0) : int(np.ceil(y1)) + 1, int(x0) : int(np.ceil(x1)) + 1] = True
    around = grow(within, max(4, int(0.15 * max(x1 - x0, y1 - y0)))) & ~within
    ratio = grabcut.likelihood_ratio(lab, within, around) if around.any() else None
    drafts: list[Draft] = []
    cores = {"box": None, "box-colour": ratio > 0 if ratio is not None else None}
    for method, core in cores.items():
        mask = grabcut.in_box(small, box, task.inside, task.outside, core)
        if mask is not None:
            mask = _clean(mask, task) if task.inside else smooth(mask, 0.01)
            drafts.append(Draft(mask & within, method, "colour"))
    for mask in contour.again(lab, within, task.outside):
        if np.count_nonzero(mask & within) > 40:
            drafts.append(Draft(mask & within, "box-contour", "contour"))
    return [draft for draft in drafts if np.count_nonzero(draft.mask) >= 30]


def _clean(mask: BoolArray, task: _Task) -> BoolArray:
    """The clicked part, without hairs, its small holes filled."""
    part = holding(mask, task.inside)
    part = without_pinholes(smooth(part), 0.02)
    return holding(part, task.inside)


def _ranked(
    scorer: Scorer, drafts: Sequence[Draft], task: _Task
) -> list[tuple[Draft, float]]:
    graded = scorer.scores(drafts)
    if task.aspect is not None:
        graded = graded - _odd_proportions(drafts, task.aspect)
    order = np.argsort(-graded, kind="stable")
    return [(drafts[int(k)], float(graded[k])) for k in order]


def _odd_proportions(drafts: Sequence[Draft], aspect: tuple[float, float]) -> NDArray[np.float64]:
    """What drafts lose whose height over width is unusual for the name."""
    usual, spread = aspect
    out = np.zeros(len(drafts))
    for k, draft in enumerate(drafts):
        x0, y0, x1, y1 = bounds(draft.mask)
        off = np.log(max(y1 - y0, 1) / max(x1 - x0, 1) / usual) / (spread + 0.1)
        out[k] = 0.12 * min(float(off) ** 2, 4.0) / 2
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


def _full_size(
    image: Image,
    item: tuple[Draft, float],
    task: _Task,
    factor: float,
    size: tuple[int, int],
) -> Candidate:
    """The draft at the picture's size, its outline settled there by GrabCut in a band."""
    draft, value = item
    rough = resized(draft.mask, size) if factor < 1 else draft.mask
    mask = _settled(image, rough, max(2, round(1.6 / factor)))
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
