"""Meshes from files: one GLB, OBJ, PLY or STL for each object, with an optional pose."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction.backends.frames import zup_from_yup
from physagent_studio.reconstruction.backends.mesh_files import KINDS, body_of, read_mesh
from physagent_studio.reconstruction.backends.placing import Brought, finish
from physagent_studio.reconstruction.pipeline import reconstruct
from physagent_studio.records.case import Case
from physagent_studio.records.scene import Mesh, Scene


@dataclass(frozen=True, slots=True)
class Meshes:
    """Files `NAME.glb`, `.obj`, `.ply` or `.stl` in a folder; objects without one stay embedded.

    A mesh is turned z-up (glTF is y-up), scaled to the height that the picture shows, and put
    where the embedded reconstruction finds its object.
    """

    folder: Path

    def reconstruct(
        self,
        case: Case,
        state: SceneState,
        *,
        previous: Scene | None = None,
        cancelled: Callable[[], bool] | None = None,
        progress: Callable[[str, float], None] | None = None,
    ) -> Scene:
        """The embedded scene with the files' bodies in their places."""
        first = reconstruct(case, state, previous=previous, cancelled=cancelled, progress=progress)
        bodies = {
            item.name: _fitted(path, item.name, first)
            for item in state.objects
            for path in [_file_of(self.folder, item.name)]
            if path is not None and item.name in first.meshes
        }
        return finish(case, state, bodies, first, cancelled, progress)


def _file_of(folder: Path, name: str) -> Path | None:
    paths = (folder / f"{name}{kind}" for kind in KINDS)
    return next((path for path in paths if path.is_file()), None)


def _fitted(path: Path, name: str, first: Scene) -> Brought:
    vertices, faces = read_mesh(path)
    if path.suffix.lower() == ".glb":
        vertices = zup_from_yup(vertices)
    shown = float(np.ptp(first.meshes[name].vertices[:, 2]))
    height = float(np.ptp(vertices[:, 2]))
    if height <= 0:
        raise InputError(f"the mesh of '{name}' is flat")
    mesh, _ = body_of(vertices * (shown / height), faces, name)
    return Brought(Mesh(mesh.vertices, mesh.faces), None)


def make(folder: Path | None) -> Meshes:
    """The backend on a folder of mesh files."""
    if folder is None or not folder.is_dir():
        raise InputError("the meshes backend needs a folder with a mesh file for each object")
    return Meshes(folder)
