"""Ghosts and paths: where things go in other rounds, and where they go in this one."""

from collections.abc import Mapping

import numpy as np
import viser
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import angle_between, matrices_of
from physagent_studio.records import Mesh, Rollout
from physagent_studio.studio.scene.primitives import edges_of
from physagent_studio.sweep.robustness import Robustness

EARLIER, PREVIEW = (150, 154, 162), (18, 184, 166)
TRIED = (245, 158, 11)
BROKEN = (224, 92, 32)
NEAR_METRES, NEAR_RADIANS = 0.004, 0.03
"""A ghost this close to the thing itself is not drawn, since both would flicker."""

LEAST_WAY = 0.01
"""What goes less far, m, has no path worth drawing."""
QUIET = 0.2
"""How much a ghost hides of what is behind it: it is seen, and the thing itself stands out."""

Color = tuple[int, int, int]


class Ghosts:
    """Owned by the stage; called by the studio's one thread."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._ghosts: dict[str, tuple[Rollout, dict[str, viser.MeshHandle]]] = {}
        self._trails: dict[str, tuple[Rollout, dict[str, viser.LineSegmentsHandle]]] = {}
        self._ribbon: Robustness | None = None
        self._lines: list[viser.LineSegmentsHandle] = []
        self._on = True

    def clear(self) -> None:
        """Removes all of them."""
        for name in ("/ghosts", "/trails", "/ribbon"):
            self._server.scene.remove_by_name(name)
        self._ghosts, self._trails, self._ribbon, self._lines = {}, {}, None, []

    def show(self, on: bool) -> None:
        """Draws all that is there, or none of it, while it stays there."""
        self._on = on
        kept = (*self._trails.values(), *self._ghosts.values())
        for handle in (*self._lines, *(one for _, named in kept for one in named.values())):
            if handle.visible != on:
                handle.visible = on

    def set_ghost(
        self, key: str, rollout: Rollout | None, color: Color, meshes: dict[str, Mesh]
    ) -> None:
        """Shows the moving objects of a rollout as shades; None takes them away."""
        names = [] if rollout is None else [n for i, n in enumerate(rollout.objects)
                                            if n in meshes and moves(rollout, i)]  # fmt: skip
        shown = self._ghosts.get(key)
        if shown is not None and rollout is not None and list(shown[1]) == names:
            self._ghosts[key] = (rollout, shown[1])
            return
        if shown is not None:
            del self._ghosts[key]
            self._server.scene.remove_by_name(f"/ghosts/{key}")
        if rollout is None:
            return
        handles = {
            name: self._server.scene.add_mesh_simple(
                f"/ghosts/{key}/{name}", meshes[name].vertices, meshes[name].faces,
                color=color, opacity=QUIET, cast_shadow=False, receive_shadow=False,
            )
            for name in names
        }  # fmt: skip
        self._ghosts[key] = (rollout, handles)

    def set_trail(
        self, key: str, rollout: Rollout | None, color: Color | Mapping[str, Color]
    ) -> None:
        """Shows the paths of a rollout's moving objects; a None rollout takes them away.

        color: of all of them, or of each by its name.
        """
        shown = self._trails.get(key)
        if shown is not None and shown[0] is rollout:
            return
        lines = {} if rollout is None else paths_of(rollout)
        handles = {} if shown is None else shown[1]
        for name in set(handles) - set(lines):
            handles.pop(name).remove()
        for name, line in lines.items():
            if name in handles and handles[name].points.shape == line.shape:
                handles[name].points = line
                continue
            own = color[name] if isinstance(color, Mapping) else color
            handles[name] = self._server.scene.add_line_segments(
                f"/trails/{key}/{name}", line, colors=own, thickness=2.5,
                thickness_units="screen",
            )  # fmt: skip
        if rollout is None:
            self._trails.pop(key, None)
        else:
            self._trails[key] = (rollout, handles)

    def set_ribbon(self, sturdy: Robustness | None, colors: Mapping[str, Color]) -> None:
        """Shows where the things go in all runs of a program whose numbers are a little moved.

        Runs that fail are drawn in the colour of what is broken; None takes the ribbon away.
        """
        if sturdy is self._ribbon:
            return
        self._ribbon, self._lines = sturdy, []
        self._server.scene.remove_by_name("/ribbon")
        if sturdy is None or not sturdy.runs[0].objects:
            return
        paths, held = sturdy.paths
        for at, name in enumerate(sturdy.runs[0].objects):
            own = ("held", held, pale(colors[name]))
            for kind, which, color in (own, ("broken", ~held, BROKEN)):
                lines = paths[which][:, :, at]
                if len(lines) and np.linalg.norm(lines - lines[:, :1], axis=2).max() > LEAST_WAY:
                    parts = np.stack([lines[:, :-1], lines[:, 1:]], axis=2).reshape(-1, 2, 3)
                    lines_drawn = self._server.scene.add_line_segments(
                        f"/ribbon/{kind}/{name}", parts.astype(np.float32), colors=color,
                        thickness=1.2, thickness_units="screen",
                    )  # fmt: skip
                    self._lines.append(lines_drawn)

    def pose(self, step: int, now: Rollout | None) -> None:
        """Moves the shades to a step."""
        for rollout, handles in self._ghosts.values():
            row = min(step, rollout.steps)
            for name, handle in handles.items():
                at = rollout.objects.index(name)
                handle.visible = self._on and not _covers(rollout, now, name, step)
                handle.position = rollout.positions[row, at]
                handle.wxyz = rollout.rotations[row, at]


def paths_of(rollout: Rollout) -> dict[str, NDArray[np.float32]]:
    """(M, 2, 3) segments of the path of everything that moves, world, m."""
    rows = np.unique(np.append(np.arange(0, rollout.steps, 2), rollout.steps))
    found = {}
    for at, name in enumerate(rollout.objects):
        if len(rows) > 1 and moves(rollout, at):
            line = rollout.positions[rows, at].astype(np.float32)
            found[name] = np.stack([line[:-1], line[1:]], axis=1)
    return found


def pale(color: Color) -> Color:
    """The colour half way to white: many lines of it beside one another are a band."""
    red, green, blue = ((part + 255) // 2 for part in color)
    return red, green, blue


def _covers(ghost: Rollout, now: Rollout | None, name: str, step: int) -> bool:
    """Whether the thing itself stands where its ghost would."""
    if now is None or name not in now.objects:
        return False
    a, b = ghost.objects.index(name), now.objects.index(name)
    i, j = min(step, ghost.steps), min(step, now.steps)
    apart = float(np.linalg.norm(ghost.positions[i, a] - now.positions[j, b]))
    turned = float(angle_between(ghost.rotations[i, a], now.rotations[j, b]))
    return apart < NEAR_METRES and turned < NEAR_RADIANS


def moves(rollout: Rollout, at: int) -> bool:
    """Whether an object goes anywhere worth drawing."""
    path = rollout.positions[:, at]
    turned = matrices_of(rollout.rotations[[0, -1], at])
    far = float(np.linalg.norm(path - path[0], axis=1).max())
    return far > LEAST_WAY or bool(np.trace(turned[0].T @ turned[1]) < 2.9)


Outlines = Mapping[str, tuple[Mesh, ...]]
WIRE = (236, 72, 153)
Poses = Mapping[str, tuple[FloatArray, FloatArray]]


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
