"""The outline of a mask as the page draws it; imports little, for a new process waits."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

LEAST_AREA = 6
"""Rings of an outline that enclose fewer pixels are left out."""


def path_of(mask: NDArray[np.bool_], accuracy: float = 0.7) -> str:
    """The outline of a mask (H, W), holes included, as an SVG path to be filled even-odd, pixels.

    A pixel (i, j) covers [i, i + 1), so a ring runs through pixel centres at i + .5.
    """
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    parts = []
    for ring in found:
        if cv2.contourArea(ring) < LEAST_AREA:
            continue
        thin = cv2.approxPolyDP(ring, accuracy, closed=True).reshape(-1, 2)
        if len(thin) >= 3:
            parts.append("M" + "L".join(f"{x + 0.5:g} {y + 0.5:g}" for x, y in thin) + "Z")
    return "".join(parts)
