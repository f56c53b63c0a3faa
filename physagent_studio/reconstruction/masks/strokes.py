"""Corrections that a person draws: what they cover is honoured exactly, the rest snaps to edges."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.program.scene.state import Stroke
from physagent_studio.reconstruction.masks import grabcut
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class StrokeSettings:
    """How strokes are drawn, and how far they reach."""

    reach_ratio: float = 1.5  # 0..4: over a brush's radius: how far beside it outlines may move
    # binary digits, 0..8: of a pixel's fraction when strokes are drawn, as OpenCV takes them
    fraction_bits: int = 4


STROKE = StrokeSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Drawn:
    """What strokes say, (H, W) each: surely inside, surely outside, and where to look for edges."""

    inside: BoolArray
    outside: BoolArray
    near: BoolArray


def covered(stroke: Stroke, shape: tuple[int, int]) -> BoolArray:
    """The pixels (H, W) that a stroke covers; at least one where it lies in the picture."""
    canvas = np.zeros(shape, np.uint8)
    # A pixel (i, j) covers [i, i + 1), OpenCV draws its centre at (i, j).
    points = np.round((np.array(stroke.points) - 0.5) * 2**STROKE.fraction_bits).astype(np.int32)
    if stroke.tool == "scissors":
        cv2.fillPoly(canvas, [points], 1, shift=STROKE.fraction_bits)
        return canvas.astype(bool)
    width = max(1, round(2 * stroke.radius))
    cv2.polylines(canvas, [points], False, 1, width, shift=STROKE.fraction_bits)
    for x, y in points:
        radius = round(stroke.radius * 2**STROKE.fraction_bits)
        cv2.circle(canvas, (int(x), int(y)), radius, 1, -1, shift=STROKE.fraction_bits)
    return canvas.astype(bool)


def drawn(strokes: Sequence[Stroke], shape: tuple[int, int]) -> Drawn:
    """All strokes together, later ones over earlier ones."""
    inside, outside = np.zeros(shape, bool), np.zeros(shape, bool)
    near = np.zeros(shape, bool)
    for stroke in strokes:
        region = covered(stroke, shape)
        if stroke.effect == "only":
            inside, outside, near = region, ~region, np.zeros(shape, bool)
            continue
        own, other = (inside, outside) if stroke.effect == "add" else (outside, inside)
        own |= region
        other &= ~region
        if stroke.tool == "brush":
            near |= grow(region, max(2, round(STROKE.reach_ratio * stroke.radius)))
    return Drawn(inside, outside, near & ~inside & ~outside)


def corrected(image: Image | None, mask: BoolArray, strokes: Sequence[Stroke]) -> BoolArray:
    """The mask (H, W) with strokes applied; beside a brush line it ends at edges of the picture.

    Without an image nothing beside the strokes changes.
    """
    if not strokes:
        return mask
    said = drawn(strokes, (mask.shape[0], mask.shape[1]))
    rough = (mask | said.inside) & ~said.outside
    return rough if image is None else _beside(image, rough, said)


def seeds_of(strokes: Sequence[Stroke], count: int = 5) -> list[tuple[float, float, bool]]:
    """Some points (x, y, inside) on each stroke, for segmenting where nothing was clicked."""
    out: list[tuple[float, float, bool]] = []
    for stroke in strokes:
        points = stroke.points
        if stroke.tool == "scissors":
            x, y = np.mean(np.array(points), axis=0)
            out.append((float(x), float(y), stroke.effect != "erase"))
            continue
        at = np.unique(np.linspace(0, len(points) - 1, min(count, len(points))).round().astype(int))
        out += [(*points[k], stroke.effect != "erase") for k in at]
    return out


def _beside(image: Image, rough: BoolArray, said: Drawn) -> BoolArray:
    """The outline near the strokes settled by a graph cut; elsewhere it stays."""
    x0, y0, x1, y1 = bounds(said.near)
    if x1 <= x0:
        return rough
    pad = 12 + max(x1 - x0, y1 - y0) // 4
    crop = (slice(max(0, y0 - pad), y1 + pad), slice(max(0, x0 - pad), x1 + pad))
    trimap = np.where(rough, cv2.GC_FGD, cv2.GC_BGD).astype(np.uint8)
    trimap[said.near] = np.where(rough[said.near], cv2.GC_PR_FGD, cv2.GC_PR_BGD)
    part = grabcut.cut(
        np.ascontiguousarray(image[crop]), np.ascontiguousarray(trimap[crop]), rounds=1
    )
    if part is None:
        return rough
    out = rough.copy()
    out[crop] = np.where(said.near[crop], part, rough[crop])
    return out
