"""Where the thing is, pixel by pixel, as a small network sees it that has seen many.

The network (a U-Net of 850 kB, `assets/networks/thing_map.onnx`) is shown the picture, what the
drafts say and what a person marked, and says of each pixel how likely it belongs to the thing. It
was fitted by `tools/fit_thing_map.py` on pictures of `benchmark.scenes` below seed 1000 alone, with
colours turned, noise and whole drafts left out, so that it learns how outlines, colours and drafts
go together rather than what things look like. It weighs the drafts in a box; those of clicks are
as good without it, once attached parts have joined.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.assets import assets_dir
from physagent_studio.reconstruction.learned.network import Network
from physagent_studio.reconstruction.masks.choice import Scored
from physagent_studio.reconstruction.masks.task import Task, View
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.switches import at_work

FloatArray = NDArray[np.float32]
CANVAS = 112
"""Sides in pixels of the square that the network sees; the view fills it from its upper left."""
CHANCE_STEP = 0.1
"""Step of the score by which a draft is e times as likely as another."""
FAMILIES = ("colour", "contour", "region")
"""Families of drafts whose means the network is shown."""
MARK_RADIUS = 0.02
"""Radius of a click as the network is shown it, in the view's longer sides."""


def weighed(view: View, task: Task, drafts: Sequence[Scored]) -> list[Scored]:
    """The drafts, best first, each with the mean of its own score and of its IoU with the map."""
    if not drafts or not at_work("thing map"):
        return list(drafts)
    chance = thing_map(view, task, drafts)
    again = [(draft, (value + soft_iou(draft.mask, chance)) / 2) for draft, value in drafts]
    return sorted(again, key=lambda scored: -scored[1])


def soft_iou(mask: BoolArray, chance: FloatArray) -> float:
    """IoU of a mask (H, W) with one of which each pixel's chance (H, W) is known, 0 … 1."""
    shared = float(chance[mask].sum())
    return shared / max(float(chance.sum()) + np.count_nonzero(mask) - shared, 1e-6)


def thing_map(view: View, task: Task, drafts: Sequence[Scored]) -> FloatArray:
    """(H, W) the probability of each pixel of a view that it belongs to the thing, 0 … 1."""
    seen = shown(view.lab, task, drafts)
    rows, columns = seen.shape[1:]
    canvas = np.zeros((1, len(seen), CANVAS, CANVAS), np.float32)
    canvas[0, :, :rows, :columns] = seen
    (found,) = _network().run({"": canvas}, {"": (1, 1, CANVAS, CANVAS)})
    chance = 1.0 / (1.0 + np.exp(-np.clip(found[0, 0, :rows, :columns], -12.0, 12.0)))
    size = (view.lab.shape[1], view.lab.shape[0])
    return np.asarray(cv2.resize(chance, size, interpolation=cv2.INTER_LINEAR), np.float32)


def shown(lab: FloatArray, task: Task, drafts: Sequence[Scored]) -> FloatArray:
    """(10, h, w) what the network is shown of a view: colours, drafts, marks; each 0 … 1."""
    rows, columns = lab.shape[:2]
    factor = CANVAS / max(rows, columns)
    size = (round(columns * factor), round(rows * factor))
    masks = np.stack([draft.mask for draft, _ in drafts]).astype(np.float32)
    family = np.array([draft.family for draft, _ in drafts])
    scores = np.array([value for _, value in drafts])
    chance = np.exp((scores - scores.max()) / CHANCE_STEP)
    vote = np.tensordot((chance / chance.sum()).astype(np.float32), masks, 1)
    nothing = np.zeros((rows, columns), np.float32)
    means = [masks[family == k].mean(0) if (family == k).any() else nothing for k in FAMILIES]
    box = nothing.copy()
    if task.box is not None:
        x0, y0, x1, y1 = task.box
        box[max(0, int(y0)) : int(np.ceil(y1)) + 1, max(0, int(x0)) : int(np.ceil(x1)) + 1] = 1
    marks = [_spots(task.inside, nothing), _spots(task.outside, nothing)]
    layers = [*np.moveaxis(lab / 255, 2, 0), vote, *means, box, *marks]
    return np.stack([cv2.resize(one, size, interpolation=cv2.INTER_AREA) for one in layers])


def _spots(points: Sequence[tuple[float, float]], blank: FloatArray) -> FloatArray:
    out = blank.copy()
    for x, y in points:
        radius = max(2, round(max(blank.shape) * MARK_RADIUS))
        cv2.circle(out, (int(x), int(y)), radius, 1, -1)
    return out


@cache
def _network() -> Network:
    return Network((assets_dir() / "networks" / "thing_map.onnx").read_bytes())
