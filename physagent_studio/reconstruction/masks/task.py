"""One thing to segment: its clicks in pixels of a part of the picture at working size."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks import grabcut
from physagent_studio.reconstruction.masks.draft_score import Draft
from physagent_studio.reconstruction.masks.variants import VARIANT
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    Pixel,
    bounds,
    grow,
    iou,
    resized,
    shrink,
)
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate


@dataclass(frozen=True, slots=True)
class OutlineSettings:
    """How outlines are brought to the picture's size."""

    whole_factor: float = 6.0  # 2..20: enlarged by more, only a mask's surroundings are, for speed
    settled_px: int = 384  # 128..1024: the longer side on which an outline is settled


OUTLINE = OutlineSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Task:
    """One thing to segment, in pixels of the small picture. tight: whether the box ends where the
    thing ends."""

    inside: tuple[Pixel, ...]
    outside: tuple[Pixel, ...]
    box: tuple[float, float, float, float] | None
    tight: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """A part of the picture at working size: (x0, y0, x1, y1) of the part and the factor."""

    part: tuple[int, int, int, int]
    factor: float
    small: NDArray[np.uint8]
    lab: NDArray[np.float32]

    def inward(self, x: float, y: float) -> Pixel:
        """A pixel of the picture as one of the view."""
        return (x - self.part[0]) * self.factor, (y - self.part[1]) * self.factor


def view_of(image: Image, part: tuple[int, int, int, int], side: int) -> View:
    """A part (x0, y0, x1, y1) of the picture, its longer side brought to about `side` pixels."""
    x0, y0, x1, y1 = part
    crop = image[y0:y1, x0:x1]
    factor = min(1.5, side / max(crop.shape[:2]))
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    small = cv2.resize(crop, None, fx=factor, fy=factor, interpolation=how)
    small = np.ascontiguousarray(small).astype(np.uint8)
    lab = cv2.cvtColor(cv2.bilateralFilter(small, 5, 30, 5), cv2.COLOR_RGB2LAB)
    return View(part, factor, small, lab.astype(np.float32))


def part_around(
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


def task_of(grounding: Grounding, view: View) -> Task:
    """The clicks of one thing in pixels of the view; those outside it are left out."""
    inside: list[Pixel] = []
    outside: list[Pixel] = []
    rows, columns = view.lab.shape[:2]
    for click in grounding.points:
        x, y = view.inward(click.x, click.y)
        if click.label:
            inside.append((x, y))
        elif 0 <= x < columns and 0 <= y < rows:
            outside.append((x, y))
    box = None
    if grounding.box is not None:
        (x0, y0), (x1, y1) = (view.inward(*grounding.box[k : k + 2]) for k in (0, 2))
        box = (min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))
    return Task(tuple(inside), tuple(outside), box)


def full_size(
    image: Image, item: tuple[Draft, float], view: View, *, settled: bool = True
) -> Candidate:
    """The draft at the picture's size, its outline settled there by GrabCut in a band."""
    draft, value = item
    x0, y0, x1, y1 = view.part
    rough = np.zeros(image.shape[:2], bool)
    _enlarge(draft.mask, rough[y0:y1, x0:x1])
    if draft.family == VARIANT or not settled or not at_work("settled outline"):
        return Candidate(rough, value, draft.method)
    # Half a pixel on both sides is much of what is few pixels wide.
    least = min(max(1 - 2.4 / _width(draft.mask), 0.55), 0.85)
    mask = snapped(image, rough, max(2, round(1.6 / view.factor)), least)
    return Candidate(mask, value, draft.method)


def _width(mask: BoolArray) -> float:
    """Pixels across a mask at its widest."""
    x0, y0, x1, y1 = bounds(mask)
    part = np.pad(mask[y0:y1, x0:x1], 1).astype(np.uint8)
    return 2 * float(cv2.distanceTransform(part, cv2.DIST_L2, 3).max(initial=0.5))


def _enlarge(mask: BoolArray, out: BoolArray) -> None:
    """Writes a mask at the size of `out` into it; only around the mask where that saves much."""
    rows, columns = mask.shape
    x0, y0, x1, y1 = bounds(mask)
    by = out.shape[1] / columns
    if by < OUTLINE.whole_factor or x1 <= x0:
        out[:] = resized(mask, (out.shape[1], out.shape[0]))
        return
    x0, y0, x1, y1 = max(0, x0 - 3), max(0, y0 - 3), min(columns, x1 + 3), min(rows, y1 + 3)
    left, right = round(x0 * by), round(x1 * by)
    top, low = (round(y * out.shape[0] / rows) for y in (y0, y1))
    out[top:low, left:right] = resized(mask[y0:y1, x0:x1], (right - left, low - top))


def snapped(image: Image, mask: BoolArray, band: int, least: float = 0.85) -> BoolArray:
    """The outline moved within `band` pixels to where the colours part.

    The mask as it was if less than `least` of it (IoU) would be left. Of a large thing the outline
    is settled on a smaller picture: an edge is no sharper there than the band is wide.
    """
    x0, y0, x1, y1 = bounds(mask)
    if x1 <= x0:
        return mask
    pad = 4 * band + 8
    crop = (slice(max(0, y0 - pad), y1 + pad), slice(max(0, x0 - pad), x1 + pad))
    part, own = np.ascontiguousarray(image[crop]), np.ascontiguousarray(mask[crop])
    factor = min(1.0, OUTLINE.settled_px / max(own.shape))
    if factor < 1:
        size = (round(own.shape[1] * factor), round(own.shape[0] * factor))
        part = cv2.resize(part, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
        small = cv2.resize(own.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0.5
        found = _cut_in_band(part, np.asarray(small), max(2, round(band * factor)))
        found = None if found is None else resized(found, (own.shape[1], own.shape[0]))
    else:
        found = _cut_in_band(part, own, band)
    # Where the band held no edge, GrabCut frays the outline: keep what changed little.
    if found is None or iou(found, own) <= least:
        return mask
    out = np.zeros_like(mask)
    out[crop] = found
    return out


def _cut_in_band(image: Image, mask: BoolArray, band: int) -> BoolArray | None:
    trimap = np.full(mask.shape, cv2.GC_BGD, np.uint8)
    trimap[grow(mask, band)] = cv2.GC_PR_BGD
    trimap[mask] = cv2.GC_PR_FGD
    trimap[shrink(mask, band)] = cv2.GC_FGD
    return grabcut.cut(image, trimap, rounds=1)
