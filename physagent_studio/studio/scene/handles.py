"""The selected thing in the scene: a frame around it, and a gizmo to move and turn it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from physagent_studio.records import Mesh

FloatArray = NDArray[np.float64]
Later = Callable[[Callable[[], None]], None]
"""Has something done by the studio's thread; may be called from any thread."""

Placed = Callable[[str, FloatArray, FloatArray], None]
"""Called with an object's name, its new position, m, and rotation, wxyz."""

FRAME = (255, 190, 30)
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]


class Handles:
    """Owned by the stage; called by the studio's one thread."""

    def __init__(self, server: viser.ViserServer, placed: Placed, later: Later) -> None:
        self._server = server
        self._placed = placed
        self._later = later
        self._frame: tuple[str, viser.LineSegmentsHandle] | None = None
        self._gizmo: tuple[str, viser.TransformControlsHandle] | None = None
        self._held = False

    def clear(self) -> None:
        """Removes both."""
        self._server.scene.remove_by_name("/selection")
        self._frame, self._gizmo, self._held = None, None, False

    def select(self, name: str, mesh: Mesh | None, *, gizmo: bool) -> None:
        """Frames an object, with a gizmo where it may be moved; no mesh takes both away."""
        if self._frame is not None and (self._frame[0] != name or mesh is None):
            self._frame[1].remove()
            self._frame = None
        if self._gizmo is not None and (self._gizmo[0] != name or mesh is None or not gizmo):
            self._gizmo[1].remove()
            self._gizmo, self._held = None, False
        if mesh is None:
            return
        if self._frame is None:
            handle = self._server.scene.add_line_segments(
                "/selection/frame", frame_of(mesh), colors=FRAME, thickness=2,
                thickness_units="screen",
            )  # fmt: skip
            self._frame = (name, handle)
        if self._gizmo is None and gizmo:
            self._gizmo = (name, self._make_gizmo(name, mesh))

    def _make_gizmo(self, name: str, mesh: Mesh) -> viser.TransformControlsHandle:
        reach = float(np.linalg.norm(mesh.vertices, axis=1).max())
        handle = self._server.scene.add_transform_controls(
            "/selection/gizmo", scale=reach * 2.2, line_width=2.0, depth_test=False, opacity=0.85
        )

        async def moved(event: viser.TransformControlsEvent) -> None:
            position = np.asarray(event.target.position, float).copy()
            rotation = np.asarray(event.target.wxyz, float).copy()
            ends = event.phase == "end"
            self._later(lambda: self._move(name, position, rotation, ends=ends))

        handle.on_update(moved)
        return handle

    def _move(self, name: str, position: FloatArray, rotation: FloatArray, *, ends: bool) -> None:
        finite = np.isfinite(position).all() and np.isfinite(rotation).all()
        self._held = not ends
        if not finite or np.linalg.norm(rotation) < 1e-6:
            return
        if self._frame is not None:
            self._frame[1].position, self._frame[1].wxyz = position, rotation
        if ends:
            self._placed(name, position, rotation)

    def pose(self, position: FloatArray, rotation: FloatArray) -> None:
        """Brings both to where the object is, unless a hand is on the gizmo."""
        if self._held:
            return
        for pair in (self._frame, self._gizmo):
            if pair is not None:
                pair[1].position, pair[1].wxyz = position, rotation


def frame_of(mesh: Mesh) -> FloatArray:
    """(12, 2, 3) the edges of the mesh's box in the body frame, a little larger, m."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    margin = 0.04 * float((high - low).max())
    corners = low - margin + _CORNERS * (high - low + 2 * margin)
    return np.array([[corners[a], corners[b]] for a, b in _EDGES])
