"""Sides of a block that others cover: painted in its own colour, not in what lies on them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, shrink
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class HiddenSettings:
    """How a covered side is painted."""

    min_seen_share: float = 0.3  # 0.1..0.8: of a side, from which the photo shows it
    min_own_share: float = 0.03  # 0..0.2: of a side, from which what is seen of it tells its colour
    beside_ratio: float = 0.05  # 0.01..0.2: over the smaller extent: where its colour is looked for
    # 0..0.05: over the same: the outline's ring in which others shine through
    leak_ratio: float = 0.015
    same_levels: int = 24  # 8..64: within which colours are one
    min_px: int = 12  # 4..100: that tell a colour
    grain_share: float = 0.6  # 0..1: of its colour's own unevenness that is kept


HIDDEN = HiddenSettings()


def covered_painted(
    photo: Image,
    mask: BoolArray,
    camera: Camera,
    item: SceneObject,
    crop: tuple[Image, tuple[int, int]],
) -> Image:
    """The crop (h, w, 3) of a block, what others cover of it in the colour that is seen beside it.

    crop: with its top left corner (x, y) in the photo. Others than blocks stay as they are.
    """
    picture, (left, top) = crop
    if not isinstance(item.shape, Box) or not at_work("covered sides"):
        return picture
    x0, y0, x1, y1 = bounds(mask)
    size = min(x1 - x0, y1 - y0)
    core = shrink(mask, max(1, round(HIDDEN.leak_ratio * size)))
    rows, columns = picture.shape[:2]
    window = (slice(top, top + rows), slice(left, left + columns))
    result = picture.copy()
    for corners in _towards(camera, item):
        side = np.zeros((rows, columns), np.uint8)
        place = camera.project(corners)[0] - (left, top)
        cv2.fillConvexPoly(side, np.round(place * 16).astype(np.int32), 1, shift=4)
        area = side.astype(bool)
        if not area.any() or mask[window][area].mean() > HIDDEN.min_seen_share:
            continue
        beside = core[window] & grow(area, max(3, round(HIDDEN.beside_ratio * size)))
        if (core[window] & area).sum() < HIDDEN.min_own_share * area.sum():
            # Beside it lies another side's rim, which may have a border: then its usual colour.
            beside = core[window]
        colour = commonest(photo[window][beside])
        if colour is None:
            continue
        painted = grow(area, 2) & ~core[window]
        usual, stray = colour
        # The same picture each time: a seed that depends on nothing.
        noise = np.random.default_rng(0).normal(0, HIDDEN.grain_share * stray, (rows, columns))
        noise = cv2.GaussianBlur(noise, (0, 0), 0.8)
        filled = np.clip(usual + noise[..., None] + 0.5, 0, 255).astype(np.uint8)
        result = np.where(painted[..., None], filled, result)
    return result


def _towards(camera: Camera, item: SceneObject) -> list[FloatArray]:
    """Corners (4, 3), world, of the sides of a block that look at the camera."""
    assert isinstance(item.shape, Box)
    turn, middle = matrix_of(item.rotation), np.asarray(item.position)
    half = np.asarray(item.shape.size) / 2
    found = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = sign * turn[:, axis]
            centre = middle + half[axis] * normal
            if (np.asarray(camera.position) - centre) @ normal <= 0:
                continue
            first, second = (turn[:, k] * half[k] for k in range(3) if k != axis)
            around = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
            found.append(np.array([centre + a * first + b * second for a, b in around]))
    return found


def commonest(colours: Image) -> tuple[FloatArray, float] | None:
    """The colour (3,) that most of them (N, 3) have, and how they stray from it; None for few."""
    if len(colours) < HIDDEN.min_px:
        return None
    values = colours.astype(np.float64)
    bins, group = np.unique(colours // HIDDEN.same_levels, axis=0, return_inverse=True)
    most = np.bincount(group.reshape(-1), minlength=len(bins)).argmax()
    usual = values[group.reshape(-1) == most].mean(0)
    near = np.ones(len(values), bool)
    for _ in range(4):
        near = np.abs(values - usual).max(1) < HIDDEN.same_levels
        if not near.any():
            return usual, 0.0
        usual = values[near].mean(0)
    return usual, float(values[near].mean(1).std())
