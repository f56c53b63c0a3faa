"""The camera: intrinsics, pose and how sure we are of them."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import Field

from physagent_studio.arrays import FloatArray
from physagent_studio.program.base import Frozen, Length, Pixel, Position, Quaternion, Source
from physagent_studio.program.rotations import matrix_of, quaternion_of


class Camera(Frozen):
    """A pinhole camera without distortion.

    The camera frame is x right, y down, z forward (OpenCV). `rotation` is the pose
    `R_world_camera`, `position` the optical centre in the world. A pixel (i, j) covers
    [i, i+1) × [j, j+1), so its centre lies at (i + .5, j + .5).
    """

    size: tuple[Annotated[int, Field(ge=1, le=20000)], Annotated[int, Field(ge=1, le=20000)]]
    focal: Annotated[float, Field(gt=0, le=1e6)]
    principal: Pixel
    position: Position
    rotation: Quaternion
    source: Source = "assumed"
    confirmed: bool = False
    horizon_sigma: Annotated[float, Field(ge=0, le=1e5)] | None = None

    @classmethod
    def from_horizon(
        cls,
        size: tuple[int, int],
        horizon: float,
        height: Length,
        *,
        focal: float | None = None,
        roll: float = 0.0,
        source: Source = "assumed",
        confirmed: bool = False,
        horizon_sigma: float | None = None,
    ) -> Camera:
        """A camera `height` metres above the floor z = 0 that sees the horizon at row `horizon`.

        horizon: y in pixels where the horizon crosses the middle column; outside the picture
        is allowed. focal: pixels, default 45° vertical field of view. roll: radians by which the
        camera is turned clockwise; the horizon then rises to the right.
        """
        width, rows = size
        focal = focal or rows / 2 / math.tan(math.radians(22.5))
        # Of a tilted horizon the distance from the middle counts, not that along the column.
        pitch = math.atan2((rows / 2 - horizon) * math.cos(roll), focal)
        down, ahead = math.sin(pitch), math.cos(pitch)
        # Columns are the camera's axes in the world: right, down, forward.
        level = np.array([[1, 0, 0], [0, -down, ahead], [0, -ahead, -down]], float)
        cos, sin = math.cos(roll), math.sin(roll)
        rolled = level @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
        return cls(
            size=size,
            focal=focal,
            principal=(width / 2, rows / 2),
            position=(0.0, 0.0, float(height)),
            rotation=quaternion_of(rolled),
            source=source,
            confirmed=confirmed,
            horizon_sigma=horizon_sigma,
        )

    @property
    def matrix(self) -> FloatArray:
        """`R_world_camera`, (3, 3)."""
        return matrix_of(self.rotation)

    @property
    def intrinsics(self) -> FloatArray:
        """K, (3, 3), pixels."""
        cx, cy = self.principal
        return np.array([[self.focal, 0, cx], [0, self.focal, cy], [0, 0, 1]])

    @property
    def horizon(self) -> float:
        """Row of the horizon in the middle column, pixels."""
        forward, down = self.matrix[:, 2], self.matrix[:, 1]
        # A direction in the middle column is level where its world z vanishes.
        return float(self.principal[1] - self.focal * forward[2] / min(down[2], -1e-9))

    @property
    def roll(self) -> float:
        """Radians by which the camera is turned clockwise about its optical axis."""
        right, down = self.matrix[2, 0], self.matrix[2, 1]
        return math.atan2(-right, -down)

    def horizon_at(self, column: float) -> float:
        """Row of the horizon in a column of the picture, pixels."""
        return self.horizon - math.tan(self.roll) * (column - self.principal[0])

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """World points (N, 3) → pixels (N, 2) and depths (N,) along the optical axis, m."""
        local = (np.asarray(points, float) - self.position) @ self.matrix
        depth = local[:, 2]
        safe = np.where(np.abs(depth) < 1e-9, 1e-9, depth)
        return self.focal * local[:, :2] / safe[:, None] + self.principal, depth

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Pixels (N, 2) → world directions (N, 3) whose optical-axis component is 1."""
        pixels = np.atleast_2d(np.asarray(pixels, float))
        local = np.column_stack([(pixels - self.principal) / self.focal, np.ones(len(pixels))])
        return local @ self.matrix.T
