"""Where the faces of a box meet inside its outline: straight edges within the mask.

An outline alone leaves loose how a box is turned and how deep it is; the edges at which its faces
meet settle that, where the picture shows them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.photo.line_segments import Segments


@dataclass(frozen=True, slots=True)
class CreaseSettings:
    """Which edges within a mask are creases of a box."""

    # 0.05..0.4: edges that turn more from end to end are not straight
    max_bend_rad: float = math.radians(12.0)
    # 0.01..0.1: over the longer side: how far from the outline an edge is inside
    inside_ratio: float = 0.03
    # 0.005..0.1: over the longer side: how near to a crease an edge lies
    reach_ratio: float = 0.025
    # sine, 0.02..0.3: of an edge and the vertical, to lead level
    min_level_sine: float = math.sin(math.radians(6.0))
    turn_spread_rad: float = math.radians(2.5)  # 0.01..0.2: how surely an edge tells a turn
    # IoU, 0..0.1: what creases on edges are worth beside an overlap of one
    crease_weight: float = 0.03
    max_turn_rad: float = math.radians(15.0)  # 0.05..0.5: between a crease and an edge on it


CREASE = CreaseSettings()


_SHARE = np.linspace(0.1, 0.9, 7)[None, :, None]


@dataclass(frozen=True, eq=False, slots=True)
class Creases:
    """The straight edges (N, 2, 2) within a mask and (M, 2, 2) also around it, pixels.

    reach: pixels.
    """

    ends: FloatArray
    own: FloatArray
    reach: float

    @classmethod
    def within(cls, mask: BoolArray, found: Segments) -> Creases | None:
        """Those of a mask (H, W); None where there are none."""
        rows, columns = np.nonzero(mask)
        if not len(rows) or not len(found.length):
            return None
        side = float(max(np.ptp(rows), np.ptp(columns))) + 1
        depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
        spots = found.ends[:, :1] * (1 - _SHARE) + found.ends[:, 1:] * _SHARE
        x = np.clip(spots[..., 0].astype(int), 0, mask.shape[1] - 1)
        y = np.clip(spots[..., 1].astype(int), 0, mask.shape[0] - 1)
        straight = found.bend < CREASE.max_bend_rad
        inside = straight & (np.median(depth[y, x], axis=1) > max(CREASE.inside_ratio * side, 2.0))
        rim = cv2.dilate(mask.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
        around = straight & (rim[y, x].mean(1) > 0.8)
        if not around.any():
            return None
        return cls(found.ends[inside], found.ends[around], max(CREASE.reach_ratio * side, 1.0))

    def turns(self, camera: Camera, most: int = 2) -> list[float]:
        """The likeliest turns about the vertical, −45° … 45°, of a box with these edges, rad."""
        one, other = (camera.rays(self.own[:, k]) for k in (0, 1))
        normal = np.cross(one, other)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        level = (np.abs(normal[:, 2]) > CREASE.min_level_sine) & (
            np.hypot(normal[:, 0], normal[:, 1]) > 0.05
        )
        if not level.any():
            return []
        turn = np.arctan2(-normal[level, 0], normal[level, 1])
        length = np.linalg.norm(self.own[level, 1] - self.own[level, 0], axis=1)
        grid = np.radians(np.arange(-45.0, 45.0))
        quarter = math.pi / 2
        off = (turn[None] - grid[:, None] + quarter / 2) % quarter - quarter / 2
        votes = (length * np.exp(-0.5 * (off / CREASE.turn_spread_rad) ** 2)).sum(1)
        found: list[float] = []
        while len(found) < most and votes.max() > 0.25 * length.max():
            best = float(grid[int(votes.argmax())])
            found.append(best)
            away = np.abs((grid - best + quarter / 2) % quarter - quarter / 2)
            votes[away < 4 * CREASE.turn_spread_rad] = 0
        return found

    def nearness(self, corners: FloatArray, visible: NDArray[np.bool_]) -> float:
        """How well the creases of a box lie on the edges, 0 … 1.

        corners: (8, 2) pixels, the lower four around, then the upper ones. visible: (5,) its sides
        between corner k and the next, and its top.
        """
        if not len(self.ends):
            return 0.0
        creases = [(k, k + 4) for k in range(4) if visible[k] and visible[k - 1]]
        creases += [(k + 4, (k + 1) % 4 + 4) for k in range(4) if visible[k] and visible[4]]
        if not creases:
            return 0.0
        pairs = np.array(creases)
        one, other = corners[pairs[:, 0]], corners[pairs[:, 1]]
        points = (one[:, None] * (1 - _SHARE) + other[:, None] * _SHARE).reshape(-1, 2)
        return float(np.exp(-0.5 * (self._away(points, other - one) / self.reach) ** 2).mean())

    def _away(self, points: FloatArray, ways: FloatArray) -> FloatArray:
        """(M,) pixels from each point to the nearest edge that runs as its crease does."""
        run = self.ends[:, 1] - self.ends[:, 0]
        length = np.linalg.norm(run, axis=1)
        unit = run / length[:, None]
        off = points[:, None] - self.ends[None, :, 0]
        along = np.clip((off * unit).sum(2), 0, length)
        away = np.linalg.norm(off - along[..., None] * unit, axis=2)
        way = ways / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-9)
        alike = np.abs(way @ unit.T) > math.cos(CREASE.max_turn_rad)
        away[~np.repeat(alike, len(points) // len(ways), axis=0)] = np.inf
        return away.min(1)
