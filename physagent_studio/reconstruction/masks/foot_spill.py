"""Shade and mirror images at the foot of a ball, which a mask may have taken for a part of it.

The outline of a round thing is a circle, but for what hides it: whatever sticks out at its foot
belongs to what it lies on. Stems and leaves, above and beside, are left as they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.language import SceneHints
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.masks.ground_spill import without_ground
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]
NEAR = 0.03
"""How far from the circle an outline may run, in radii, and still be that of the thing."""
ROUND = 0.6
"""Share of the outline that does so, at least."""
PLAINLY_ROUND, MISSED = 0.9, (0.05, 0.15)
"""The same for what is filled up to its circle, and the share of the mask that is missing then, at
least and at most: less is the unevenness of an outline, more is hidden by something."""
LOW = 0.25
"""Lowest share of the mask, whose outline is not asked what circle it is."""
FOOT = 0.6
"""How far below the middle a foot begins, in radii."""
MUCH = 0.2
"""Share of the mask from which on what sticks out is no mere shade."""


def sound_masks(
    photo: Image, masks: Mapping[str, BoolArray], objects: Sequence[SceneObject], told: SceneHints
) -> dict[str, BoolArray]:
    """The masks without the ground and shade at their feet where nobody has drawn them."""
    out = dict(masks)
    for item in objects:
        mask = masks.get(item.name)
        if mask is None or item.grounding.strokes:
            continue
        others = [other for name, other in masks.items() if name != item.name]
        beside = np.any(others, axis=0) if others else np.zeros_like(mask)
        shapes = told.usual(item.name).shapes
        if shapes[:1] != ("sphere",):
            out[item.name] = without_ground(photo, mask, beside)
            continue
        spilt = without_spill(mask)
        out[item.name] = spilt if spilt is mask or at_work("foot spill") else mask
        if shapes == ("sphere",):
            out[item.name] = with_missed_panels(out[item.name], beside)
    return out


def without_spill(mask: BoolArray) -> BoolArray:
    """The mask (H, W) of a ball without what sticks out of its circle at its foot."""
    found = _fitted(mask)
    if found is None or found[1] < ROUND:
        return mask
    (x, y, radius), _ = found
    rows, columns = np.indices(mask.shape)
    beyond = np.hypot(columns - x, rows - y) > (1 + NEAR / 2) * radius + 0.7
    spill = mask & beyond & (rows > y + FOOT * radius)
    share = np.count_nonzero(spill) / np.count_nonzero(mask)
    return mask & ~spill if 0 < share < MUCH else mask


def with_missed_panels(mask: BoolArray, others: BoolArray) -> BoolArray:
    """The mask (H, W) of a ball filled up to its circle where a good part of that is missing.

    others: (H, W) what hides it. Dark panels at the rim are easily taken for the ground.
    """
    found = _fitted(mask)
    if found is None or found[1] < PLAINLY_ROUND:
        return mask
    (x, y, radius), _ = found
    rows, columns = np.indices(mask.shape)
    missed = (np.hypot(columns - x, rows - y) <= radius + 0.5) & ~mask & ~others
    share = np.count_nonzero(missed) / np.count_nonzero(mask)
    return mask | missed if MISSED[0] < share < MISSED[1] else mask


def _fitted(mask: BoolArray) -> tuple[tuple[float, float, float], float] | None:
    """Circle (x, y, radius) of a mask's outline but for its foot, and the share that is on it."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return None
    outline = np.vstack([part[:, 0] for part in found]).astype(float)
    top, bottom = outline[:, 1].min(), outline[:, 1].max()
    outline = outline[outline[:, 1] < bottom - LOW * (bottom - top)]
    circle = _circle(outline)
    if circle is None:
        return None
    x, y, radius = circle
    off = np.hypot(outline[:, 0] - x, outline[:, 1] - y) - radius
    return circle, float(np.mean(np.abs(off) < NEAR * radius + 0.7))


def _circle(points: FloatArray) -> tuple[float, float, float] | None:
    """Middle and radius of the circle that most points (N, 2) lie on, pixels; None for too few.

    Kåsa's linear fit, with points weighed anew by how far they are off.
    """
    if len(points) < 16:
        return None
    middle = points.mean(0)
    size = max(float(np.ptp(points, axis=0).max()) / 2, 1.0)
    u = (points - middle) / size
    terms = np.column_stack([2 * u, np.ones(len(u))])
    square, weight = (u**2).sum(1), np.ones(len(u))
    x = y = radius = 0.0
    for _ in range(20):
        fit = np.linalg.lstsq(terms * weight[:, None], square * weight, rcond=None)[0]
        x, y = float(fit[0]), float(fit[1])
        radius = float(np.sqrt(max(fit[2] + x * x + y * y, 1e-12)))
        off = np.abs(np.hypot(u[:, 0] - x, u[:, 1] - y) - radius)
        weight = 1 / (1 + (off / max(2 * float(np.median(off)), 1e-3)) ** 2)
    return x * size + float(middle[0]), y * size + float(middle[1]), radius * size
