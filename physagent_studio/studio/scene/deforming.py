"""Deformables, cloth and grains, drawn as they move: their meshes' vertices, frame by frame.

viser can move the vertices of a plain mesh, not of a textured one. A textured thing is therefore
drawn as one plain mesh that puts on the texture of its hidden rigid form in the browser
(`pages/dressing.js`), or, where that script does not run, as a few plain meshes, one for each of
its main colours.
"""

from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.records import Mesh, Rollout

COLOURS, TURNS = 8, 6
"""Most colours of a thing, and rounds of sorting its faces among them."""

Picked = Callable[[str, str], None]


class Deforming:
    """Owned by the stage; called by the studio's one thread."""

    def __init__(self, server: viser.ViserServer, picked: Picked, dressed: bool) -> None:
        """dressed: the page that shows it runs `dressing.js`."""
        self._server = server
        self._dressed = dressed
        self._picked = picked
        self._rollout: Rollout | None = None
        self._frame = -1
        self._parts: dict[str, list[tuple[NDArray[np.int64], viser.MeshHandle]]] = {}
        self._paths: dict[str, FloatArray] = {}

    @property
    def names(self) -> frozenset[str]:
        """What is drawn here rather than as a rigid body."""
        return frozenset(self._paths)

    def clear(self) -> None:
        """Removes all of them."""
        self._server.scene.remove_by_name("/deforming")
        self._rollout, self._frame, self._parts, self._paths = None, -1, {}, {}

    def show(self, rollout: Rollout | None, meshes: dict[str, Mesh]) -> None:
        """Draws what deforms in a rollout; only the vertices of another rollout are new."""
        if rollout is self._rollout:
            return
        self._rollout, self._frame = rollout, -1
        paths = {} if rollout is None else dict(rollout.vertices)
        self._paths = {
            name: path
            for name, path in paths.items()
            if name in meshes and path.shape[1] == len(meshes[name].vertices)
        }
        for name in set(self._parts) - set(self._paths):
            del self._parts[name]
            self._server.scene.remove_by_name(f"/deforming/{name}")
        for name, path in self._paths.items():
            if name not in self._parts:
                self._parts[name] = self._make(name, meshes[name], path[0])

    def pose(self, step: int) -> None:
        """Brings the vertices to a control step."""
        if self._rollout is None or not self._paths:
            return
        frame = self._rollout.frame_of(min(step, self._rollout.steps))
        if frame == self._frame:
            return
        self._frame = frame
        for name, path in self._paths.items():
            now = path[min(frame, len(path) - 1)].astype(np.float32)
            for rows, handle in self._parts[name]:
                handle.vertices = now[rows]

    def _make(
        self, name: str, mesh: Mesh, points: FloatArray
    ) -> list[tuple[NDArray[np.int64], viser.MeshHandle]]:
        parts = []
        colours, owner = colours_of(mesh, 1 if self._dressed else COLOURS)
        for number, colour in enumerate(colours):
            rows, faces = np.unique(mesh.faces[owner == number], return_inverse=True)
            if self._dressed:
                # All of them in their order, as the hidden form has them.
                rows, faces = np.arange(len(mesh.vertices)), mesh.faces
            handle = self._server.scene.add_mesh_simple(
                f"/deforming/{name}/{number}", points[rows].astype(np.float32),
                faces.reshape(-1, 3).astype(np.uint32), color=colour, side="double",
                cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
            handle.on_click(lambda _event: self._picked("object", name))
            parts.append((rows, handle))
        return parts


def colours_of(
    mesh: Mesh, most: int = COLOURS
) -> tuple[list[tuple[int, int, int]], NDArray[np.int64]]:
    """The main colours of a mesh, RGB, and for each face which of them it has."""
    if mesh.texture is None or mesh.uv is None:
        return [mesh.color], np.zeros(len(mesh.faces), np.int64)
    height, width = mesh.texture.shape[:2]
    middle = mesh.uv[mesh.faces].mean(axis=1)
    x = np.clip(middle[:, 0].astype(int), 0, width - 1)
    y = np.clip(middle[:, 1].astype(int), 0, height - 1)
    faces = mesh.texture[y, x].astype(float)
    centres = [faces.mean(axis=0)]
    for _ in range(most - 1):
        # The next colour is that of the face that is least like those chosen so far.
        apart = np.min([np.linalg.norm(faces - one, axis=1) for one in centres], axis=0)
        if apart.max() < 12:
            break
        centres.append(faces[int(apart.argmax())])
    chosen = np.array(centres)
    owner = np.zeros(len(faces), np.int64)
    for _ in range(TURNS):
        owner = np.linalg.norm(faces[:, None] - chosen[None], axis=-1).argmin(axis=1)
        for number in range(len(chosen)):
            if (owner == number).any():
                chosen[number] = faces[owner == number].mean(axis=0)
    kept, owner = np.unique(owner, return_inverse=True)
    plain = chosen[kept].round().astype(int).tolist()
    return [(r, g, b) for r, g, b in plain], owner.reshape(-1)
