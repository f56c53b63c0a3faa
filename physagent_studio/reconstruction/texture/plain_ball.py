"""Balls of one colour: whatever changes slowly over such a ball is light, and stays as it rolls.

Cast shade, what the ground throws back and soft highlights are no smooth function of the normal,
so some of each is left where light is fitted. On a ball of several colours it cannot be told from
paint; on a plain one it can, and would roll along as veins and crescents.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.reconstruction.photo.regions import bounds, shrink
from physagent_studio.records.case import Image
from physagent_studio.rendering.lit import DARK


@dataclass(frozen=True, slots=True)
class PlainSettings:
    """When a ball is of one colour, and how much of its look is detail of its own."""

    min_px: int = 300  # 100..2000: of the ball, below which nothing is told
    inner_ratio: float = 0.12  # 0.02..0.3: over its width, the rim that is not asked
    step_ratio: float = 0.05  # 0.02..0.15: over its width, across which paint meets paint
    # log, 0.1..0.4: least change of brightness over such a step that is an edge of paint
    edge_tone_log: float = 0.18
    edge_hue_share: float = 0.11  # 0.05..0.3: the same of the shares that colours have in it
    max_edge_share: float = 0.02  # 0..0.1: of what is asked, at an edge; more is a pattern
    max_hue_share: float = 0.16  # 0.05..0.4: nine tenths of the ball stray no farther in hue
    fine_ratio: float = 0.05  # 0.01..0.2: over the width, spread below which detail is its own
    dark_detail_log: float = 0.6  # log, 0.1..1: how dark such detail may be: a stem was there
    bright_detail_log: float = 0.12  # log, 0.02..0.5: how bright it may be: gloss is light


PLAIN = PlainSettings()


def is_plain(picture: Image, mask: BoolArray) -> bool:
    """Whether a ball (H, W) shows a single colour in a picture (H, W, 3), its light aside.

    Nowhere does its colour jump as it does where paint meets paint, and its hue is one.
    """
    if np.count_nonzero(mask) < PLAIN.min_px:
        return False
    width = _width(mask)
    inner = shrink(mask, max(2, round(PLAIN.inner_ratio * width)))
    if not inner.any():
        return False
    tone, hue = _tone_and_hue(picture)
    step = max(2, round(PLAIN.step_ratio * width))
    soft = [cv2.GaussianBlur(part, (0, 0), step / 3) for part in (tone, hue)]
    edges = np.zeros(mask.shape, bool)
    for part, least in zip(soft, (PLAIN.edge_tone_log, PLAIN.edge_hue_share), strict=True):
        flat = part if part.ndim == 3 else part[..., None]
        for axis in (0, 1):
            change = np.linalg.norm(np.roll(flat, -step, axis) - flat, axis=-1)
            edges |= (change > least) & inner & np.roll(inner, -step, axis)
    stray = np.linalg.norm(hue[inner] - np.median(hue[inner], axis=0), axis=-1)
    return bool(
        edges[inner].mean() <= PLAIN.max_edge_share
        and np.percentile(stray, 90) <= PLAIN.max_hue_share
    )


def plainly_painted(picture: Image, mask: BoolArray) -> Image:
    """The picture (H, W, 3) with the ball (H, W) in its one colour, with its fine detail."""
    x0, y0, x1, y1 = bounds(mask)
    part = (slice(y0, y1), slice(x0, x1))
    own = mask[part].astype(np.float32)
    logs = np.log(picture[part].astype(np.float32) + DARK)
    spread = max(1.0, PLAIN.fine_ratio * _width(mask))
    near = cv2.GaussianBlur(own, (0, 0), spread)[..., None]
    slow = cv2.GaussianBlur(logs * own[..., None], (0, 0), spread) / np.maximum(near, 1e-3)
    detail = np.clip(logs - slow, -PLAIN.dark_detail_log, PLAIN.bright_detail_log)
    inner = shrink(mask, max(2, round(PLAIN.inner_ratio * _width(mask))))[part]
    colour = np.median(logs[inner if inner.any() else own > 0], axis=0)
    plain = np.exp(colour + detail) - DARK
    out = picture.copy()
    out[part][mask[part]] = np.clip(plain + 0.5, 0, 255).astype(np.uint8)[mask[part]]
    return out


def _width(mask: BoolArray) -> float:
    """The diameter, pixels, of a disc as large as the mask (H, W)."""
    return 2 * math.sqrt(np.count_nonzero(mask) / math.pi)


def _tone_and_hue(picture: Image) -> tuple[FloatArray, FloatArray]:
    """(H, W) the log of brightness and (H, W, 3) the share that each colour has in it."""
    colours = picture.astype(np.float32) + DARK
    total = colours.sum(-1)
    return np.log(total), colours / total[..., None]
