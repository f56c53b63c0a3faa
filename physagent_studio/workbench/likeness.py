"""How like the photograph a scene is drawn before anything moves: silhouettes against masks."""

from __future__ import annotations

import numpy as np

from physagent_studio.contract.view import Drawn
from physagent_studio.records import Scene
from physagent_studio.rendering import Compositor

LEAST_PIXELS = 60
"""A mask of fewer pixels tells nothing of a silhouette."""


def drawn_of(scene: Scene) -> dict[str, Drawn]:
    """Each thing that the photo shows and the scene draws; nothing without a photo, a camera
    or the looks of everything in it."""
    if scene.photo is None or scene.state.camera is None or not scene.state.objects:
        return {}
    if any(item.name not in scene.meshes or item.position is None for item in scene.state.objects):
        return {}  # Something was added by hand and is not drawn yet.
    ids = Compositor(scene, lit=False).frame(as_built=True, shadows=False).ids
    found: dict[str, Drawn] = {}
    for index, item in enumerate(scene.state.objects):
        mask = scene.masks.get(item.name)
        if mask is None or mask.shape != ids.shape or int(mask.sum()) < LEAST_PIXELS:
            continue
        drawn = ids == index
        both, either = int((mask & drawn).sum()), int((mask | drawn).sum())
        jump = float(np.hypot(*(_middle(drawn) - _middle(mask)))) if drawn.any() else np.inf
        found[item.name] = Drawn(both / max(either, 1), jump)
    return found


def _middle(mask: np.ndarray) -> np.ndarray:
    return np.argwhere(mask).mean(axis=0)
