"""Where a thing is told to go and where its own front points, as arrows in the photo."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.aloft import in_air
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.studio.scene.arrows import vector_of
from physagent_studio.workbench import Snapshot
from physagent_studio.workbench.aloft_edits import foot_of

LONG = 0.3
"""Length of an arrow, as a part of the distance from the camera."""


def ways_of(item: SceneObject, snapshot: Snapshot) -> dict[str, Any] | None:
    """Pixels of a thing and of the tips of its arrows; None where the camera does not see it."""
    camera, place = snapshot.program.scene.camera, item.position
    if camera is None or place is None:
        return None
    middle = np.array(place)
    reach = LONG * float(np.linalg.norm(middle - np.array(camera.position)))

    def pixel(point: NDArray[np.float64]) -> list[float] | None:
        pixels, depth = camera.project(point[None])
        return [round(float(part), 1) for part in pixels[0]] if depth[0] > 0 else None

    at = pixel(middle)
    if at is None:
        return None
    foot = foot_of(snapshot.program.scene, item) if in_air(item) else None
    goes, heading = _driven(item, snapshot), item.wheels.heading if item.wheels else None
    front = None if heading is None else _level(math.radians(heading))
    return {
        "at": at,
        "goes": None if goes is None else pixel(middle + reach * goes),
        "ground": None if foot is None else pixel(foot[0]),
        "front": None if front is None else pixel(middle + reach * front),
    }


def _driven(item: SceneObject, snapshot: Snapshot) -> NDArray[np.float64] | None:
    """The level direction of what first drives a thing; None where nothing does."""
    for action in snapshot.program.event.actions:
        value = getattr(action, "force", None) or getattr(action, "velocity", None)
        if action.name != item.name or value is None or action.muted:
            continue
        way = vector_of(value, snapshot, np.array(item.position, float), np.zeros(3), 1.0)
        flat = 0.0 if way is None else math.hypot(way[0], way[1])
        if way is not None and flat > 0:
            return np.array([way[0] / flat, way[1] / flat, 0.0])
    return None


def _level(angle: float) -> NDArray[np.float64]:
    return np.array([math.cos(angle), math.sin(angle), 0.0])
