"""Intelligent scissors: the way along edges of the picture from an anchor to the pointer."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class ScissorsSettings:
    """Where ways are sought, and what is an edge for them."""

    side_px: int = 1100  # 400..2000: the picture's longer side, larger ones are shrunk to it
    reach_px: int = 260  # 100..600: around the anchor, in which a way is looked for in time
    canny_levels: tuple[float, float] = (32, 100)  # 5..300: gradients of weak and strong edges
    full_levels: float = 200.0  # 50..500: gradient from which an edge is as strong as can be


SCISSORS = ScissorsSettings()


class LiveEdge:
    """Ways along edges of one picture; the map of the last anchor is kept."""

    def __init__(self, image: Image) -> None:
        self.image = image
        self.factor = min(1.0, SCISSORS.side_px / max(image.shape[:2]))
        small = image
        if self.factor < 1:
            size = (round(image.shape[1] * self.factor), round(image.shape[0] * self.factor))
            small = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
        self._small = small
        self._anchor: tuple[int, int] | None = None
        self._origin = (0, 0)
        self._tool = cv2.segmentation.IntelligentScissorsMB()

    def way(
        self, start: Sequence[float], end: Sequence[float], accuracy: float = 0.8
    ) -> list[tuple[float, float]]:
        """Points from `start` to `end`, both pixels (x, y) of the picture, along its edges.

        A target out of reach is joined by a straight line.
        """
        begin = self._inside(start)
        if begin != self._anchor:
            self._map(begin)
        x, y = self._inside(end)
        x, y = x - self._origin[0], y - self._origin[1]
        rows, columns = self._part.shape[:2]
        straight = [(float(start[0]), float(start[1])), (float(end[0]), float(end[1]))]
        if not (0 <= x < columns and 0 <= y < rows) or (x, y) == self._local(begin):
            return straight
        found = self._tool.getContour((x, y))
        thin = cv2.approxPolyDP(found.reshape(-1, 1, 2), accuracy, closed=False).reshape(-1, 2)
        middle = (thin[1:-1] + np.array(self._origin) + 0.5) / self.factor
        return [straight[0], *((float(a), float(b)) for a, b in middle), straight[1]]

    def _inside(self, point: Sequence[float]) -> tuple[int, int]:
        rows, columns = self._small.shape[:2]
        x = int(np.clip(point[0] * self.factor, 0, columns - 1))
        y = int(np.clip(point[1] * self.factor, 0, rows - 1))
        return x, y

    def _local(self, point: tuple[int, int]) -> tuple[int, int]:
        return point[0] - self._origin[0], point[1] - self._origin[1]

    def _map(self, anchor: tuple[int, int]) -> None:
        x, y = anchor
        self._origin = (max(0, x - SCISSORS.reach_px), max(0, y - SCISSORS.reach_px))
        x0, y0 = self._origin
        self._part = np.ascontiguousarray(
            self._small[y0 : y + SCISSORS.reach_px, x0 : x + SCISSORS.reach_px]
        )
        self._tool.setEdgeFeatureCannyParameters(*SCISSORS.canny_levels)
        self._tool.setGradientMagnitudeMaxLimit(SCISSORS.full_levels)
        self._tool.applyImage(self._part)
        self._tool.buildMap(self._local(anchor))
        self._anchor = anchor
