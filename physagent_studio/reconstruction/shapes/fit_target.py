"""The mask that a shape is fitted to, cut out and shrunk, so that a comparison costs little."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds


@dataclass(frozen=True, eq=False, slots=True)
class Target:
    """The mask cut out and shrunk: picture (x, y) → ((x, y) − origin) · factor.

    open: pixels where the object would be seen if it were there.
    """

    mask: BoolArray
    open: BoolArray
    area: int
    origin: tuple[float, float]
    factor: float
    width: float
    height: float

    @classmethod
    def of(cls, mask: BoolArray, hidden: BoolArray | None, side: int = 150) -> Target:
        x0, y0, x1, y1 = bounds(mask)
        pad = 0.15 * max(x1 - x0, y1 - y0) + 2
        factor = side / (max(x1 - x0, y1 - y0) + 2 * pad)
        size = (int((x1 - x0 + 2 * pad) * factor), int((y1 - y0 + 2 * pad) * factor))
        move = np.array([[factor, 0, -(x0 - pad) * factor], [0, factor, -(y0 - pad) * factor]])
        # Pixel centres, not corners, are what warpAffine maps.
        move[:, 2] += 0.5 * factor - 0.5
        small = cv2.warpAffine(mask.astype(np.float32), move, size, flags=cv2.INTER_LINEAR)
        solid = np.asarray(small > 0.5)
        free = np.ones_like(solid)
        if hidden is not None:
            cover = (hidden & ~mask).astype(np.float32)
            free = np.asarray(cv2.warpAffine(cover, move, size, flags=cv2.INTER_LINEAR) < 0.5)
        area, origin = int((solid & free).sum()), (x0 - pad, y0 - pad)
        return cls(solid & free, free, area, origin, factor, float(x1 - x0), float(y1 - y0))

    def iou(self, pixels: FloatArray) -> float:
        """IoU of the mask with the convex hull of picture points (N, 2)."""
        hull = cv2.convexHull((self.local(pixels) * 16).astype(np.float32)).astype(np.int32)
        canvas = np.zeros(self.mask.shape, np.uint8)
        cv2.fillConvexPoly(canvas, hull, 1, shift=4)
        return self.iou_of(canvas)

    def local(self, pixels: FloatArray) -> FloatArray:
        """Picture points (N, 2) in the window, whose pixel (0, 0) has its centre at (0, 0)."""
        return (pixels - self.origin) * self.factor - 0.5

    def iou_of(self, canvas: NDArray[np.uint8] | None) -> float:
        """IoU of the mask with what is drawn in the window, where it could be seen."""
        if canvas is None:
            return 0.0
        drawn = canvas.astype(bool) & self.open
        both = int(np.count_nonzero(drawn & self.mask))
        return both / max(self.area + int(np.count_nonzero(drawn)) - both, 1)
