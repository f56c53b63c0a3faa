"""What the engine collides, as wire over what is seen."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import viser
from numpy.typing import NDArray

from physagent_studio.records import Mesh
from physagent_studio.studio.scene.outline import edges_of

Outlines = Mapping[str, tuple[Mesh, ...]]
WIRE = (236, 72, 153)
Poses = Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]]


class Collisions:
    """Owned by the stage; called by the studio's one thread."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._shown: Outlines | None = None
        self._moving: dict[str, viser.LineSegmentsHandle] = {}

    def clear(self) -> None:
        """Removes all of them."""
        self._server.scene.remove_by_name("/collisions")
        self._shown, self._moving = None, {}

    def show(
        self, outlines: Mapping[str, tuple[Mesh, ...]] | None, objects: frozenset[str]
    ) -> None:
        """Draws the outlines; those of `objects` move, the others stand in the world."""
        if outlines is self._shown:
            return
        self.clear()
        self._shown = outlines
        for name, meshes in (outlines or {}).items():
            # An edge that is hardly one is drawn too: a ball has no other.
            lines = np.concatenate([edges_of(mesh, angle=1.0) for mesh in meshes])
            handle = self._server.scene.add_line_segments(
                f"/collisions/{name}", lines, colors=WIRE, thickness=1.2, thickness_units="screen"
            )
            if name in objects:
                self._moving[name] = handle

    def pose(self, poses: Poses) -> None:
        """Moves the outlines to where the objects are."""
        for name, handle in self._moving.items():
            if name in poses:
                handle.position, handle.wxyz = poses[name]
