"""Another size and shape of picture: cropped or letterboxed, with everything that belongs to it."""

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.errors import InputError
from physagent_studio.records.clip_look import Way
from physagent_studio.rendering import Flow

MULTIPLE = 2
"""Sides are even, as video wants them."""


@dataclass(frozen=True, slots=True)
class Framing:
    """How pictures of one size become pictures of another: scaled evenly, then moved.

    A place (x, y) of the old picture is at `scale · (x, y) + offset` of the new one, pixels.
    """

    before: tuple[int, int]
    after: tuple[int, int]
    scale: float
    offset: tuple[float, float]

    @classmethod
    def of(cls, before: tuple[int, int], after: tuple[int, int], way: Way = "crop") -> Self:
        """Sizes are (width, height). Raises InputError for a size that no picture has."""
        if min(after) < 16 or any(side % MULTIPLE for side in after):
            raise InputError(f"{after[0]}×{after[1]} is no size for a clip: even sides from 16 on")
        ratios = [new / old for new, old in zip(after, before, strict=True)]
        scale = max(ratios) if way == "crop" else min(ratios)
        x, y = ((new - scale * old) / 2 for new, old in zip(after, before, strict=True))
        return cls(before, after, scale, (x, y))

    def intrinsics(self, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
        """K (3, 3) of the camera that sees the new picture."""
        x, y = self.offset
        move = np.array([[self.scale, 0, x], [0, self.scale, y], [0, 0, 1]])
        return np.asarray(move @ matrix)

    def picture(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """(H', W', 3), averaged where it shrinks; black where there is none."""
        if self.scale == 1.0:
            return self._warped(image, 1.0, cv2.INTER_LINEAR)
        width, height = (max(1, round(self.scale * side)) for side in self.before)
        way = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_CUBIC
        scaled = np.asarray(cv2.resize(image, (width, height), interpolation=way), np.uint8)
        return self._warped(scaled, 1.0, cv2.INTER_LINEAR)

    def labels(self, image: NDArray, outside: int = 0) -> NDArray:
        """(H', W') the value of the nearest old pixel; `outside` where there is none."""
        return self._warped(image, self.scale, cv2.INTER_NEAREST, outside)

    def flow(self, flow: Flow) -> Flow:
        """Vectors in pixels of the new picture."""
        vectors = self._warped(flow.vectors, self.scale, cv2.INTER_NEAREST) * np.float32(self.scale)
        seen = self._warped(flow.visible.astype(np.uint8), self.scale, cv2.INTER_NEAREST)
        return Flow(vectors, seen > 0)

    def _warped(self, image: NDArray, scale: float, way: int, outside: int = 0) -> NDArray:
        # OpenCV's pixel centres are whole numbers, ours halves.
        x, y = (move + scale / 2 - 0.5 for move in self.offset)
        matrix = np.array([[scale, 0, x], [0, scale, y]], np.float64)
        border = (float(outside),) * 4
        return np.asarray(cv2.warpAffine(image, matrix, self.after, flags=way, borderValue=border))
