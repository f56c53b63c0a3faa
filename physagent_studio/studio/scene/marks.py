"""Marks in the scene: arrows with values, contacts with their impulse, centres of mass.

The tip of an action's arrow can be dragged: along the ground plane, or with Shift in the plane of
the picture. Letting go sends the new vector.
"""

from dataclasses import replace

import numpy as np
import viser
from pydantic import JsonValue

from physagent_studio.arrays import FloatArray
from physagent_studio.program import SetField
from physagent_studio.program.scene.camera import Camera
from physagent_studio.studio.scene.arrows import Arrow, action_arrows, velocity_arrows
from physagent_studio.studio.scene.handles import Edited, Later
from physagent_studio.studio.view import View
from physagent_studio.workbench import Snapshot

Box = tuple[float, float, float, float]
"""Left, top, right and bottom, pixels of the view."""

VIEW_WIDTH = 640.0
"""Pixels that the view is wide in a window of 1280 × 720, where words have the least room."""
LETTER, LINE = 7.5, 20.0
"""Pixels that a letter is wide and a line is high at most, with the ground around it, at size 1."""
NAME, VALUE = 1.0, 0.9
"""Sizes of names and of values; at 1 viser writes 13 pixels high, so that none is below 10."""
GAP = 2.0
"""Pixels between two labels."""


class Labels:
    """The words of one step, in the order in which they are placed: a later one makes way."""

    def __init__(self, camera: Camera | None) -> None:
        self._camera = camera
        self.boxes: list[Box] = []

    def place(
        self, point: FloatArray, text: str, size: float = VALUE, *, below: bool = False
    ) -> FloatArray:
        """The place (3,) m of a label that points at `point`: there, or as far above it (or
        below) as is needed to cover no other. Without a photo it stays where it points.
        """
        if self._camera is None:
            return point
        pixels, depth = self._camera.project(np.asarray(point, float)[None])
        if depth[0] <= 0:
            return point
        scale = VIEW_WIDTH / self._camera.size[0]
        x, y = (float(part) * scale for part in pixels[0])
        half, high = (LETTER * len(text) * size + 8) / 2, LINE * size
        bottom = y + high if below else y
        while (other := self._covered(x - half, bottom - high, x + half, bottom)) is not None:
            bottom = other[3] + GAP + high if below else other[1] - GAP
        self.boxes.append((x - half, bottom - high, x + half, bottom))
        moved = y - (bottom - high if below else bottom)
        lift = moved / scale * float(depth[0]) / self._camera.focal
        return np.asarray(point, float) + np.array([0.0, 0.0, lift])

    def _covered(self, left: float, top: float, right: float, bottom: float) -> Box | None:
        for box in self.boxes:
            if left < box[2] and right > box[0] and top < box[3] and bottom > box[1]:
                return box
        return None


ACTION, VELOCITY, CONTACT = (230, 81, 40), (47, 111, 237), (226, 160, 20)
REACH = 25.0
"""Longest arrow that a drag may make, m; beyond it the pointer has left the scene."""


class Marks:
    """Owned by the stage; called by the studio's one thread."""

    def __init__(self, server: viser.ViserServer, edited: Edited, later: Later) -> None:
        self._server = server
        self._later = later
        self._edited = edited
        self._arrows: dict[str, tuple[viser.ArrowsHandle, viser.LabelHandle]] = {}
        self._grips: dict[str, viser.IcosphereHandle] = {}
        self._held: str | None = None

    def draw(self, snapshot: Snapshot, view: View, size: float, words: Labels) -> None:
        """Brings all marks to the step on view. words: what is written in the scene already."""
        selected = view.selection.name if view.selection.kind == "action" else ""
        show = "forces" in view.shown
        arrows = action_arrows(snapshot, view.step if show else -1, selected)
        moving = velocity_arrows(snapshot, view.step) if show else ()
        self._set_arrows((*arrows, *moving), size, words)
        self._set_grips([one for one in arrows if not snapshot.read_only], size)
        self._set_contacts(snapshot, view, size, words)
        self._set_centres(snapshot, view, size)

    def clear(self) -> None:
        """Forgets everything; the stage has removed the nodes."""
        self._server.scene.remove_by_name("/marks")
        self._arrows, self._grips, self._held = {}, {}, None

    def _set_arrows(self, arrows: tuple[Arrow, ...], size: float, words: Labels) -> None:
        for key in set(self._arrows) - {one.key for one in arrows}:
            # The label hangs below the arrow and goes with it.
            self._arrows.pop(key)[0].remove()
        for one in arrows:
            if self._held == one.key:
                continue
            self._arrows[one.key] = self._arrow(one, size)
            # What is pushed moves that way: the two values stand above and below their tips.
            below = one.kind != "action"
            self._arrows[one.key][1].position = words.place(one.tip, one.text, below=below)

    def _arrow(self, one: Arrow, size: float) -> tuple[viser.ArrowsHandle, viser.LabelHandle]:
        """The arrow as it should be; one that is there already is only moved."""
        length = float(np.linalg.norm(one.vector))
        color = ACTION if one.kind == "action" else VELOCITY
        if one.key in self._arrows:
            arrow, label = self._arrows[one.key]
            arrow.points = np.array([[one.foot, one.tip]], np.float32)
            arrow.head_length = min(size * 0.06, max(length * 0.4, 1e-4))
            label.text, label.position = one.text, one.tip
            return arrow, label
        arrow = self._server.scene.add_arrows(
            f"/marks/{one.key}", np.array([[one.foot, one.tip]]), colors=color,
            shaft_radius=size * 0.008, head_radius=size * 0.022,
            head_length=min(size * 0.06, max(length * 0.4, 1e-4)),
        )  # fmt: skip
        label = self._server.scene.add_label(
            f"/marks/{one.key}/value", one.text, position=one.tip, font_screen_scale=VALUE,
            anchor="bottom-center" if one.kind == "action" else "top-center",
        )  # fmt: skip
        return arrow, label

    # --- dragging ----------------------------------------------------------------------------

    def _set_grips(self, arrows: list[Arrow], size: float) -> None:
        wanted = {one.key: one for one in arrows if one.path is not None}
        for key in set(self._grips) - set(wanted):
            self._grips.pop(key).remove()
        for key, one in wanted.items():
            if key == self._held:
                continue
            if key not in self._grips:
                self._grips[key] = self._server.scene.add_icosphere(
                    f"/marks/tip {key}", radius=size * 0.03, color=ACTION, opacity=0.55,
                    position=one.tip, cast_shadow=False,
                )  # fmt: skip
            else:
                self._grips[key].remove_drag_callback("all")
                self._grips[key].position = one.tip
            self._bind(self._grips[key], one, size)

    def _bind(self, grip: viser.IcosphereHandle, one: Arrow, size: float) -> None:
        async def drag(event: viser.SceneNodeDragEvent[viser.IcosphereHandle]) -> None:
            eye = np.asarray(event.client.camera.position, float)
            pointer = np.asarray(event.end_position, float)
            tip = tip_of(one.middle, eye, pointer, free=event.modifier == "shift")
            ends = event.phase == "end"
            self._later(lambda: self._drag(one, tip, size, ends=ends), event.client.client_id, ends)

        grip.on_drag("left")(drag)
        grip.on_drag("left", modifier="shift")(drag)

    def _drag(self, one: Arrow, tip: FloatArray | None, size: float, *, ends: bool) -> None:
        self._held = None if ends else one.key
        if tip is None or one.path is None:
            return
        vector = one.vector_to(tip)
        if one.key in self._grips:
            self._grips[one.key].position = tip
        text = f"{np.linalg.norm(vector) / one.scale:.3g}"
        moved = replace(one, vector=vector, text=text)
        self._arrows[one.key] = self._arrow(moved, size)
        self._server.flush()
        value: list[JsonValue] = [float(f"{part:.4g}") for part in vector / one.scale]
        self._edited((SetField(path=one.path, value=value),), "arrow dragged", ends)

    # --- points ------------------------------------------------------------------------------

    def _set_contacts(self, snapshot: Snapshot, view: View, size: float, words: Labels) -> None:
        rollout = snapshot.rollout
        if rollout is None or "contacts" not in view.shown:
            self._server.scene.remove_by_name("/marks/contacts")
            return
        # What was touched since the frame before, so that a short impact is not skipped.
        since = view.step - snapshot.program.clip.steps_per_frame
        steps = rollout.contacts["step"]
        now = rollout.contacts[(steps > since) & (steps <= view.step)]
        if len(now) == 0:
            self._server.scene.remove_by_name("/marks/contacts")
            return
        largest = max(float(now["impulse"].max()), 1e-9)
        # Contacts name objects first: what is drawn is the push that the object gets.
        ends = now["point"] - now["normal"] * (now["impulse"] / largest)[:, None] * size * 0.25
        segments = np.stack([now["point"], ends], axis=1)
        self._server.scene.add_line_segments(
            "/marks/contacts/impulses", segments, colors=CONTACT, thickness=2.5,
            thickness_units="screen",
        )  # fmt: skip
        self._server.scene.add_point_cloud(
            "/marks/contacts/points", now["point"].astype(np.float32), colors=CONTACT,
            point_size=size * 0.025, point_shape="circle",
        )  # fmt: skip
        strongest = now[int(now["impulse"].argmax())]
        text = f"{float(strongest['impulse']):.3g} N·s"
        self._server.scene.add_label(
            "/marks/contacts/value", text,
            position=words.place(strongest["point"], text, below=True),
            font_screen_scale=VALUE, anchor="top-center",
        )  # fmt: skip

    def _set_centres(self, snapshot: Snapshot, view: View, size: float) -> None:
        rollout = snapshot.rollout
        if rollout is None or "centres" not in view.shown:
            self._server.scene.remove_by_name("/marks/centres")
            return
        row = min(view.step, rollout.steps)
        self._server.scene.add_point_cloud(
            "/marks/centres", rollout.positions[row].astype(np.float32), colors=(20, 20, 20),
            point_size=size * 0.03, point_shape="diamond",
        )  # fmt: skip


def tip_of(
    foot: FloatArray, eye: FloatArray, pointer: FloatArray, *, free: bool
) -> FloatArray | None:
    """Where a dragged tip goes: on the level plane through the foot, or with `free` just there.

    None where the ray runs along the plane or away from it, or what comes is no place at all.
    """
    if not (np.isfinite(pointer).all() and np.isfinite(eye).all()):
        return None
    tip = pointer
    if not free:
        ray = pointer - eye
        if abs(ray[2]) < 0.02 * np.linalg.norm(ray):
            return None
        share = (foot[2] - eye[2]) / ray[2]
        if share <= 0:
            return None
        tip = eye + ray * share
    return tip if np.linalg.norm(tip - foot) <= REACH else None
