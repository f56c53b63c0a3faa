"""Between a picture and a coarse grid over it, whose cells are `step` by `step` pixels."""

import cv2
import numpy as np
from numpy.typing import NDArray


def reduced(picture: NDArray, step: int, shape: tuple[int, int]) -> NDArray[np.float32]:
    """Mean of a picture (H, W[, C]) over each cell of a grid (h, w), the border repeated."""
    down, across = shape[0] * step - picture.shape[0], shape[1] * step - picture.shape[1]
    whole = cv2.copyMakeBorder(picture, 0, down, 0, across, cv2.BORDER_REPLICATE)
    small = cv2.resize(whole, shape[::-1], interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32)


def enlarged(coarse: NDArray, step: int, shape: tuple[int, ...]) -> NDArray:
    """A grid (h, w[, C]) at the size (H, W) of the picture, between cell middles linear."""
    large = cv2.resize(coarse, None, fx=step, fy=step, interpolation=cv2.INTER_LINEAR)
    return large[: shape[0], : shape[1]]
