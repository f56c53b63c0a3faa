"""Lines that run behind what is taken out of a picture: seen on both sides of it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import Slab, Support
from physagent_studio.reconstruction.lines import Segments
from physagent_studio.reconstruction.masks import BoolArray
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]
NEAR = 14.0
"""How far from the hole a line may end to run into it, pixels."""
BENT = math.radians(5.0)
BESIDE = 3.0
"""Pixels, and share of the gap, by which two ends may miss one another's line."""
SEEN = 12.0
"""Difference in colour across an edge that counts as seen, grey levels."""
ALIKE = 45.0
"""Largest difference in colour on either side of two pieces of one line, grey levels."""


def lines_through(photo: Image, hole: BoolArray, found: Segments) -> FloatArray:
    """Lines (N, 2, 2), pixels, that join two edges of the picture across the hole (H, W)."""
    ends, ways = _heading_in(hole, found)
    if len(ends) < 2:
        return np.zeros((0, 2, 2))
    colours = _sides(photo, ends, ways)
    pairs = []
    for i in range(len(ends)):
        for j in range(i + 1, len(ends)):
            missed = _missed(ends[i], ways[i], ends[j], ways[j])
            if missed is None or not _within(hole, ends[i], ends[j]):
                continue
            # Facing one another, the left of one is the right of the other.
            apart = np.abs(colours[i] - colours[j, ::-1]).mean(-1).max()
            if apart < ALIKE:
                pairs.append((missed, i, j))
    taken: set[int] = set()
    out = []
    for _, i, j in sorted(pairs):
        if i not in taken and j not in taken:
            taken |= {i, j}
            out.append((ends[i], ends[j]))
    return np.array(out).reshape(-1, 2, 2)


def ways_into(hole: BoolArray, found: Segments, most: int = 8) -> FloatArray:
    """Directions (N, 2) of the longest edges that run into the hole (H, W), no two alike."""
    ends, ways = _heading_in(hole, found)
    out: list[FloatArray] = []
    for way in ways[np.argsort(-_lengths(ends, found), kind="stable")]:
        if all(abs(float(way @ other)) < math.cos(BENT) for other in out):
            out.append(way)
    return np.array(out[:most]).reshape(-1, 2)


def _lengths(tips: FloatArray, found: Segments) -> FloatArray:
    """(N,) how long the edges with these tips (N, 2) are, pixels."""
    long = np.linalg.norm(found.ends[:, 1] - found.ends[:, 0], axis=1)
    return np.array([long[(found.ends == tip).all(2).any(1)].max() for tip in tips])


def edges_of(
    photo: Image, hole: BoolArray, camera: Camera, supports: Sequence[Support]
) -> FloatArray:
    """Edges (N, 2, 2), pixels, of level tops that run behind the hole (H, W).

    An edge that was read off the picture has to be seen there where it is not hidden; where a
    person marked the corners it is taken as it is.
    """
    out = []
    grey = cv2.GaussianBlur(photo, (0, 0), 1.5).astype(float)
    for support in supports:
        if not isinstance(support.shape, Slab):
            continue
        corners, depth = camera.project(_top_corners(support.shape))
        if depth.min() <= 0.05 * abs(depth).max():
            continue
        marked = bool(support.grounding.marked("top"))
        for one, other in zip(corners, np.roll(corners, -1, 0), strict=True):
            along = one + np.linspace(0, 1, 200)[:, None] * (other - one)
            inside = (along >= 0).all(1) & (along < (hole.shape[1], hole.shape[0])).all(1)
            hidden = inside & (_at(hole, along) > 0)
            if hidden.any() and (marked or _is_seen(grey, along[inside & ~hidden], other - one)):
                out.append((one, other))
    return np.array(out).reshape(-1, 2, 2)


def _top_corners(slab: Slab) -> FloatArray:
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    flat = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(slab.size[:2]) / 2
    turned = flat @ np.array([[cos, sin], [-sin, cos]]) + slab.position[:2]
    return np.column_stack([turned, np.full(4, slab.position[2] + slab.size[2] / 2)])


def _is_seen(grey: FloatArray, along: FloatArray, way: FloatArray) -> bool:
    """Whether colours differ on the two sides along most of a line's visible part."""
    if len(along) < 10:
        return False
    normal = np.array([-way[1], way[0]]) / max(float(np.linalg.norm(way)), 1e-9)
    step = np.abs(_at(grey, along + 4 * normal) - _at(grey, along - 4 * normal)).mean(-1)
    return float((step > SEEN).mean()) > 0.6


def _heading_in(hole: BoolArray, found: Segments) -> tuple[FloatArray, FloatArray]:
    """Ends (N, 2) of edges at the hole and unit directions (N, 2) into it."""
    away = cv2.distanceTransform((~hole).astype(np.uint8), cv2.DIST_L2, 5)
    ends, ways = [], []
    for one, other in found.ends:
        for tip, tail in ((one, other), (other, one)):
            way = (tip - tail) / max(float(np.linalg.norm(tip - tail)), 1e-9)
            ahead = tip + np.outer((0.0, 6.0, 12.0, 20.0), way)
            gaps = _at(away, ahead)
            if gaps[0] < NEAR and gaps.min() == 0 and _at(away, tail[None])[0] > 0:
                ends.append(tip)
                ways.append(way)
    return np.array(ends).reshape(-1, 2), np.array(ways).reshape(-1, 2)


def _at(image: NDArray, points: FloatArray) -> FloatArray:
    x = np.clip(points[:, 0].astype(int), 0, image.shape[1] - 1)
    y = np.clip(points[:, 1].astype(int), 0, image.shape[0] - 1)
    return np.asarray(image[y, x], float)


def _sides(photo: Image, ends: FloatArray, ways: FloatArray) -> FloatArray:
    """(N, 2, 3) colours to the left and the right of each edge, a little before its end."""
    soft = cv2.GaussianBlur(photo, (0, 0), 1.5).astype(float)
    normal = np.stack([-ways[:, 1], ways[:, 0]], 1)
    spots = ends - 6 * ways
    return np.stack([_at(soft, spots + 5 * normal), _at(soft, spots - 5 * normal)], 1)


def _missed(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> float | None:
    """How far two ends miss one another's line, pixels; None where they are not one line."""
    gap = q - p
    length = float(np.linalg.norm(gap))
    if length < 4 or gap @ u <= 0 or -(u @ v) < math.cos(BENT):
        return None
    missed = max(
        abs(float(gap[0] * u[1] - gap[1] * u[0])), abs(float(gap[0] * v[1] - gap[1] * v[0]))
    )
    return missed if missed < BESIDE + 0.03 * length else None


def _within(hole: BoolArray, p: FloatArray, q: FloatArray) -> bool:
    share = np.linspace(0, 1, 40)[:, None]
    return bool(_at(hole, p + share * (q - p)).mean() > 0.6)
