"""Things whose texture is without light: the photo's light on them, however they have turned."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.rotations import matrix_of
from physagent_studio.records.scene import Mesh, Shading
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.raster import FloatArray
from physagent_studio.rendering.texture import bilinear

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
    return np.exp(np.clip(tone, math.log(LOWEST), math.log(HIGHEST)) + hue)


def gloss_at(shading: Shading, normals: FloatArray) -> FloatArray:
    """The share of white (N,) that gloss adds at unit normals (N, 3), world, 0 … 1."""
    if shading.gloss is None:
        return np.zeros(len(normals))
    towards = np.asarray(shading.towards, float)
    frame = gloss_frame(towards)
    flat = normals @ frame.T
    across = len(shading.gloss)
    where = (flat * (1, -1) + 1) / 2 * across - 0.5
    added = bilinear(shading.gloss, where).astype(np.float64) / 255
    return np.where(normals @ towards > 0, added, 0.0)


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
