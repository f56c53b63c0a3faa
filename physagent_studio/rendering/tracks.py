"""Points on the things, followed through a clip: where they are seen, where they are, if seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.camera import Camera
from physagent_studio.rendering.flow import still_seen
from physagent_studio.rendering.frame import Frame
from physagent_studio.rendering.raster import NEAR, FloatArray, IntArray


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
