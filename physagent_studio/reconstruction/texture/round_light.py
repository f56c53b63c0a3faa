"""Light on a round body, and what of its look comes once or many times."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.scene.state import Ellipsoid, SceneObject, Sphere
from physagent_studio.reconstruction.photo.regions import grow
from physagent_studio.records.case import Image
from physagent_studio.rendering.lit import DARK


@dataclass(frozen=True, slots=True)
class RoundSettings:
    """What is round, and what on it is a pattern."""

    # 0..0.02: of the picture of what is strange; smaller parts are noise
    min_speck_share: float = 0.002
    min_parts: int = 3  # count, 2..8: of them that are a pattern
    # 0.4..0.95: of all of it: a larger part is there by itself, with crumbs
    max_lone_share: float = 0.7
    # 0..0.5: over a thing's width: how near to its outline, and how far, what throws light is seen
    foot_ratios: tuple[float, float] = (0.04, 0.15)
    foot_share: float = 0.25  # 0..0.5: of its height, as far below its middle as that begins
    min_thrown_log: float = 0.12  # 0.03..0.4: of saturation, below which that is grey


ROUND = RoundSettings()


def radii_of(item: SceneObject) -> FloatArray | None:
    """(3,) radii of a ball or an ellipsoid; None for others."""
    if isinstance(item.shape, Sphere):
        return np.full(3, item.shape.radius)
    return np.asarray(item.shape.radii, float) if isinstance(item.shape, Ellipsoid) else None


def terms_of(ways: FloatArray) -> FloatArray:
    """(N, 6) of which light on a body is a sum, by direction (N, 3)."""
    x, y = ways[:, 0], ways[:, 1]
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1)


def fitted(terms: FloatArray, tone: FloatArray) -> FloatArray:
    """(6, 3) by which terms (N, 6) come nearest to most of what is seen (N, 3)."""
    pull = 0.01 * len(terms) * np.diag([0.0, 1, 1, 1, 1, 1])
    weight, fit = np.ones(len(terms)), np.zeros((terms.shape[1], 3))
    for _ in range(8):
        fit = np.linalg.solve((terms.T * weight) @ terms + pull, (terms.T * weight) @ tone)
        rest = np.abs(tone - terms @ fit).mean(-1)
        # What is painted otherwise, and highlights, are no light.
        weight = 1 / (1 + (rest / max(1.5 * float(np.median(rest)), 0.03)) ** 2)
    return np.asarray(fit, np.float64)


def is_pattern(strange: BoolArray) -> bool:
    """Whether what is strange (K, K) comes several times, as on a football."""
    stats = cv2.connectedComponentsWithStats(strange.astype(np.uint8))[2][1:]
    areas = np.array([row[cv2.CC_STAT_AREA] for row in stats], float)
    large = areas[areas > ROUND.min_speck_share * strange.size]
    return len(large) >= ROUND.min_parts and bool(large.max() < ROUND.max_lone_share * large.sum())


def thrown_back(photo: Image, mask: BoolArray) -> FloatArray:
    """The unit hue (3,), log, of what lies around a thing's foot (H, W); 0 where that is grey."""
    rows, columns = np.nonzero(mask)
    width = min(np.ptp(rows), np.ptp(columns)) + 1
    near, far = (max(2, round(share * width)) for share in ROUND.foot_ratios)
    below = grow(mask, max(4, far)) & ~grow(mask, near)
    below[: round(rows.mean() + ROUND.foot_share * np.ptp(rows))] = False
    if not below.any():
        return np.zeros(3)
    hue = np.median(np.log(photo[below] + DARK), axis=0)
    hue -= hue.mean()
    length = float(np.linalg.norm(hue))
    return hue / length if length > ROUND.min_thrown_log else np.zeros(3)
