"""LaMa (Suvorov et al., WACV 2022, arXiv 2109.07161): holes filled at the photo's own resolution.

Inputs and outputs are those of the zoo's own runner (models/inpainting_lama), which hands the
picture over in blue, green, red. The network sees 512 pixels at a time: windows of that side are
laid around the parts of a hole, from those of which most of the surroundings is known inwards.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray
from physagent_studio.errors import Cancelled
from physagent_studio.reconstruction.learned.network import Network
from physagent_studio.records.case import Image

NAME = "lama"


@dataclass(frozen=True, slots=True)
class LamaSettings:
    """What the network sees at once."""

    window_px: int = 512  # 512..512: side of its input
    cell_px: int = 256  # 128..384: filled at once, a quarter of the window around it known
    same_hole_px: int = 9  # 1..31: parts of a hole so near are filled together


LAMA = LamaSettings()


Window = tuple[slice, slice]


def inpainted(
    network: Network, photo: Image, hole: BoolArray, cancelled: Callable[[], bool]
) -> Image:
    """The photo (H, W, 3) with the hole (H, W) filled; the rest is untouched.

    Raises ModelFailed where the network gives nothing of use, Cancelled when `cancelled` says so.
    """
    out, missing = photo.copy(), hole.copy()
    left = _cells(hole)
    while left:
        if cancelled():
            raise Cancelled("the filling of the background was cancelled")
        known = [np.count_nonzero(~missing[_around(cell, hole.shape)]) for cell, _ in left]
        cell, own = left.pop(int(np.argmax(known)))
        window = _around(cell, hole.shape)
        seen = _filled(network, out[window], missing[window])
        out[window][own[window]] = seen[own[window]]
        missing &= ~own
    return out


def _cells(hole: BoolArray) -> list[tuple[Window, BoolArray]]:
    """The parts of a hole: what bounds each, and its pixels (H, W)."""
    near = cv2.dilate(
        hole.astype(np.uint8), np.ones((LAMA.same_hole_px, LAMA.same_hole_px), np.uint8)
    )
    count, labels = cv2.connectedComponents(near)
    out: list[tuple[Window, BoolArray]] = []
    for label in range(1, count):
        piece = hole & (labels == label)
        rows, columns = np.flatnonzero(piece.any(axis=1)), np.flatnonzero(piece.any(axis=0))
        for across in _split(int(rows[0]), int(rows[-1]) + 1):
            for along in _split(int(columns[0]), int(columns[-1]) + 1):
                own = np.zeros_like(hole)
                own[across, along] = piece[across, along]
                if own.any():
                    out.append(((across, along), own))
    return out


def _split(start: int, end: int) -> list[slice]:
    """A span in as few equal parts as are no longer than a cell."""
    edges = np.linspace(start, end, math.ceil((end - start) / LAMA.cell_px) + 1).round().astype(int)
    return [slice(a, b) for a, b in pairwise(edges.tolist())]


def _around(cell: Window, shape: tuple[int, ...]) -> Window:
    """The window with a cell in its middle, as far as the picture goes."""
    spans = []
    for part, size in zip(cell, shape, strict=True):
        start = min(
            max((part.start + part.stop - LAMA.window_px) // 2, 0), max(size - LAMA.window_px, 0)
        )
        spans.append(slice(start, min(start + LAMA.window_px, size)))
    return spans[0], spans[1]


def _filled(network: Network, part: Image, missing: BoolArray) -> Image:
    """A window of at most 512 pixels a side, its mirror image beyond the picture's edge."""
    height, width = missing.shape
    beyond = (0, LAMA.window_px - height, 0, LAMA.window_px - width, cv2.BORDER_REFLECT)
    square = cv2.copyMakeBorder(part, *beyond)
    hole = cv2.copyMakeBorder(missing.astype(np.uint8), *beyond)
    (found,) = network.run(
        {
            "image": cv2.dnn.blobFromImage(square, 1 / 255, swapRB=True),
            "mask": hole.astype(np.float32)[None, None],
        },
        {"": (1, 3, LAMA.window_px, LAMA.window_px)},
    )
    pixels = np.clip(np.round(found[0, ::-1]), 0, 255).astype(np.uint8)
    return pixels.transpose(1, 2, 0)[:height, :width]
