"""`Reconstructor`: what every backend is, and the known ones by name."""

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from physagent_studio.errors import InputError
from physagent_studio.program.scene.state import SceneState
from physagent_studio.records.case import Case
from physagent_studio.records.scene import Scene

BACKENDS = {
    "embedded": "physagent_studio.reconstruction.backends.embedded",
    "sam3d": "physagent_studio.reconstruction.backends.sam3d",
    "meshes": "physagent_studio.reconstruction.backends.meshes",
}


class Reconstructor(Protocol):
    """Turns a picture and a state with open fields into a scene with none."""

    def reconstruct(
        self,
        case: Case,
        state: SceneState,
        *,
        previous: Scene | None = None,
        cancelled: Callable[[], bool] | None = None,
        progress: Callable[[str, float], None] | None = None,
    ) -> Scene: ...


def backend(name: str, folder: Path | None = None) -> Reconstructor:
    """The backend of that name; `folder` is its job folder, or the folder of meshes.

    Raises InputError for an unknown name.
    """
    if name not in BACKENDS:
        known = ", ".join(BACKENDS)
        raise InputError(f"there is no reconstruction backend '{name}'; known: {known}")
    return importlib.import_module(BACKENDS[name]).make(folder)
