"""Where words stand in the scene: in the photo's own view none covers another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.camera import Camera

FloatArray = NDArray[np.float64]
Box = tuple[float, float, float, float]
"""Left, top, right and bottom, pixels of the view."""

VIEW_WIDTH = 640.0
"""Pixels that the view is wide in a window of 1280 × 720, where words have the least room."""
LETTER, LINE = 7.5, 20.0
"""Pixels that a letter is wide and a line is high at most, with the ground around it, at size 1."""
NAME, VALUE = 1.0, 0.9
"""Sizes of names and of values; at 1 viser writes 13 pixels high, so that none is below 10."""
GAP = 2.0
"""Pixels between two labels."""


class Labels:
    """The words of one step, in the order in which they are placed: a later one makes way."""

    def __init__(self, camera: Camera | None) -> None:
        self._camera = camera
        self.boxes: list[Box] = []

    def place(
        self, point: FloatArray, text: str, size: float = VALUE, *, below: bool = False
    ) -> FloatArray:
        """The place (3,) m of a label that points at `point`: there, or as far above it (or
        below) as is needed to cover no other. Without a photo it stays where it points.
        """
        if self._camera is None:
            return point
        pixels, depth = self._camera.project(np.asarray(point, float)[None])
        if depth[0] <= 0:
            return point
        scale = VIEW_WIDTH / self._camera.size[0]
        x, y = (float(part) * scale for part in pixels[0])
        half, high = (LETTER * len(text) * size + 8) / 2, LINE * size
        bottom = y + high if below else y
        while (other := self._covered(x - half, bottom - high, x + half, bottom)) is not None:
            bottom = other[3] + GAP + high if below else other[1] - GAP
        self.boxes.append((x - half, bottom - high, x + half, bottom))
        moved = y - (bottom - high if below else bottom)
        lift = moved / scale * float(depth[0]) / self._camera.focal
        return np.asarray(point, float) + np.array([0.0, 0.0, lift])

    def _covered(self, left: float, top: float, right: float, bottom: float) -> Box | None:
        for box in self.boxes:
            if left < box[2] and right > box[0] and top < box[3] and bottom > box[1]:
                return box
        return None
