"""A box or a wedge on the ground, told in camera heights."""

import itertools
import math
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp, Slab

BOX = np.array(list(itertools.product((-0.5, 0.5), (-0.5, 0.5), (0.0, 1.0))))
WEDGE = np.array(
    [(-0.5, -0.5, 0), (-0.5, 0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (0.5, -0.5, 1), (0.5, 0.5, 1)]
)
"""Corners of a unit box and of a unit wedge that rises along +x."""
Kind = Literal["box", "wedge", "slope"]
"""A slope is a wedge of which only the upper side is in the region: its sides are in the shade."""
CORNERS = {"box": BOX, "wedge": WEDGE, "slope": WEDGE[[0, 1, 5, 4]]}
FACES = {
    "box": ((1, 3, 7, 5), (4, 6, 7, 5), (0, 2, 3, 1), (2, 6, 7, 3), (0, 4, 5, 1)),
    "wedge": ((0, 1, 5, 4), (2, 3, 5, 4), (0, 2, 4), (1, 3, 5)),
    "slope": ((0, 1, 2, 3),),
}
"""The corners of every face but the bottom, in turn."""


@dataclass(frozen=True, slots=True)
class Block:
    """A box or wedge on the ground, in camera heights.

    x, y: middle of its base. size: (length, width, height). yaw: turn of its length, radians; a
    wedge rises along it.
    """

    x: float
    y: float
    size: tuple[float, float, float]
    yaw: float
    kind: Kind = "box"

    def slab(self, height: float) -> Slab:
        """A box in metres, for a camera `height` m above the ground."""
        size = (self.size[0] * height, self.size[1] * height, self.size[2] * height)
        return Slab(
            position=(self.x * height, self.y * height, size[2] / 2), size=size, yaw=self.yaw
        )

    def carries(self, camera: Camera, pixel: tuple[float, float], slack: float = 3.0) -> bool:
        """Whether a pixel shows its top or slope, or lies nearer to it than slack (pixels).

        A slope that is seen from below carries nothing that is seen. Only the camera's directions
        count.
        """
        unit = camera.model_copy(update={"position": (0.0, 0.0, 1.0)})
        top = placed(CORNERS[self.kind], self)[list(FACES[self.kind][0])]
        corners, depth = unit.project(top)
        across = np.cross(top[1] - top[0], top[2] - top[0])
        above = float(across @ (np.array(unit.position) - top[0])) * np.sign(across[2])
        if depth.min() <= 0 or above <= 0:
            return False
        outline = cv2.convexHull(corners.astype(np.float32))
        return cv2.pointPolygonTest(outline, (float(pixel[0]), float(pixel[1])), True) >= -slack

    def ramp(self, height: float) -> Ramp:
        """A wedge in metres, for a camera `height` m above the ground."""
        run, width, rise = (side * height for side in self.size)
        x = self.x * height - math.cos(self.yaw) * run / 2
        y = self.y * height - math.sin(self.yaw) * run / 2
        return Ramp(toe=(x, y, 0.0), yaw=self.yaw, run=run, rise=rise, width=width)


def placed(corners: FloatArray, block: Block) -> FloatArray:
    """(N, 3) corners of a unit body where the block is."""
    local = corners * block.size
    cos, sin = math.cos(block.yaw), math.sin(block.yaw)
    x = block.x + cos * local[:, 0] - sin * local[:, 1]
    y = block.y + sin * local[:, 0] + cos * local[:, 1]
    return np.column_stack([x, y, local[:, 2]])
