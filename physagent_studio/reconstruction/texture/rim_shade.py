"""Shade at the rim of a ball that no smooth light explains: it stays where it is as the ball turns.

The ground and what stands by keep light off. In the texture that would be a dark crescent that
rolls along, so the rim is painted without it, and what the photo is darker there joins the light.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.lit import DARK, Paint, gloss_frame, lit
from physagent_studio.rendering.raster import Lens, rasterise


@dataclass(frozen=True, slots=True)
class RimSettings:
    """Where shade is read, and how finely."""

    begins_deg: float = 35.0  # 20..60: from the view, where the texture begins to differ
    sure_deg: float = 70.0  # 50..85: from the view: beyond, the surroundings shine through
    across_px: int = 48  # 16..128: of its picture, over the directions that are seen
    blur_px: float = 1.5  # 0.5..4: of that picture: detail is the ball's own
    least_share: float = 0.15  # 0.1..0.6: of brightness that is left in the darkest of it
    min_pixels: int = 300  # count, 100..2000: of the ball, below which nothing is told


RIM = RimSettings()


def with_rim_shade(
    photo: Image,
    mask: BoolArray,
    camera: Camera,
    item: SceneObject,
    mesh: Mesh,
    *,
    whole: bool = False,
) -> Mesh:
    """The mesh with shade in its light where the photo (H, W, 3) is darker than it is at its rim.

    mesh: with a texture without light, and that light. whole: it is of one colour, so that what is
    brighter or darker is light wherever it is, not at the rim alone.
    """
    shading = mesh.shading
    assert shading is not None
    assert mesh.texture is not None
    towards = np.asarray(shading.towards, float)
    pixel, normals, drawn = _drawn(camera, item, mesh)
    own = mask.ravel()[pixel]
    if np.count_nonzero(own) < RIM.min_pixels:
        return mesh
    pixel, normals, drawn = pixel[own], normals[own], drawn[own]
    seen = photo.reshape(-1, 3)[pixel].astype(np.float64)
    log = np.log(seen + DARK) - np.log(drawn + DARK)
    if whole:
        # The picture of shade only darkens: the ball is as bright as the brightest of it.
        inner = normals @ towards > math.cos(math.radians(RIM.sure_deg))
        lift = np.percentile(log[inner], 98, axis=0)
        log -= lift
        brighter = (mesh.texture.astype(np.float64) + DARK) * np.exp(lift) - DARK
        mesh = replace(mesh, texture=np.clip(brighter + 0.5, 0, 255).astype(np.uint8))
    else:
        log[normals @ towards > math.cos(math.radians(RIM.begins_deg))] = 0.0
        log = log.mean(1)
    log = _by_normal(normals, log, towards)
    shade = np.exp(np.clip(log, math.log(RIM.least_share), 0.0))
    picture = np.clip(255 * shade + 0.5, 0, 255).astype(np.uint8)
    return replace(mesh, shading=replace(shading, shade=picture))


def _drawn(
    camera: Camera, item: SceneObject, mesh: Mesh
) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """Pixels (N,) that see the mesh where it is, its unit normals (N, 3) and colours (N, 3)."""
    assert mesh.shading is not None
    assert mesh.uv is not None
    batch, turn = Batch.of([mesh]), matrix_of(item.rotation)
    world = mesh.vertices @ turn.T + np.asarray(item.position)
    points = (world - np.asarray(camera.position)) @ camera.matrix
    lens = Lens(*camera.size, camera.focal, *camera.principal)
    hits = rasterise(points, batch.faces, lens, batch.one_sided)
    normals = np.einsum("ki,kij->kj", hits.weights, batch.normals[hits.face]) @ turn.T
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    uv = np.einsum("ki,kij->kj", hits.weights, mesh.uv[mesh.faces[hits.face]])
    return hits.pixel, normals, lit(mesh.shading, Paint.of(mesh).sample(uv, 1.0), normals)


def _by_normal(normals: FloatArray, values: FloatArray, towards: FloatArray) -> FloatArray:
    """The mean (K, K[, C]) of values (N[, C]) by unit normals (N, 3), seen from `towards`.

    Smoothed; between the pixels and beyond them what is nearest.
    """
    across = RIM.across_px
    flat = normals @ gloss_frame(towards).T
    where = np.clip(((flat * (1, -1) + 1) / 2 * across).astype(int), 0, across - 1)
    total = np.zeros((across, across, *values.shape[1:]), np.float32)
    count = np.zeros((across, across, *[1] * (values.ndim - 1)), np.float32)
    np.add.at(total, (where[:, 1], where[:, 0]), values)
    np.add.at(count, (where[:, 1], where[:, 0]), 1)
    out = np.zeros_like(total)
    for blur in (16.0, 8.0, 4.0, 2.0, RIM.blur_px):
        near, some = (
            cv2.GaussianBlur(part, (0, 0), blur).reshape(part.shape) for part in (total, count)
        )
        out = np.where(some > 0.05, near / np.maximum(some, 1e-6), out)
    return np.asarray(out, np.float64)
