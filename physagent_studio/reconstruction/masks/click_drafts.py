"""Drafts from clicks alone: GrabCut at several scales, contours, and contours recoloured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import grabcut
from physagent_studio.reconstruction.masks.draft_score import REGION, Draft, Scorer, window_share
from physagent_studio.reconstruction.masks.ranking import distinct, ranked
from physagent_studio.reconstruction.masks.region_growing import LARGEST, regions
from physagent_studio.reconstruction.masks.task import Task, snapped
from physagent_studio.reconstruction.photo import closed_contours as contour
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    holding,
    iou,
    smooth,
    without_pinholes,
)
from physagent_studio.reconstruction.switches import at_work

Cutting = Future[list[grabcut.Window]]


def begun(
    pool: Executor, small: NDArray[np.uint8], lab: NDArray[np.float32], task: Task, *, filling: bool
) -> Cutting:
    """The cuts around the clicks at all sizes, which run outside of Python.

    filling: whether a thing may fill almost all of the view.
    """
    return pool.submit(grabcut.at_scales, small, lab, task.inside, task.outside, filling=filling)


def click_drafts(
    small: NDArray[np.uint8],
    lab: NDArray[np.float32],
    task: Task,
    scorer: Scorer,
    cutting: Cutting,
    glimpsed: Callable[[float], None] = lambda score: None,
) -> list[Draft]:
    """Drafts around the clicks, at all sizes; every one holds a click.

    cutting: the cuts, begun before. glimpsed: called with the score of the best of the first.
    """
    # The first outlines are sought while the cuts run.
    middle = np.array(task.inside).mean(0)
    around = contour.around(lab, (float(middle[0]), float(middle[1])), task.outside)
    grown = regions(lab, task.inside) if at_work("region growing") else []
    windows = cutting.result()
    drafts: list[Draft] = []
    cleaned = [clean(window.mask, task) for window in windows]
    for k, (window, mask) in enumerate(zip(windows, cleaned, strict=True)):
        if np.count_nonzero(mask) < 30:
            continue
        share = window_share(mask, window.box)
        drafts.append(Draft(mask, f"grabcut-{k}", "colour", share))
    found = [(f"region-{k}", mask, REGION) for k, mask in enumerate(grown)]
    if task.named is not None:
        found.append(("colour-word", holding(task.named, task.inside), "name"))
    for method, mask, family in found:
        part = clean(mask, task)
        if 12 < np.count_nonzero(part) < LARGEST * mask.size:
            drafts.append(Draft(part, method, family))
    whole = [draft for draft in drafts if draft.family != REGION]
    if not at_work("closed contours"):
        return drafts
    contours = _contours(lab, task, whole, around, scorer, glimpsed)
    if not at_work("recoloured contours"):
        return drafts + contours
    return drafts + contours + _recoloured(small, task, contours, scorer)


def _contours(
    lab: NDArray[np.float32],
    task: Task,
    drafts: Sequence[Draft],
    around: Sequence[BoolArray],
    scorer: Scorer,
    glimpsed: Callable[[float], None],
) -> list[Draft]:
    """Contours around the clicks' middle, then again from the middles of the best masks."""
    out = _as_drafts(around, "contour", task)
    for turn in range(2):
        order = ranked(scorer, [*drafts, *out], task)
        if turn == 0:
            glimpsed(order[0][1] if order else 0.0)
        best = distinct(order, 5 if turn == 0 else 3, 0.85)
        masks = [draft.mask for draft, _ in best]
        again, beyond = contour.near(lab, masks, task.outside, grown=2)
        for found in again:
            out += _as_drafts(found, f"contour-again-{turn}", task)
        for found in beyond if at_work("wider contours") else ():
            out += _as_drafts(found, f"contour-beyond-{turn}", task)
    return out


def _as_drafts(masks: Sequence[BoolArray], method: str, task: Task) -> list[Draft]:
    """Different masks that hold the clicks."""
    out: list[Draft] = []
    for mask in masks:
        part = holding(mask, task.inside)
        if np.count_nonzero(part) > 40 and all(iou(part, d.mask) < 0.97 for d in out):
            out.append(Draft(part, method, "contour"))
    return out


def _recoloured(
    small: NDArray[np.uint8], task: Task, drafts: Sequence[Draft], scorer: Scorer
) -> list[Draft]:
    """The best contours with their outline settled by colour."""

    def recoloured(draft: Draft) -> Draft:
        band = max(2, round(0.08 * float(np.sqrt(np.count_nonzero(draft.mask)))))
        mask = clean(snapped(small, draft.mask, band, 0.6), task)
        return Draft(mask, f"{draft.method}-colour", "contour")

    best = [draft for draft, _ in distinct(ranked(scorer, drafts, task), 4, 0.9)]
    made = grabcut.side_by_side(recoloured, best)
    return [draft for draft in made if np.count_nonzero(draft.mask) > 30]


def clean(mask: BoolArray, task: Task) -> BoolArray:
    """The clicked part, without hairs, its small holes filled."""
    part = holding(mask, task.inside)
    part = without_pinholes(smooth(part), 0.02)
    return holding(part, task.inside)
