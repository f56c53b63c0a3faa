"""Exact flow: every pixel's surface point, followed to where another frame has it; and normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.frame import Flow, Frame
from physagent_studio.rendering.raster import NEAR, FloatArray

_DEPTH_TOLERANCE = 0.01
"""Share of its depth by which a point may lie behind what the next frame shows at its pixel."""
_BESIDE = 0.75
"""Pixels, across and down, up to which a pixel's middle tells of a point beside it."""


def flow_between(frame: Frame, following: Frame) -> Flow:
    """Flow from one frame to another of the same `Compositor`: the next, or the one before.

    A point that leaves the picture or is hidden in the other frame has its true vector and
    `visible` False; one that passes behind the camera has 0 and False.
    """
    height, width = frame.ids.shape
    hits, lens = frame.surface.hits, frame.surface.lens
    corners = following.surface.points[frame.surface.faces[hits.face]]
    moved = np.einsum("ki,kij->kj", hits.weights, corners)
    ahead = moved[:, 2] > NEAR
    moved[~ahead, 2] = 1.0
    target = lens.project(moved)
    y, x = np.divmod(hits.pixel, width)
    start = np.stack([x + 0.5, y + 0.5], 1)
    vectors = np.zeros((height * width, 2), np.float32)
    vectors[hits.pixel] = np.where(ahead[:, None], target - start, 0)
    visible = (following.ids < 0).ravel()
    owner = frame.ids.ravel()[hits.pixel]
    visible[hits.pixel] = ahead & still_seen(following, target, moved[:, 2], owner)
    return Flow(vectors.reshape(height, width, 2), visible.reshape(height, width))


def still_seen(
    following: Frame, target: FloatArray, depth: FloatArray, owner: NDArray[np.int16]
) -> NDArray[np.bool_]:
    """Whether a pixel whose middle is close to a target shows the same object at the same depth."""
    height, width = following.ids.shape
    inside = (target >= 0).all(1) & (target[:, 0] < width) & (target[:, 1] < height)
    centred = np.where(inside[:, None], target, 0) - 0.5
    left = np.floor(centred).astype(np.int64)
    seen = np.zeros(len(target), bool)
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        x = np.clip(left[:, 0] + dx, 0, width - 1)
        y = np.clip(left[:, 1] + dy, 0, height - 1)
        near = np.abs(left + np.array([dx, dy]) - centred).max(1) < _BESIDE
        same = near & (following.ids[y, x] == owner)
        seen |= same & (depth <= following.depth[y, x] * (1 + _DEPTH_TOLERANCE))
    return inside & seen


def normals_of(frame: Frame) -> NDArray[np.float32]:
    """(H, W, 3) unit normals of the faces that a frame shows, camera frame (x right, y down, z

    ahead), towards the camera; 0 on the background.
    """
    hits = frame.surface.hits
    a, b, c = (frame.surface.points[frame.surface.faces[hits.face][:, k]] for k in range(3))
    found = np.cross(b - a, c - a)
    found /= np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-18)
    away = (found * a).sum(1) > 0
    found[away] *= -1
    out = np.zeros((frame.ids.size, 3), np.float32)
    out[hits.pixel] = found
    return out.reshape(*frame.ids.shape, 3)
