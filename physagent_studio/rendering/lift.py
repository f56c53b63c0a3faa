"""Lifts the photo's shadows from the plate, so that none stays behind when its object leaves."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.grid import enlarged, reduced
from physagent_studio.rendering.sun import Shading

FloatPicture = NDArray[np.float32]

_MOST = 2.0
"""Greatest log brightening; what is darker than that has no texture left to brighten."""
_LOST = (0.9, 1.4)
"""From this log darkness to that, texture of lit ground takes the place of what is there."""
_TINGE = 1.0
"""How differently a shadow darkens red, green and blue, as a share of its darkness."""
_SHIFTS = tuple(
    (dy, dx) for dx in (0, -64, 64, -112, 112, -176, 176) for dy in (0, -24, 24, -48, 48, 72)
)
"""Offsets (y, x) in pixels at which lit ground is looked for."""


def lifted(plate: Picture, shading: Shading, blocked: NDArray[np.float32], step: int) -> Picture:
    """The plate (H, W, 3) without the shadows that lie where the sun casts them.

    blocked: (h, w) computed shadow of the sun at the initial pose.
    """
    likely = _likely(shading, blocked)
    before = plate.astype(np.float32)
    lit = np.maximum(enlarged(shading.lit, step, plate.shape), 1.0)
    coarse = np.exp(np.clip(-_without_texture(shading) * likely[..., None], 0, _MOST))
    # Beside a sharp edge the coarse map lies over lit ground too: never brighter than that is.
    most = np.maximum(before, lit * np.float32(np.exp(2 * shading.grain)))
    bright = np.minimum(before * enlarged(coarse.astype(np.float32), step, plate.shape), most)
    share = enlarged(likely, step, plate.shape)[..., None]
    bright = _evened(bright, lit, share, shading.grain)
    bright = _regrown(bright, plate, lit, shading, likely, step)
    return np.clip(bright + 0.5, 0, 255).astype(np.uint8)


def _without_texture(shading: Shading) -> FloatPicture:
    """(h, w, 3) darkness smoothed within the contrast of the texture, so that this is kept."""
    contrast = 0.02 + 2.5 * shading.grain
    return np.asarray(cv2.bilateralFilter(shading.darkness, -1, contrast, 5.0), np.float32)


def _likely(shading: Shading, blocked: NDArray[np.float32]) -> FloatPicture:
    """(h, w) how likely it is that darkness there is the objects' shadow, 0 … 1."""
    wide = cv2.GaussianBlur(cv2.dilate(blocked, np.ones((5, 5), np.uint8)), (0, 0), 4.0)
    inner = cv2.GaussianBlur(
        cv2.erode(shading.around.astype(np.float32), np.ones((9, 9))), (0, 0), 4
    )
    return np.asarray(np.clip((wide - 0.04) / 0.12, 0, 1) * inner * _neutral(shading), np.float32)


def _neutral(shading: Shading) -> FloatPicture:
    """(h, w) how far the darkness is without a colour of its own, 0 … 1: paint is no shadow."""
    dark = -cv2.GaussianBlur(shading.darkness, (0, 0), 1.0)
    uneven = dark.max(-1) - dark.min(-1) - _TINGE * np.maximum(dark.mean(-1), 0)
    return np.asarray(np.clip(1 - (uneven - 0.15) / 0.2, 0, 1), np.float32)


def _evened(
    bright: FloatPicture, lit: FloatPicture, share: FloatPicture, grain: float
) -> FloatPicture:
    """Brightens what the coarse map missed along sharp edges: darker than texture ever is."""
    fine = np.log(np.maximum(cv2.GaussianBlur(bright, (0, 0), 1.2), 4.0) / lit)
    missed = np.clip(-(fine + 2.0 * grain + 0.02), 0, _MOST)
    return np.asarray(bright * np.exp(missed * share), np.float32)


def _regrown(
    bright: FloatPicture,
    plate: Picture,
    lit: FloatPicture,
    shading: Shading,
    likely: FloatPicture,
    step: int,
) -> FloatPicture:
    """Where the shadow is nearly black, lit ground from beside it with the tone of this place."""
    deep = np.clip((-shading.darkness.mean(-1) - _LOST[0]) / (_LOST[1] - _LOST[0]), 0, 1) * likely
    if deep.max() < 0.05:
        return bright
    level = cv2.GaussianBlur(shading.darkness.mean(-1), (0, 0), 3.0)
    clear = shading.usable & (level > -0.25)
    shift, found = _best_shift(deep > 0.05, clear, step)
    if found < 0.6:
        return bright
    donor = _shifted(plate.astype(np.float32), shift) / np.maximum(_shifted(lit, shift), 1.0)
    soft = cv2.GaussianBlur(cv2.dilate(deep.astype(np.float32), np.ones((3, 3))), (0, 0), 1.5)
    share = enlarged(np.clip(soft, 0, 1), step, plate.shape)[..., None]
    good = reduced(
        _shifted(enlarged(clear.astype(np.float32), step, plate.shape), shift), step, deep.shape
    )
    share = share * enlarged(cv2.GaussianBlur(good, (0, 0), 2), step, plate.shape)[..., None]
    return np.asarray(bright * (1 - share) + donor * lit * share, np.float32)


def _best_shift(
    wanted: NDArray[np.bool_], clear: NDArray[np.bool_], step: int
) -> tuple[tuple[int, int], float]:
    """The offset (y, x) in pixels whose ground is clear for most of `wanted`, and that share."""
    best, shift = 0.0, (0, 0)
    for candidate in _SHIFTS:
        moved = _shifted(clear, (candidate[0] // step, candidate[1] // step))
        share = float(moved[wanted].mean())
        if share > best + 1e-9:
            best, shift = share, candidate
    return shift, best


def _shifted(picture: NDArray, shift: tuple[int, int]) -> NDArray:
    """At each pixel what lies `shift` (y, x) away; zero beyond the border."""
    height, width = picture.shape[:2]
    result = np.zeros_like(picture)
    dy, dx = shift
    y0, y1 = max(0, -dy), min(height, height - dy)
    x0, x1 = max(0, -dx), min(width, width - dx)
    if y0 < y1 and x0 < x1:
        result[y0:y1, x0:x1] = picture[y0 + dy : y1 + dy, x0 + dx : x1 + dx]
    return result
