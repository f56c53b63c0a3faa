"""Landmarks: places clicked, or shown by the picture, lifted into the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import Landmark, Support
from physagent_studio.reconstruction.ellipses import Ellipse
from physagent_studio.reconstruction.frames import Frame
from physagent_studio.reconstruction.geometry import on_plane, on_upright_through
from physagent_studio.reconstruction.names import words_of

OPENINGS = frozenset(
    ["goal", "gate", "hoop", "door", "doorway", "net", "opening", "frame", "window"]
)
TARGETS = frozenset(
    ["target", "circle", "house", "ring", "bullseye", "rings", "centre", "center", "disc"]
)


@dataclass(frozen=True, slots=True)
class Shown:
    """What the picture shows by itself: an upright frame, and level circles, largest first."""

    frame: Frame | None = None
    circles: tuple[Ellipse, ...] = ()


def resolve(
    landmarks: Sequence[Landmark], camera: Camera, supports: Sequence[Support], shown: Shown
) -> tuple[tuple[Landmark, ...], tuple[str, ...]]:
    """Landmarks with points where they were clicked or are seen, and words about open ones."""
    out: list[Landmark] = []
    flags: list[str] = []
    for landmark in landmarks:
        points = landmark.points
        if points is None and landmark.pixels:
            points = _lifted(landmark, camera, supports)
        elif points is None:
            landmark = _proposed(landmark, camera, shown)
            points = landmark.points
        if points is None:
            flags.append(f"landmark '{landmark.name}' is open: click it in the photo")
        out.append(landmark.model_copy(update={"points": points}))
    return tuple(out), tuple(flags)


def _proposed(landmark: Landmark, camera: Camera, shown: Shown) -> Landmark:
    """A landmark that nobody clicked, where its name and the picture agree."""
    words = set(words_of(landmark.name))
    frame = shown.frame if words & OPENINGS else None
    update: dict[str, object] = {}
    if frame is not None and landmark.kind == "opening":
        update = {"pixels": frame.corners, "points": _opening(np.array(frame.corners), camera)}
    elif frame is not None:
        feet = frame.corners[:2]
        places = on_plane(camera, feet, 0.0)
        if np.isfinite(places).all():
            points = _triples(places if landmark.kind != "point" else places.mean(0)[None])
            update = {"pixels": feet, "points": points}
    elif words & TARGETS and shown.circles:
        update = _circle(landmark, camera, shown.circles[0])
    if update.get("points") is None:
        return landmark
    return landmark.model_copy(update={**update, "source": "estimated"})


def _circle(landmark: Landmark, camera: Camera, seen: Ellipse) -> dict[str, object]:
    """The circle on the floor whose picture an ellipse is: its centre, or its outline."""
    turn = np.linspace(0, 2 * np.pi, 17)[:-1]
    rim = np.stack(
        [seen.x + seen.width / 2 * np.cos(turn), seen.y + seen.height / 2 * np.sin(turn)], 1
    )
    places = on_plane(camera, rim, 0.0)
    if not np.isfinite(places).all():
        return {}
    middle = np.append((places[:, :2].min(0) + places[:, :2].max(0)) / 2, 0.0)
    if landmark.kind in ("area", "opening"):
        pixels = tuple((float(x), float(y)) for x, y in rim)
        return {"pixels": pixels, "points": _triples(places)}
    pixel = camera.project(middle[None])[0][0]
    return {"pixels": ((float(pixel[0]), float(pixel[1])),), "points": _triples(middle[None])}


def _triples(places: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in places)


def _lifted(
    landmark: Landmark, camera: Camera, supports: Sequence[Support]
) -> tuple[tuple[float, float, float], ...] | None:
    pixels = np.array(landmark.pixels, float)
    if landmark.kind == "opening":
        return _opening(pixels, camera)
    places = on_plane(camera, pixels, top_of(landmark.on, supports))
    if not np.isfinite(places).all():
        return None
    return _triples(places)


def _opening(pixels: np.ndarray, camera: Camera) -> tuple[tuple[float, float, float], ...] | None:
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
