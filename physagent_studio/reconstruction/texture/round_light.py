"""Light on a round body, and what of its look comes once or many times."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.scene.state import Ellipsoid, SceneObject, Sphere


@dataclass(frozen=True, slots=True)
class RoundSettings:
    """What is round, and what on it is a pattern."""

    # 0..0.02: of the picture of what is strange; smaller parts are noise
    min_speck_share: float = 0.002
    min_parts: int = 3  # count, 2..8: of them that are a pattern
    # 0.4..0.95: of all of it: a larger part is there by itself, with crumbs
    max_lone_share: float = 0.7


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
