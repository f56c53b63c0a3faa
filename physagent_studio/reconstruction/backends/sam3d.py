"""SAM 3D Objects, out of process: a job folder out, its meshes and poses in."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction.backends.frames import camera_from_sam3d, world_from_camera
from physagent_studio.reconstruction.backends.jobs import inside, numbers, read_result, write_job
from physagent_studio.reconstruction.backends.mesh_files import body_of, read_mesh
from physagent_studio.reconstruction.backends.placing import Brought, finish, on_the_ground
from physagent_studio.reconstruction.pipeline import reconstruct
from physagent_studio.records.case import Case
from physagent_studio.records.scene import Scene


@dataclass(frozen=True, slots=True)
class Sam3d:
    """Reads `folder/result`; where there is none, writes the job and says how to run it."""

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
        """Masks, camera and supports as embedded; shapes and places from the result."""
        first = reconstruct(case, state, previous=previous, cancelled=cancelled, progress=progress)
        camera = first.state.camera
        assert case.image is not None
        assert camera is not None
        groundings = [(item.name, item.grounding) for item in state.objects]
        if not (self.folder / "result").is_dir():
            write_job(self.folder, "sam3d", case.image, groundings, first.masks, camera.intrinsics)
        bodies = import_bodies(self.folder, camera)
        unknown = set(bodies) - {name for name, _ in groundings}
        if unknown:
            raise InputError(f"the result has objects that the case has not: {sorted(unknown)}")
        return finish(case, state, bodies, first, cancelled, progress)


def import_bodies(folder: Path, camera: Camera) -> Mapping[str, Brought]:
    """Bodies of a result folder in our world, scaled so that the lowest stands on the ground."""
    seen: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for entry in read_result(folder, "sam3d"):
        name = str(entry.get("name"))
        vertices, faces = read_mesh(inside(folder, entry.get("mesh")))
        rotation = numbers(entry, "rotation", 4)
        if np.linalg.norm(rotation) < 1e-6:
            raise InputError(f"the rotation of '{name}' is zero")
        points = camera_from_sam3d(
            vertices, rotation, numbers(entry, "translation", 3), numbers(entry, "scale", 3)
        )
        seen[name] = (world_from_camera(points, camera), faces)
    factor = on_the_ground({name: vertices for name, (vertices, _) in seen.items()}, camera)
    eye = np.asarray(camera.position)
    out: dict[str, Brought] = {}
    for name, (vertices, faces) in seen.items():
        mesh, centre = body_of(eye + (vertices - eye) * factor, faces, name)
        out[name] = Brought(mesh, (float(centre[0]), float(centre[1]), float(centre[2])))
    return out


def make(folder: Path | None) -> Sam3d:
    """The backend on a job folder."""
    if folder is None:
        raise InputError("sam3d needs a folder for its job and result")
    return Sam3d(folder)
