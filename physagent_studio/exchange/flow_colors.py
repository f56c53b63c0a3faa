"""Flow as a picture for eyes: the direction is the hue, the speed the saturation."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def flow_picture(
    vectors: NDArray[np.float32], fastest: float, moving: NDArray[np.int64]
) -> NDArray[np.uint8]:
    """(H, W, 3) uint8 RGB of vectors (H, W, 2), pixels; white stands still.

    fastest: length in pixels that is shown in full colour. moving: see `moving_pixels`.
    """
    height, width = vectors.shape[:2]
    picture = np.full((height * width, 3), 255, np.uint8)
    if len(moving):
        x, y = vectors.reshape(-1, 2).take(moving, 0).T
        length, angle = cv2.cartToPolar(x, y)
        # The square root keeps slow motion visible beside fast.
        share = np.clip(np.sqrt(length / max(fastest, 1e-6)), 0, 1)
        hue = (angle * (90 / np.pi)).astype(np.int64) % 180
        hsv = np.column_stack([hue, 255 * share, 255 - np.floor(55 * share)]).astype(np.uint8)
        picture[moving] = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2RGB)[0]
    return picture.reshape(height, width, 3)


def moving_pixels(vectors: NDArray[np.float32]) -> NDArray[np.int64]:
    """(K,) rows of vectors (H, W, 2) that are not zero; both numbers are looked at as one."""
    return np.flatnonzero(np.ascontiguousarray(vectors).view(np.int64))
