"""The stage: everything in the 3D view that all browsers share, drawn from a snapshot and a view.

Nodes are made when the scene changes and only moved afterwards. All methods are called by the
studio's one thread.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import viser

from physagent_studio.arrays import FloatArray
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import matrix_of
from physagent_studio.records import Mesh, Rollout
from physagent_studio.studio.guard import put
from physagent_studio.studio.scene.deforming import Deforming
from physagent_studio.studio.scene.furniture import Furniture, light
from physagent_studio.studio.scene.ghosts import EARLIER, PREVIEW, TRIED, Collisions, Ghosts
from physagent_studio.studio.scene.glb import glb_of
from physagent_studio.studio.scene.handles import Edited, Handles, Held, Later, Wished
from physagent_studio.studio.scene.marks import NAME, Labels, Marks
from physagent_studio.studio.scene.places import (
    Poses,
    centre_and_size,
    colours_of,
    held_at,
    poses_at,
)
from physagent_studio.studio.scene.primitives import mesh_of_object
from physagent_studio.studio.view import View
from physagent_studio.workbench import Snapshot

Picked = Callable[[str, str], None]
"""Called from viser's threads with the kind and the name of what was clicked."""


@dataclass(frozen=True, slots=True)
class Hands:
    """What the stage does with what a person does in it.

    picked comes from viser's threads, `later` may be called from any, the others are called by
    the studio's own thread.
    """

    picked: Picked
    edited: Edited
    wished: Wished
    later: Later


MOST_NAMES = 24
"""More objects than these go without names in the scene, which would only cover each other."""

STILL = 1e-6
"""A pose that differs by less, m or a part of a quaternion, is the same to the eye."""

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], bool)


class Stage:
    """Draws objects, supports, trails, ghosts and marks."""

    def __init__(self, server: viser.ViserServer, hands: Hands, *, dressed: bool = True) -> None:
        """dressed: the page that shows it runs `pages/dressing.js`."""
        self._server = server
        self._picked = hands.picked
        self._marks = Marks(server, hands.edited, hands.later)
        self._ghosts = Ghosts(server)
        self._collisions = Collisions(server)
        self._deforming = Deforming(server, hands.picked, dressed)
        self._furniture = Furniture(server, hands.picked)
        self._handles = Handles(server, hands.edited, hands.wished, hands.later)
        self._made_from: tuple[object, ...] = ()
        self._objects: dict[str, viser.GlbHandle] = {}
        self._labels: dict[str, viser.LabelHandle] = {}
        self._boxes: dict[str, FloatArray] = {}
        self._meshes: dict[str, Mesh] = {}
        self._sent: tuple[list[str], FloatArray, FloatArray] | None = None
        self._extent: tuple[object, FloatArray, float] | None = None
        server.scene.world_axes.visible = False
        light(server.scene)

    def draw(self, snapshot: Snapshot, view: View, earlier: Rollout | None) -> None:
        """Brings the whole stage up to date."""
        with self._server.atomic():
            self._make(snapshot)
            self._furniture.show(view.drawn)
            for name, label in self._labels.items():
                label.visible = "labels" in view.drawn and name not in view.hidden
            own = colours_of(snapshot)
            ghosts, trails = "ghosts" in view.drawn, "trails" in view.drawn
            preview = snapshot.preview_rollout if ghosts else None
            earlier = earlier if ghosts else None
            self._ghosts.set_ghost("preview", preview, PREVIEW, self._meshes)
            self._ghosts.set_ghost("earlier", earlier, EARLIER, self._meshes)
            self._ghosts.set_trail("now", snapshot.rollout if trails else None, own)
            self._ghosts.set_trail("preview", preview if trails else None, PREVIEW)
            self._ghosts.set_trail("earlier", earlier if trails else None, EARLIER)
            sturdy = snapshot.probed.sturdiness if snapshot.probed and trails else None
            self._ghosts.set_ribbon(sturdy, own)
            self._set_attempt(snapshot)
            self._ghosts.show(not view.is_clean)
            self._collisions.show(
                snapshot.collisions if "collisions" in view.drawn else None,
                frozenset(self._objects),
            )
            self._deforming.show(snapshot.rollout, self._meshes)
            for name, handle in self._objects.items():
                handle.visible = name not in self._deforming.names and name not in view.hidden
        self.pose(snapshot, view)

    def attempt(self, snapshot: Snapshot, view: View) -> None:
        """Draws what would come of the edit under the pointer; the rest stays as it is."""
        with self._server.atomic():
            self._set_attempt(snapshot)
            self._ghosts.pose(view.step, snapshot.rollout)
        self._server.flush()

    def _set_attempt(self, snapshot: Snapshot) -> None:
        tried = snapshot.attempt.rollout if snapshot.attempt else None
        self._ghosts.set_ghost("tried", tried, TRIED, self._meshes)
        self._ghosts.set_trail("tried", tried, TRIED)

    def pose(self, snapshot: Snapshot, view: View) -> None:
        """Moves everything to the step on view; cheap, called on every frame of playback."""
        with self._server.atomic():
            poses = poses_at(snapshot, view.step)
            words = Labels(snapshot.program.scene.camera)
            if "gravity" in view.drawn:
                self._furniture.keep_free(words)
            self._move(poses)
            self._mark_held(snapshot, view.step)
            if "labels" in view.drawn:
                self._put_names(poses, words, view.hidden)
            self._ghosts.pose(view.step, snapshot.rollout)
            self._deforming.pose(view.step)
            self._collisions.pose(poses)
            self._frame(snapshot, view, poses)
            self._marks.draw(snapshot, view, self._measured(snapshot.program)[1], words)
        self._server.flush()

    def _move(self, poses: Poses) -> None:
        """Sends the poses that have changed; all are compared at once."""
        names = [name for name in self._objects if name in poses]
        if not names:
            return
        places = np.array([poses[name][0] for name in names])
        turns = np.array([poses[name][1] for name in names])
        if self._sent is None or self._sent[0] != names:
            moved = turned = np.ones(len(names), bool)
        else:
            moved = np.abs(places - self._sent[1]).max(axis=1) > STILL
            turned = np.abs(turns - self._sent[2]).max(axis=1) > STILL
            places = np.where(moved[:, None], places, self._sent[1])
            turns = np.where(turned[:, None], turns, self._sent[2])
        self._sent = (names, places, turns)
        for at in np.flatnonzero(moved | turned):
            handle = self._objects[names[at]]
            put(handle, places[at] if moved[at] else None, turns[at] if turned[at] else None)

    def _put_names(self, poses: Poses, words: Labels, hidden: frozenset[str]) -> None:
        """Names just over the box around each thing, however it has turned; lower ones first."""
        tips = {}
        for name in self._labels:
            if name in poses and name not in hidden:
                place, turn = poses[name]
                top = float((self._boxes[name] @ matrix_of(turn.tolist())[2]).max())
                tips[name] = place + np.array([0, 0, top * 1.12])
        for name in sorted(tips, key=lambda one: float(tips[one][2])):
            self._labels[name].position = words.place(tips[name], self._labels[name].text, NAME)

    def _mark_held(self, snapshot: Snapshot, step: int) -> None:
        """Says beside its name that an action holds a thing still."""
        held = held_at(snapshot, step)
        for name, label in self._labels.items():
            text = f"{_said(name)} · held" if name in held else _said(name)
            if label.text != text:
                label.text = text

    def _frame(self, snapshot: Snapshot, view: View, poses: Poses) -> None:
        name = view.selection.name if view.selection.kind == "object" else ""
        mesh = self._meshes.get(name) if name in poses else None
        item = snapshot.program.scene.object(name)
        if mesh is None or item is None:
            self._handles.select(None)
            return
        what = ""
        if "gizmo" in view.drawn and not snapshot.read_only:
            # Where a thing is at the start can be changed; later, physics says where it is.
            what = "place" if view.step == 0 or snapshot.rollout is None else "wish"
        self._handles.select(Held(item, mesh, what))
        self._handles.pose(*poses[name])

    # --- making ----------------------------------------------------------------------------------

    def _make(self, snapshot: Snapshot) -> None:
        key = (
            snapshot.scene.hash if snapshot.scene else None,
            snapshot.program.scene.objects,
            snapshot.program.scene.supports,
            snapshot.program.scene.camera,
            snapshot.program.scene.gravity,
        )
        if key == self._made_from:
            return
        self._made_from = key
        scene, program = snapshot.scene, snapshot.program
        looks: dict[str, Mesh] = {}
        for item in program.scene.objects:
            mesh = scene.meshes.get(item.name) if scene else None
            mesh = mesh if mesh is not None else mesh_of_object(item)
            if mesh is not None:
                looks[item.name] = mesh
        self._make_objects(looks)
        self._furniture.clear()
        self._furniture.make(program, scene, *self._measured(program))

    def _make_objects(self, looks: dict[str, Mesh]) -> None:
        """Draws what looks different or is new; what only weighs or stands otherwise stays."""
        kept = {
            name
            for name, mesh in self._meshes.items()
            if name in looks and alike(mesh, looks[name])
        }
        self._marks.clear()
        self._handles.clear()
        self._sent = None
        if kept == set(looks) == set(self._meshes):
            return
        for part in (self._ghosts, self._collisions, self._deforming):
            part.clear()
        for name in set(self._meshes) - kept:
            self._objects.pop(name).remove()
            del self._meshes[name]
        for name in looks:
            if name not in kept:
                self._add_object(name, looks[name])
        self._name_objects()

    def _add_object(self, name: str, mesh: Mesh) -> None:
        handle = self._server.scene.add_glb(f"/objects/{name}", glb_of(mesh), cast_shadow=False)
        handle.on_click(lambda _event: self._picked("object", name))
        self._objects[name], self._meshes[name] = handle, mesh

    def _name_objects(self) -> None:
        """Names over the things, unless there are too many."""
        for label in self._labels.values():
            label.remove()
        self._labels, self._boxes = {}, {}
        for name, mesh in self._meshes.items() if len(self._meshes) <= MOST_NAMES else ():
            low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
            self._boxes[name] = np.where(CORNERS, high, low)
            self._labels[name] = self._server.scene.add_label(
                f"/objects/label {name}",
                _said(name),
                font_screen_scale=NAME,
                anchor="bottom-center",
            )

    # --- measures ----------------------------------------------------------------------------

    def _measured(self, program: PhysicalProgram) -> tuple[FloatArray, float]:
        objects = program.scene.objects
        if self._extent is None or self._extent[0] is not objects:
            self._extent = (objects, *centre_and_size(program))
        return self._extent[1:]


def _said(name: str) -> str:
    return name.replace("_", " ")


def alike(one: Mesh, other: Mesh) -> bool:
    """Whether two meshes look the same."""
    if one is other:
        return True
    if one.color != other.color or not np.array_equal(one.vertices, other.vertices):
        return False
    pairs = [(one.faces, other.faces), (one.uv, other.uv), (one.texture, other.texture)]
    if one.shading is not None and other.shading is not None:
        pairs += [(np.array(one.shading.terms), np.array(other.shading.terms))]
    return (one.shading is None) == (other.shading is None) and all(
        a is b or (a is not None and b is not None and np.array_equal(a, b)) for a, b in pairs
    )
