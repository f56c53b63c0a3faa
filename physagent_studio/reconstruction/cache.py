"""What a reconstruction depends on: when two states show the same, and the hash of all of it."""

import hashlib

from physagent_studio.program.scene.state import SceneState
from physagent_studio.records.case import Case

VERSION = "72"
"""Changes whenever the same input gives another scene."""

_UNSEEN = (
    "material",
    "density",
    "friction",
    "restitution",
    "rolling",
    "wheels",
    "aloft",
    "tether",
    "body",
)
"""Fields of objects and supports that no picture shows: changing them changes no geometry."""


def same_sight(before: SceneState, after: SceneState) -> bool:
    """Whether a completed state differs only in what a picture does not show, or in landmarks
    that have their points already."""
    placed = all(mark.points is not None or not mark.pixels for mark in after.landmarks)
    return placed and after.is_resolved and _sight(before) == _sight(after)


def _sight(state: SceneState) -> dict[str, object]:
    data = state.model_dump(exclude={"landmarks", "flags"})
    for item in (*data["objects"], *data["supports"]):
        for field in _UNSEEN:
            item.pop(field, None)
    return data


def scene_hash(case: Case, state: SceneState, models: str = "") -> str:
    """SHA-256 of everything that a reconstruction depends on. models: `Learned.key`."""
    parts = [VERSION, case.image_hash, case.prompt, state.model_dump_json(exclude=state.without)]
    if case.focal is not None:
        parts.append(f"{case.focal:.3f}")
    if models:
        parts.append(models)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
