"""Landmarks: clicked places lifted into the world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import Landmark, Support
from physagent_studio.reconstruction.geometry import on_plane, on_upright_through


def resolve(
    landmarks: Sequence[Landmark], camera: Camera, supports: Sequence[Support]
) -> tuple[tuple[Landmark, ...], tuple[str, ...]]:
    """Landmarks with world points where they were clicked, and sentences about open ones."""
    out: list[Landmark] = []
    flags: list[str] = []
    for landmark in landmarks:
        points = landmark.points
        if points is None and landmark.pixels:
            points = _lifted(landmark, camera, supports)
        if points is None:
            flags.append(f"landmark '{landmark.name}' is open: click it in the photo")
        out.append(landmark.model_copy(update={"points": points}))
    return tuple(out), tuple(flags)


def _lifted(
    landmark: Landmark, camera: Camera, supports: Sequence[Support]
) -> tuple[tuple[float, float, float], ...] | None:
    pixels = np.array(landmark.pixels, float)
    if landmark.kind == "opening":
        return _opening(pixels, camera)
    places = on_plane(camera, pixels, top_of(landmark.on, supports))
    if not np.isfinite(places).all():
        return None
    return tuple((float(x), float(y), float(z)) for x, y, z in places)


def _opening(
    pixels: np.ndarray, camera: Camera
) -> tuple[tuple[float, float, float], ...] | None:
    """An upright opening: its lowest two pixels are on the floor and fix its plane."""
    low = np.argsort(-pixels[:, 1], kind="stable")[:2]
    feet = on_plane(camera, pixels[low], 0.0)
    if not np.isfinite(feet).all():
        return None
    along = feet[1] - feet[0] if len(feet) > 1 else np.array([1.0, 0, 0])
    normal = np.cross(along, (0.0, 0.0, 1.0))
    normal = normal / max(float(np.linalg.norm(normal)), 1e-9)
    places = on_upright_through(camera, pixels, feet[0], normal)
    if not np.isfinite(places).all():
        return None
    return tuple((float(x), float(y), max(float(z), 0.0)) for x, y, z in places)


def top_of(name: str | None, supports: Sequence[Support]) -> float:
    """Height of a support's level top, m; the floor's for an unknown name."""
    for support in supports:
        if support.name == name and support.shape is not None:
            if support.shape.kind == "box":
                return support.shape.position[2] + support.shape.size[2] / 2
            if support.shape.kind == "floor":
                return support.shape.height
    return 0.0
