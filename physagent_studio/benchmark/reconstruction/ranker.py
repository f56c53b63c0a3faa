"""How well the ranking of masks carries over to photographs that it was not fitted to.

The weights of `maskscore` are fitted anew with each photograph left out in turn, and choose among
the drafts of that one. If what they choose there is much worse than what the weights that ship
choose, these have learned the photographs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.benchmark.rows import Row, shown
from physagent_studio.reconstruction.masks.click_drafts import begun, click_drafts
from physagent_studio.reconstruction.masks.draft_score import WEIGHTS, Scorer
from physagent_studio.reconstruction.masks.segmenter import SIDE, apart
from physagent_studio.reconstruction.masks.task import task_of, view_of
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.case import Case

FloatArray = NDArray[np.float64]
RIDGE = 1.0
"""How much large weights cost, against one for each thing."""
FEW = ("constant", "consensus", "agreement", "border", "off centre")
"""Features of a smaller ranking, to hold the larger one against."""


@dataclass(frozen=True, eq=False, slots=True)
class Thing:
    """One thing of one photograph. features: (N, F) of its drafts. ious: (N,) with the truth."""

    photo: str
    features: FloatArray
    ious: FloatArray


def things_of(photo: str, case: Case, truth: Mapping[str, BoolArray]) -> Iterator[Thing]:
    """The drafts of every thing of a case from its clicks alone."""
    assert case.image is not None
    height, width = case.image.shape[:2]
    view = view_of(case.image, (0, 0, width, height), SIDE)
    size = (view.lab.shape[1], view.lab.shape[0])
    for name, grounding in apart(case.objects):
        if name not in truth or grounding.box is not None:
            continue
        task = task_of(name, grounding, view)
        scorer = Scorer(view.lab, task.inside)
        with ThreadPoolExecutor(1) as pool:
            cutting = begun(pool, view.small, view.lab, task, filling=True)
            drafts = click_drafts(view.small, view.lab, task, scorer, cutting)
        own = cv2.resize(truth[name].astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0.5
        ious = np.array([iou(draft.mask, np.asarray(own)) for draft in drafts])
        yield Thing(photo, scorer.features(drafts), ious)


def fitted(things: list[Thing], columns: list[int]) -> FloatArray:
    """(F,) weights, zero outside `columns`: ridge regression, each thing counting the same."""
    rows = [t.features[:, columns] / np.sqrt(len(t.ious)) for t in things]
    wanted = [t.ious / np.sqrt(len(t.ious)) for t in things]
    matrix, values = np.vstack(rows), np.concatenate(wanted)
    out = np.zeros(len(WEIGHTS))
    square = matrix.T @ matrix + RIDGE * 0.05 * np.eye(len(columns))
    out[columns] = np.linalg.solve(square, matrix.T @ values)
    return out


def chosen(things: list[Thing], weights: FloatArray) -> list[float]:
    """IoU of the draft that weights choose for each thing."""
    return [float(t.ious[(t.features * weights).sum(1).argmax()]) for t in things]


def left_out(things: list[Thing], columns: list[int]) -> list[float]:
    """As `chosen`, by weights that were fitted to all other photographs."""
    out: list[float] = []
    for photo in sorted({t.photo for t in things}):
        weights = fitted([t for t in things if t.photo != photo], columns)
        out += chosen([t for t in things if t.photo == photo], weights)
    return out


def ranking_rows(things: list[Thing]) -> list[Row]:
    """First draft's IoU: by the weights that ship, fitted with one photograph left out, at best."""
    if len({t.photo for t in things}) < 3:
        return []
    every = list(range(len(WEIGHTS)))
    few = [k for k, name in enumerate(WEIGHTS) if name in FEW]
    told = {
        "weights that ship": chosen(things, np.array(list(WEIGHTS.values()))),
        "fitted, each photograph left out": left_out(things, every),
        f"{len(few)} features, each photograph left out": left_out(things, few),
        "the best of all drafts": [float(t.ious.max()) for t in things],
    }
    rows: list[Row] = []
    for name, found in told.items():
        rows.append(shown(f"ranking, clicks: {name}, median", float(np.median(found))))
        rows.append(shown(f"ranking, clicks: {name}, mean", float(np.mean(found))))
    return rows
