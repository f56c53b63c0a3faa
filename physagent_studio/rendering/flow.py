"""Exact flow: every pixel's surface point, followed to where another frame has it; and normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.frame import Flow, Frame
from physagent_studio.rendering.raster import NEAR, FloatArray, Hits, between

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
    hits, faces = frame.surface.hits, frame.surface.faces
    owner = frame.ids.ravel()[hits.pixel]
    vectors = np.zeros((height * width, 2), np.float32)
    visible = (following.ids < 0).ravel()
    # What stands still is where it was, and is hidden where something else is seen now.
    visible[hits.pixel] = following.ids.ravel()[hits.pixel] == owner
    moving = (frame.surface.points != following.surface.points).any(1)
    moving = moving[faces[:, 0]] | moving[faces[:, 1]] | moving[faces[:, 2]]
    rows = np.flatnonzero(moving[hits.face])
    own = Hits(hits.pixel[rows], hits.face[rows], hits.weights[rows], hits.depth[rows])
    moved = between(own, following.surface.points, faces)
    ahead = moved[:, 2] > NEAR
    moved[~ahead, 2] = 1.0
    target = frame.surface.lens.project(moved)
    y, x = np.divmod(own.pixel, width)
    start = np.stack([x + 0.5, y + 0.5], 1)
    vectors[own.pixel] = np.where(ahead[:, None], target - start, 0)
    visible[own.pixel] = ahead & still_seen(following, target, moved[:, 2], owner[rows])
    return Flow(vectors.reshape(height, width, 2), visible.reshape(height, width))


def still_seen(
    following: Frame, target: FloatArray, depth: FloatArray, owner: NDArray[np.int16]
) -> NDArray[np.bool_]:
    """Whether a pixel whose middle is close to a target shows the same object at the same depth."""
    height, width = following.ids.shape
    x, y = target[:, 0], target[:, 1]
    inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    centre = [np.where(inside, part, 0) - 0.5 for part in (x, y)]
    corner = [np.floor(part) for part in centre]
    ids, behind = following.ids.ravel(), following.depth.ravel()
    nearer = depth / (1 + _DEPTH_TOLERANCE)
    seen = np.zeros(len(target), bool)
    for dx in (0, 1):
        for dy in (0, 1):
            across, down = corner[0] + dx, corner[1] + dy
            near = (np.abs(across - centre[0]) < _BESIDE) & (np.abs(down - centre[1]) < _BESIDE)
            at = np.clip(down, 0, height - 1) * width + np.clip(across, 0, width - 1)
            at = at.astype(np.int64)
            seen |= near & (ids[at] == owner) & (nearer <= behind[at])
    return inside & seen


def normals_of(frame: Frame) -> NDArray[np.float32]:
    """(F, 3) unit normals of a frame's faces, camera frame (x right, y down, z ahead), towards the

    camera.
    """
    a, b, c = (frame.surface.points[frame.surface.faces[:, k]] for k in range(3))
    found = np.cross(b - a, c - a)
    found /= np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-18)
    found[(found * a).sum(1) > 0] *= -1
    return found.astype(np.float32)
