"""Exact flow: every pixel's surface point in another frame; normals; points tracked on."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.camera import Camera
from physagent_studio.rendering.frame import Flow, Frame
from physagent_studio.rendering.raster import NEAR, FloatArray, Hits, IntArray, between

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


@dataclass(frozen=True, eq=False, slots=True)
class Tracked:
    """Points of one frame. pixels: (N, 2) x, y. world: (N, 3) m. visible: (N,) bool."""

    pixels: NDArray[np.float32]
    world: NDArray[np.float32]
    visible: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class Tracks:
    """Surface points chosen in one frame. corners: (N, 3) rows of the frame's points, weights:
    (N, 3) barycentric; owner: (N,) index of the object."""

    corners: IntArray
    weights: FloatArray
    owner: NDArray[np.int16]

    @classmethod
    def seeded(cls, frame: Frame, spacing: int) -> Self:
        """A point wherever a grid of that spacing, pixels, lies on an object of the frame.

        A thing too small for the grid has the pixel nearest to its middle.
        """
        width = frame.ids.shape[1]
        hits = frame.surface.hits
        y, x = np.divmod(hits.pixel, width)
        owner = frame.ids.ravel()[hits.pixel]
        chosen = (x % spacing == spacing // 2) & (y % spacing == spacing // 2) & (owner >= 0)
        for index in np.unique(owner[owner >= 0]):
            own = np.flatnonzero(owner == index)
            if not chosen[own].any():
                far = np.hypot(x[own] - x[own].mean(), y[own] - y[own].mean())
                chosen[own[far.argmin()]] = True
        faces = frame.surface.faces[hits.face[chosen]]
        return cls(faces, hits.weights[chosen], owner[chosen])

    def at(self, frame: Frame, camera: Camera) -> Tracked:
        """Where the points are in a frame of the same `Compositor`."""
        lens = frame.surface.lens
        places = np.einsum("ki,kij->kj", self.weights, frame.surface.points[self.corners])
        ahead = places[:, 2] > NEAR
        safe = np.where(ahead[:, None], places, (0.0, 0.0, 1.0))
        pixels = np.where(ahead[:, None], lens.project(safe), np.nan)
        seen = ahead & still_seen(frame, np.nan_to_num(pixels), places[:, 2], self.owner)
        world = places @ camera.matrix.T + np.asarray(camera.position)
        return Tracked(pixels.astype(np.float32), world.astype(np.float32), seen)
