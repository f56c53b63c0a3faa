"""Drafts inside a box, a person's or that of what the map shows, and which of them lead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import grabcut
from physagent_studio.reconstruction.masks.box_reach import reaching
from physagent_studio.reconstruction.masks.choice import Scored, agreed
from physagent_studio.reconstruction.masks.draft_score import Draft, Scorer
from physagent_studio.reconstruction.masks.ranking import denied, distinct, ranked
from physagent_studio.reconstruction.masks.task import Task, View, snapped
from physagent_studio.reconstruction.masks.thing_map import weighed
from physagent_studio.reconstruction.photo import closed_contours as contour
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    grow,
    holding,
    smooth,
    without_pinholes,
)
from physagent_studio.reconstruction.switches import at_work

BELIEVED = 0.2
"""Mean chance on a hole, by the map, from which it is filled."""
LARGEST_WINDOW = 0.1
"""Share of the mask that such a hole may have."""
LED = 4
"""How many of the best drafts are led to the sides of the box that they miss."""


def found_in(view: View, task: Task, maps: Sequence[NDArray[np.float32]]) -> list[Scored]:
    """Up to four masks on a view, best first.

    maps: (h, w) of the thing there, first the one that drafts are weighed by, then those of other
    looks, which are drafts as well.
    """
    if task.box is None:
        return []
    scorer = Scorer(view.lab, task.inside)
    drafts = box_drafts(view.small, view.lab, task, task.box, scorer)
    drafts += _solid([Draft(one > 0.5, "map", "map") for one in maps])
    drafts = [replace(draft, mask=_without_windows(draft.mask, maps[0])) for draft in drafts]
    found = weighed(ranked(scorer, drafts, task), maps[0])
    # What a person said is no part of the thing outweighs what the map shows.
    found = [(draft, max(value - denied(draft.mask, task), 0.0)) for draft, value in found]
    found.sort(key=lambda scored: -scored[1])
    return agreed(found, view.lab, scorer.likeness)


def box_drafts(
    small: NDArray[np.uint8],
    lab: NDArray[np.float32],
    task: Task,
    box: tuple[float, float, float, float],
    scorer: Scorer,
) -> list[Draft]:
    """Drafts inside a box (x0, y0, x1, y1), by colours and by contours."""
    x0, y0, x1, y1 = box
    rows, columns = lab.shape[:2]
    within = np.zeros((rows, columns), bool)
    within[max(0, int(y0)) : int(np.ceil(y1)) + 1, max(0, int(x0)) : int(np.ceil(x1)) + 1] = True
    around = grow(within, max(4, int(0.15 * max(x1 - x0, y1 - y0)))) & ~within
    ratio = grabcut.likelihood_ratio(lab, within, around) if around.any() else None
    cores: dict[str, BoolArray | None] = {"box": None}
    if ratio is not None and at_work("box colours"):
        cores |= {"box-colour": ratio > 0, "box-sure": ratio > 1.0}
    drafts: list[Draft] = []
    masks = grabcut.side_by_side(
        lambda core: grabcut.in_box(small, box, task.inside, task.outside, core),
        list(cores.values()),
    )
    for method, mask in zip(cores, masks, strict=True):
        if mask is not None:
            # A box says that all of its object lies inside: loose parts may belong to it.
            drafts.append(Draft(_tidy(mask) & within, method, "colour"))
            if task.inside:
                drafts.append(Draft(clean(mask, task) & within, f"{method}-part", "colour"))
    contours = []
    if at_work("box contours"):
        contours = _contours(lab, task, within, drafts, scorer)
    drafts += contours

    def settled(draft: Draft) -> Draft:
        band = max(2, round(0.06 * float(np.sqrt(np.count_nonzero(draft.mask)))))
        mask = _tidy(snapped(small, draft.mask, band, 0.6)) & within
        return Draft(mask, f"{draft.method}-settled", draft.family)

    def led(draft: Draft) -> Draft | None:
        mask = reaching(small, lab, draft.mask, box, task)
        return (
            mask
            if mask is None
            else Draft(_tidy(mask) & within, f"{draft.method}-led", draft.family)
        )

    if at_work("settled boxes"):
        best = [d for d, _ in distinct(ranked(scorer, _solid(drafts), task), 3, 0.9)]
        drafts += grabcut.side_by_side(settled, best)
    if not at_work("box reach"):
        return _solid(drafts)
    best = [d for d, _ in distinct(ranked(scorer, _solid(drafts), task), LED, 0.8)]
    drafts += [made for made in grabcut.side_by_side(led, best) if made is not None]
    return _solid(drafts)


def _contours(
    lab: NDArray[np.float32],
    task: Task,
    within: BoolArray,
    drafts: Sequence[Draft],
    scorer: Scorer,
) -> list[Draft]:
    """Contours around what is within the box, then again around the best drafts."""
    out = [
        Draft(mask & within, "box-contour", "contour")
        for mask in contour.again(lab, within, task.outside)
    ]
    best = distinct(ranked(scorer, _solid([*drafts, *out]), task), 3, 0.9)
    for draft, _ in best:
        for mask in contour.again(lab, draft.mask, task.outside):
            out.append(Draft(mask & within, "box-contour-again", "contour"))
    return out


def _without_windows(mask: BoolArray, chance: NDArray[np.float32]) -> BoolArray:
    """The mask with those holes filled of which a map (h, w) half believes that they belong to it.

    As the windows and hub caps of a car; through a handle or a ring the map sees what is behind.
    """
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        (~mask).astype(np.uint8), connectivity=4
    )
    area = np.count_nonzero(mask)
    rows, columns = mask.shape
    out = mask.copy()
    for label in range(1, count):
        x, y, width, height, size = (int(value) for value in stats[label])
        inside = x > 0 and y > 0 and x + width < columns and y + height < rows
        if inside and size < LARGEST_WINDOW * area:
            hole = labels == label
            out[hole] = float(chance[hole].mean()) > BELIEVED
    return out


def _solid(drafts: Sequence[Draft]) -> list[Draft]:
    return [draft for draft in drafts if np.count_nonzero(draft.mask) >= 30]


def clean(mask: BoolArray, task: Task) -> BoolArray:
    """The clicked part, without hairs, its small holes filled."""
    part = without_pinholes(smooth(holding(mask, task.inside)), 0.02)
    return holding(part, task.inside)


def _tidy(mask: BoolArray) -> BoolArray:
    """The mask without specks smaller than a fiftieth of its largest part."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    if count < 2:
        return mask
    areas = stats[1:, cv2.CC_STAT_AREA]
    kept = 1 + np.flatnonzero(areas > 0.02 * areas.max())
    return without_pinholes(np.isin(labels, kept), 0.01)
