"""Colours of the pixels of objects: their photo texture, or a flat colour that light shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.raster import FloatArray

_STRIP = 4096
"""cv2.remap takes no picture wider than 32767 pixels, so samples are laid out in rows."""
_LEVELS = 4


@dataclass(frozen=True, eq=False, slots=True)
class Paint:
    """The colours of one object; `levels` are its texture, halved again and again, or empty."""

    levels: tuple[Picture, ...]
    color: tuple[int, int, int]

    @classmethod
    def of(cls, mesh: Mesh) -> Self:
        """The paint of a mesh; its colour where it has no texture or no uv."""
        if mesh.texture is None or mesh.uv is None:
            return cls((), mesh.color)
        levels = [np.ascontiguousarray(mesh.texture[..., :3])]
        while len(levels) < _LEVELS and min(levels[-1].shape[:2]) > 16:
            levels.append(np.asarray(cv2.pyrDown(levels[-1]), np.uint8))
        return cls(tuple(levels), mesh.color)

    def sample(self, uv: FloatArray, shrink: float) -> NDArray[np.float32]:
        """Colours (K, 3) at texture pixels (K, 2); `shrink`: texture pixels per screen pixel."""
        if not self.levels:
            return np.full((len(uv), 3), self.color, np.float32)
        level = int(np.clip(np.round(np.log2(max(shrink, 1e-6))), 0, len(self.levels) - 1))
        # Texture pixel i covers [i, i + 1), so its centre is sampled at i + .5.
        return bilinear(self.levels[level], uv / 2**level - 0.5)


def bilinear(image: NDArray, where: FloatArray) -> NDArray[np.float32]:
    """Values of an image (h, w[, C]) at sample positions (K, 2), its border continued."""
    count = len(where)
    rows = -(-count // _STRIP)
    grid = np.zeros((rows * _STRIP, 2), np.float32)
    grid[:count] = where
    across, down = (np.ascontiguousarray(grid[:, i]).reshape(rows, _STRIP) for i in (0, 1))
    picked = cv2.remap(image, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(picked).reshape(-1, *image.shape[2:])[:count].astype(np.float32)
