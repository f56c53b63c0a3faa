"""What is out of focus beside a thing that is in focus is no part of it: it is farther or nearer.

An edge that is sharp loses most of its slope when it is smoothed; one that is blurred already
hardly any. How much is lost is compared along the outline of the thing and that of a patch.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.parts.evidence import Patch
from physagent_studio.reconstruction.photo.regions import BoolArray, grow, shrink
from physagent_studio.records.case import Image

FINE, COARSE = 1.0, 3.0
"""Pixels by which the picture is smoothed before its slopes are compared."""
LARGEST = 700
"""Longer side of the surroundings in pixels at which slopes are taken."""
VISIBLE = 1.0
"""Slope after smoothing, levels a pixel, from which there is an edge."""
NEAR, APART = 9, 4
"""Pixels within which an edge belongs to an outline, and from the mask from which one is free."""
ENOUGH = 30
"""Pixels of an outline with an edge from which its sharpness is known."""
BLURRED, SHARP = 0.62, 0.8
"""Shares of the thing's sharpness up to which and from which an outline is blurred and sharp."""
AROUND = 12
"""Pixels around a patch within which something is behind it."""


@dataclass(frozen=True, eq=False)
class Focus:
    """How sharp the edges around a mask are; looked up only once a patch is about to join.

    crop: (H, W, 3) the surroundings as the picture has them. mask: (h, w) of the same part.
    """

    crop: Image
    mask: BoolArray

    def is_lost(self, patch: Patch) -> bool:
        """Whether a patch (h, w) is out of focus where the mask's outline is not."""
        own, other = self._own, self._of(patch)
        if len(other) < ENOUGH or len(own) < ENOUGH:
            return False
        return float(np.percentile(other, 75)) < BLURRED * float(np.median(own))

    def stands_out(self, patch: Patch) -> bool:
        """Whether a patch (h, w) is in focus, as the mask is, before what is not."""
        own, other, behind = self._own, self._of(patch), self._behind(patch)
        if min(len(own), len(other), len(behind)) < ENOUGH:
            return False
        least = float(np.median(own))
        if float(np.median(behind)) >= BLURRED * least:
            return False
        return float(np.median(other)) > SHARP * least

    def _of(self, patch: Patch) -> NDArray[np.float32]:
        """Sharpness along the outline of a patch (h, w), where it is not at the mask."""
        inside = patch.region[patch.window]
        rim = np.zeros_like(patch.region)
        rim[patch.window] = grow(inside, 1) & ~inside
        return self._along(rim & ~self._near)

    def _behind(self, patch: Patch) -> NDArray[np.float32]:
        """Sharpness of what is around a patch (h, w) and neither close to it nor to the mask."""
        rows, columns = (slice(max(0, w.start - AROUND), w.stop + AROUND) for w in patch.window)
        out = np.zeros_like(patch.region)
        out[rows, columns] = ~grow(patch.region[rows, columns], 2 * APART)
        return self._along(out & ~grow(self.mask, 2 * APART))

    @cached_property
    def _near(self) -> BoolArray:
        """(h, w) the mask and what is close to it."""
        return grow(self.mask, APART)

    @cached_property
    def _own(self) -> NDArray[np.float32]:
        """Sharpness along the outline of the mask."""
        return self._along(self.mask & ~shrink(self.mask, 1))

    def _along(self, line: BoolArray) -> NDArray[np.float32]:
        """Sharpness at the pixels of a line (h, w) that have an edge."""
        values = self._sharpness[line]
        return values[values > 0]

    @cached_property
    def _sharpness(self) -> NDArray[np.float32]:
        """(h, w) how much steeper the edge near each pixel is than when smoothed; 0 for none."""
        factor = min(1.0, LARGEST / max(self.crop.shape[:2]))
        size = (round(self.crop.shape[1] * factor), round(self.crop.shape[0] * factor))
        crop = (
            cv2.resize(self.crop, size, interpolation=cv2.INTER_AREA) if factor < 1 else self.crop
        )
        lab = cv2.cvtColor(np.ascontiguousarray(crop), cv2.COLOR_RGB2LAB).astype(np.float32)
        fine, coarse = (_steepest(lab, spread) for spread in (FINE, COARSE))
        ratio = np.where(coarse > VISIBLE, fine / np.maximum(coarse, VISIBLE), 0)
        small = (self.mask.shape[1], self.mask.shape[0])
        found = cv2.resize(ratio.astype(np.float32), small, interpolation=cv2.INTER_NEAREST)
        return np.asarray(found, np.float32)


def _steepest(lab: NDArray[np.float32], spread: float) -> NDArray[np.float32]:
    """(H, W) the steepest slope of colour near each pixel, of a picture smoothed that much."""
    soft = cv2.GaussianBlur(lab, (0, 0), spread)
    across, down = (cv2.Sobel(soft, cv2.CV_32F, x, 1 - x, ksize=3) / 8 for x in (1, 0))
    slope = np.sqrt((across * across + down * down).sum(axis=2))
    return np.asarray(cv2.dilate(slope, np.ones((NEAR, NEAR), np.uint8)), np.float32)
