"""Meshes that came from elsewhere become objects of a scene."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Meshed, SceneObject, SceneState
from physagent_studio.reconstruction.pipeline import reconstruct
from physagent_studio.records.case import Case
from physagent_studio.records.scene import Mesh, Scene


@dataclass(frozen=True, eq=False, slots=True)
class Brought:
    """A body from elsewhere: its mesh (body frame, world axes), its place or None for open."""

    mesh: Mesh
    position: tuple[float, float, float] | None


def asset_hash(mesh: Mesh) -> str:
    """Content hash of a mesh's geometry."""
    digest = hashlib.sha256(np.ascontiguousarray(mesh.vertices).tobytes())
    digest.update(np.ascontiguousarray(mesh.faces).tobytes())
    return digest.hexdigest()


def with_bodies(state: SceneState, bodies: Mapping[str, Brought]) -> SceneState:
    """The state with the open shapes of the named objects filled by their meshes."""
    objects = tuple(
        _with_body(item, bodies[item.name]) if item.name in bodies and item.shape is None else item
        for item in state.objects
    )
    return state.model_copy(update={"objects": objects})


def _with_body(item: SceneObject, body: Brought) -> SceneObject:
    x, y, z = (float(v) for v in np.maximum(np.ptp(body.mesh.vertices, axis=0), 1e-6))
    update: dict[str, object] = {"shape": Meshed(asset=asset_hash(body.mesh), size=(x, y, z))}
    if item.position is None and body.position is not None:
        update["position"] = body.position
    return item.model_copy(update=update)


def on_the_ground(bodies: Mapping[str, FloatArray], camera: Camera) -> float:
    """The factor about the camera that brings the lowest of world bodies (V, 3) to z = 0.

    A single picture leaves the size open: everything may be nearer and smaller.
    """
    eye = camera.position[2]
    drops = [eye - float(vertices[:, 2].min()) for vertices in bodies.values()]
    lowest = max(drops, default=eye)
    return eye / lowest if lowest > 1e-6 else 1.0


def finish(
    case: Case,
    state: SceneState,
    bodies: Mapping[str, Brought],
    first: Scene,
    cancelled: Callable[[], bool] | None,
    progress: Callable[[str, float], None] | None,
) -> Scene:
    """The scene of a state whose objects are these bodies: checks, textures and plate as ever.

    first: without them; its supports and camera stay.
    """
    known = first.state.model_copy(update={"objects": state.objects})
    return reconstruct(
        case,
        with_bodies(known, bodies),
        previous=first,
        cancelled=cancelled,
        progress=progress,
        bodies={name: body.mesh for name, body in bodies.items()},
    )
