"""The picture behind the objects where there is no photo: sky, a floor with a grid, supports."""

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Floor, SceneState, Wall
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.light import LIGHT, lambert
from physagent_studio.rendering.raster import FloatArray, Lens
from physagent_studio.rendering.stage import pixel_rays, struck

PALETTE: tuple[tuple[int, int, int], ...] = (
    (226, 98, 72),
    (66, 135, 198),
    (240, 178, 62),
    (94, 168, 108),
    (158, 108, 186),
    (72, 176, 180),
    (214, 120, 160),
    (140, 118, 96),
)
"""Flat colours of objects without a picture; they repeat after eight."""

_SKY_TOP, _SKY_LOW = np.array([206.0, 218, 230]), np.array([242.0, 244, 246])
_FLOOR, _LINE = np.array([226.0, 225, 221]), np.array([186.0, 187, 188])
_SUPPORT = np.array([196.0, 184, 168])
_SAMPLES = 2


def draw_backdrop(
    state: SceneState, meshes: Mapping[str, Mesh], camera: Camera, lens: Lens
) -> Picture:
    """A neutral place, (H, W, 3) uint8, drawn once and with smooth edges."""
    k = _SAMPLES
    fine = Lens(k * lens.width, k * lens.height, k * lens.focal, k * lens.cx, k * lens.cy)
    rays = pixel_rays(camera, fine)
    origin = np.array(camera.position, float)
    canvas, depth = _sky(rays), np.full(len(rays), np.inf)
    for support in state.supports:
        if isinstance(support.shape, Floor):
            _floor(canvas, depth, rays, origin, support.shape.height, _spacing(state))
    shapes = {support.name: support.shape for support in state.supports}
    solid = [m for name, m in meshes.items() if not isinstance(shapes.get(name), Floor | Wall)]
    _solids(canvas, depth, solid, camera, fine)
    picture = np.clip(canvas, 0, 255).astype(np.uint8).reshape(fine.height, fine.width, 3)
    small = cv2.resize(picture, (lens.width, lens.height), interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.uint8)


def _sky(rays: FloatArray) -> FloatArray:
    up = rays[:, 2] / np.linalg.norm(rays, axis=1)
    share = np.clip(up * 1.6, 0, 1)[:, None]
    return _SKY_LOW * (1 - share) + _SKY_TOP * share


def _spacing(state: SceneState) -> float:
    """Metres between grid lines: 1, 2 or 5 times a power of ten, finer for small scenes."""
    places = [o.position for o in state.objects if o.position is not None]
    size = float(np.ptp(np.array(places), axis=0).max()) if len(places) > 1 else 0.0
    height = state.camera.position[2] if state.camera else 1.0
    wanted = max(size, height, 1e-3) / 3
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * next(step for step in (1, 2, 5, 10) if step * power >= wanted))


def _floor(
    canvas: FloatArray,
    depth: FloatArray,
    rays: FloatArray,
    origin: FloatArray,
    height: float,
    spacing: float,
) -> None:
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (height - origin[2]) / rays[:, 2]
    seen = np.flatnonzero((distance > 0) & (distance < depth) & np.isfinite(distance))
    points = origin[:2] + rays[seen, :2] * distance[seen, None]
    # A line is about one pixel wide wherever it lies: its width grows with the distance.
    pixel = distance[seen] * np.linalg.norm(rays[seen], axis=1) / 900
    line = np.zeros(len(seen))
    for axis in (0, 1):
        off = np.abs(np.mod(points[:, axis] / spacing + 0.5, 1) - 0.5) * spacing
        line = np.maximum(line, np.clip(1.4 - off / pixel, 0, 1))
    line *= np.exp(-distance[seen] / (14 * spacing))
    haze = (1 - np.exp(-distance[seen] / (40 * spacing)))[:, None]
    tone = _FLOOR * (1 - line[:, None]) + _LINE * line[:, None]
    canvas[seen] = tone * (1 - haze) + _SKY_LOW * haze
    depth[seen] = distance[seen]


def _solids(
    canvas: FloatArray, depth: FloatArray, meshes: list[Mesh], camera: Camera, lens: Lens
) -> None:
    hits, normals, _ = struck(meshes, camera, lens)
    near = hits.depth < depth[hits.pixel] * (1 + 1e-6)
    shade: NDArray[np.float64] = lambert(normals[near] @ LIGHT, 0.45)[:, None]
    canvas[hits.pixel[near]] = _SUPPORT * np.minimum(shade * 1.15, 1.1)
