"""Decoders of pictures as tasks: bytes in, pixels out; imports little, for a new process waits."""

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

REDUCED = {1: cv2.IMREAD_COLOR_RGB, 2: cv2.IMREAD_REDUCED_COLOR_2, 4: cv2.IMREAD_REDUCED_COLOR_4}
"""How a JPEG picture is decoded at its size, half or a quarter of it."""


def decoded(data: bytes, alpha: bool, factor: int) -> Pixels | None:
    """(H, W, 3) uint8 RGB of a picture's bytes, at a whole part of its size; None if damaged.

    Trusts the bytes with time and memory, so it is for a limited process. Raises MemoryError.
    """
    raw = np.frombuffer(data, np.uint8)
    try:
        if alpha:
            return _on_white(cv2.imdecode(raw, cv2.IMREAD_UNCHANGED))
        pixels = cv2.imdecode(raw, REDUCED[factor])
        if pixels is not None and factor > 1:
            pixels = cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB)
        return None if pixels is None else pixels.astype(np.uint8, copy=False)
    except cv2.error as error:
        if error.code == cv2.Error.StsNoMem:
            raise MemoryError from error
        return None


def _on_white(pixels: np.ndarray | None) -> Pixels | None:
    """BGRA of 8 or 16 bits laid on white."""
    if pixels is None:
        return None
    if pixels.dtype == np.uint16:
        pixels = (pixels // 257).astype(np.uint8)
    if pixels.ndim == 2:
        return cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB).astype(np.uint8)
    if pixels.shape[2] == 3:
        return cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB).astype(np.uint8)
    alpha = pixels[..., 3]
    rgb = cv2.cvtColor(pixels, cv2.COLOR_BGRA2RGB).astype(np.uint8)
    if alpha.min() == 255:
        return rgb
    for start in range(0, len(rgb), 256):
        rows = slice(start, start + 256)
        share = alpha[rows, :, None].astype(np.uint16)
        mixed = rgb[rows] * share + 255 * (255 - share)
        rgb[rows] = ((mixed + 127) // 255).astype(np.uint8)
    return rgb
