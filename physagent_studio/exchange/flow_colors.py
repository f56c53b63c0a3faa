"""Flow as a picture for eyes: the direction is the hue, the speed the saturation."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def flow_picture(vectors: NDArray[np.float32], fastest: float) -> NDArray[np.uint8]:
    """(H, W, 3) uint8 RGB of vectors (H, W, 2), pixels; white stands still.

    fastest: length in pixels that is shown in full colour.
    """
    length, angle = cv2.cartToPolar(vectors[..., 0], vectors[..., 1])
    hsv = np.empty((*length.shape, 3), np.uint8)
    hsv[..., 0] = (angle * (90 / np.pi)).astype(np.int64) % 180
    # The square root keeps slow motion visible beside fast.
    share = np.clip(np.sqrt(length / max(fastest, 1e-6)), 0, 1)
    hsv[..., 1] = (255 * share).astype(np.uint8)
    hsv[..., 2] = 255 - (55 * share).astype(np.uint8)
    return np.asarray(cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB), np.uint8)
