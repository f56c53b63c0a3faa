"""Colours of things: photo textures or flat ones, without light, and the photo's light on them."""

import math
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.rotations import matrix_of
from physagent_studio.records.scene import Mesh, Shading
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.raster import FloatArray

DARK = 16.0
"""Added to colours before they are multiplied by light, grey levels: haze and noise in what is dark
are not multiplied with it."""
LOWEST, HIGHEST, HUES = 0.35, 1.8, 0.8
"""Least and most light, and how far its hue strays from white, log."""
FARTHEST = math.radians(80.0)
"""Angle from the camera beyond which light is that of there: the photo tells no more."""


def terms_of(normals: FloatArray) -> FloatArray:
    """(N, 16) of which the log of light is a sum, at unit normals (N, 3); see `Shading`.

    The real spherical harmonics up to the third degree, but for their factors.
    """
    x, y, z = normals.T
    up, apart = 5 * z * z - 1, x * x - y * y
    first = [np.ones_like(x), x, y, z]
    second = [x * y, y * z, z * x, apart, 3 * z * z - 1]
    third = [z * (up - 2), x * up, y * up, z * apart, x * y * z]
    third += [x * (x * x - 3 * y * y), y * (3 * x * x - y * y)]
    return np.stack([*first, *second, *third], 1)


def told(normals: FloatArray, towards: FloatArray) -> FloatArray:
    """Unit normals (N, 3), those that face away from the camera tilted to where light is known."""
    facing = normals @ towards
    beside = normals - facing[:, None] * towards
    beside /= np.maximum(np.linalg.norm(beside, axis=1, keepdims=True), 1e-9)
    edge = math.sin(FARTHEST) * beside + math.cos(FARTHEST) * towards
    return np.where((facing < math.cos(FARTHEST))[:, None], edge, normals)


def light_at(shading: Shading, normals: FloatArray) -> FloatArray:
    """Brightness (N, 3) RGB at unit normals (N, 3), world."""
    known = told(normals, np.asarray(shading.towards, float))
    log = terms_of(known) @ np.asarray(shading.terms, float).T
    tone = log.mean(1, keepdims=True)
    hue = np.clip(log - tone, -HUES, HUES)
    light = np.exp(np.clip(tone, math.log(LOWEST), math.log(HIGHEST)) + hue)
    if shading.shade is None:
        return light
    left = _by_normal(shading.shade, shading.towards, known)
    return light * (left if left.ndim == 2 else left[:, None])


def gloss_at(shading: Shading, normals: FloatArray) -> FloatArray:
    """The share of white (N,) that gloss adds at unit normals (N, 3), world, 0 … 1."""
    if shading.gloss is None:
        return np.zeros(len(normals))
    added = _by_normal(shading.gloss, shading.towards, normals)
    return np.where(normals @ np.asarray(shading.towards, float) > 0, added, 0.0)


def _by_normal(
    picture: NDArray[np.uint8], towards: tuple[float, float, float], normals: FloatArray
) -> FloatArray:
    """What a picture (K, K[, C]) by the normal has (N[, C]), 0 … 1, at unit normals (N, 3)."""
    flat = normals @ gloss_frame(np.asarray(towards, float)).T
    where = (flat * (1, -1) + 1) / 2 * len(picture) - 0.5
    return bilinear(picture, where).astype(np.float64) / 255


def gloss_frame(towards: FloatArray) -> FloatArray:
    """(2, 3) unit vectors, right and up as seen from `towards` (3,), world."""
    beside = np.array([0.0, 0.0, 1.0]) if abs(towards[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
    right = np.cross(beside, towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right)])


def lit(shading: Shading, colours: NDArray, normals: FloatArray) -> FloatArray:
    """Colours (N, 3) in that light, at unit normals (N, 3), world; 0 … 255."""
    bright = np.clip((colours + DARK) * light_at(shading, normals) - DARK, 0, 255)
    return bright + gloss_at(shading, normals)[:, None] * (255 - bright)


def vertex_light(mesh: Mesh) -> FloatArray | None:
    """(V, 3) the photo's light on a mesh as it stood there; None where its texture carries it."""
    if mesh.shading is None:
        return None
    batch = Batch.of([mesh])
    total = np.zeros((len(mesh.vertices), 3))
    np.add.at(total, batch.faces.ravel(), batch.normals.reshape(-1, 3))
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)
    return light_at(mesh.shading, total @ matrix_of(mesh.shading.built).T)


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
    if not count:
        return np.zeros((0, *image.shape[2:]), np.float32)
    rows = -(-count // _STRIP)
    grid = np.zeros((rows * _STRIP, 2), np.float32)
    grid[:count] = where
    across, down = (np.ascontiguousarray(grid[:, i]).reshape(rows, _STRIP) for i in (0, 1))
    picked = cv2.remap(image, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(picked).reshape(-1, *image.shape[2:])[:count].astype(np.float32)
