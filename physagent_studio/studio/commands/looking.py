"""The playhead and what is looked at: nothing here changes a session."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field, JsonValue

from physagent_studio.arrays import FloatArray
from physagent_studio.errors import InputError
from physagent_studio.program.base import Pixel
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.forms import Floor
from physagent_studio.studio.commands.asking import Frame, Id, Label, asked
from physagent_studio.studio.scene.places import poses_at
from physagent_studio.studio.view import Selection
from physagent_studio.workbench import Snapshot, commands

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio


ViewOption = Literal[
    "photo", "supports", "frustum", "gravity", "axes", "labels", "trails", "ghosts", "contacts",
    "forces", "centres", "collisions", "gizmo", "clean",
]  # fmt: skip
Selectable = Literal[
    "object", "support", "landmark", "action", "statement", "camera", "clip", "none"
]


@asked("play", "look")
def play(studio: Studio, browser: int, on: bool | None = None, once: bool = False) -> None:
    """Plays, or pauses; `once` plays from the start to the end and stops there."""
    view, clip = studio.view, studio.snapshot.program.clip
    on = not view.playing if on is None else on
    view = replace(view, once=once)
    if on and (once or view.step >= view.range(clip)[1]):
        view = replace(view, step=view.range(clip)[0])
    studio.set_view(replace(view, playing=on and studio.snapshot.rollout is not None))


@asked("scrub", "look")
def scrub(studio: Studio, browser: int, frame: Frame) -> None:
    """Puts the playhead on a frame; a burst of these comes down to the last one."""
    studio.set_view(studio.view.at_frame(frame, studio.snapshot.program.clip))


@asked("speed", "look")
def speed(studio: Studio, browser: int, factor: Annotated[float, Field(ge=0.05, le=8)]) -> None:
    """Playback speed, 1 is as the clip is shown."""
    studio.set_view(replace(studio.view, speed=factor))


@asked("loop", "look")
def loop(
    studio: Studio, browser: int, on: bool, start: Frame | None = None, end: Frame | None = None
) -> None:
    """Repeats the clip, or the frames from `start` to `end`."""
    studio.set_view(replace(studio.view, loop=on, loop_start=start, loop_end=end))


@asked("select", "look")
def select(studio: Studio, browser: int, kind: Selectable, name: Label = "") -> None:
    """Selects a thing in all views at once."""
    studio.set_view(replace(studio.view, selection=Selection(kind, name)))


@asked("show", "look")
def show(studio: Studio, browser: int, what: ViewOption, on: bool) -> None:
    """Shows or hides something in the scene."""
    studio.set_view(studio.view.with_shown(what, on))
    if what == "collisions":
        studio.workbench.post(commands.ShowCollisions(on))


@asked("compare", "look")
def compare(studio: Studio, browser: int, round: Id | None = None) -> None:
    """Compares the shown round with another; None ends it."""
    studio.set_view(replace(studio.view, compare=round))


@asked("hide", "look")
def hide(
    studio: Studio, browser: int, name: Label = "", how: Literal["this", "only", "none"] = "this"
) -> None:
    """Hides a thing in the 3D view, or all others (`only`), or shows everything again (`none`)."""
    hidden = studio.view.hidden ^ {name}
    if how == "none":
        hidden = frozenset()
    elif how == "only":
        others = frozenset(one.name for one in studio.snapshot.program.scene.objects) - {name}
        hidden = frozenset() if studio.view.hidden == others else others
    studio.set_view(replace(studio.view, hidden=hidden))


@asked("viewer", "follow")
def viewer(
    studio: Studio, browser: int, token: Annotated[str, Field(pattern=r"^[0-9a-f]{8,64}$")]
) -> None:
    """Which 3D view belongs to the page that speaks."""
    studio.tokens[browser] = token


@asked("look", "follow")
def look(
    studio: Studio,
    browser: int,
    view: Literal["photo", "top", "side", "front", "selection", "follow"],
) -> None:
    """Moves this browser's camera; `follow` keeps it on the selected object."""
    target = None
    if view in ("selection", "follow"):
        place = poses_at(studio.snapshot, studio.view.step).get(studio.view.selection.name)
        if place is None:
            raise InputError("select an object first, then look at it")
        target = place[0]
    studio.painter.cameras.look(studio.viewer_of(browser), view, target)


@asked("bookmark", "follow")
def bookmark(
    studio: Studio, browser: int, slot: Annotated[int, Field(ge=1, le=9)], keep: bool = False
) -> None:
    """Keeps this browser's camera under a number, or goes back to it."""
    cameras, own = studio.painter.cameras, studio.viewer_of(browser)
    if keep:
        cameras.keep(own, slot)
        studio.say(browser, "info", f"View {slot} kept; press {slot} to come back")
    elif not cameras.recall(own, slot):
        studio.say(browser, "info", f"No view {slot} yet; Shift+{slot} keeps one")


@asked("present", "look")
def present(studio: Studio, browser: int, on: bool) -> None:
    """From now on this page only looks, or (`on` false) may change things again."""
    if on:
        studio.presenting.add(browser)
    else:
        studio.presenting.discard(browser)


GRAZING = 1e-12
"""Determinant below which a ray runs along a face and meets it nowhere."""


@asked("measure", "look")
def measure(studio: Studio, browser: int, a: Pixel, b: Pixel) -> None:
    """How far two pixels of the photo are apart in the scene, metres; nothing is changed."""
    apart = point_at(studio.snapshot, b) - point_at(studio.snapshot, a)
    told: JsonValue = {
        "metres": round(float(np.linalg.norm(apart)), 4),
        "up": round(float(apart[2]), 4),
        "along": round(float(np.linalg.norm(apart[:2])), 4),
    }
    studio.tell(browser, "measured", told)


def point_at(snapshot: Snapshot, pixel: tuple[float, float]) -> FloatArray:
    """The first point (3,) of the scene at its start that a pixel of the photo shows, world, m."""
    camera = snapshot.program.scene.camera
    if camera is None:
        raise InputError("there is no scene yet to measure in")
    eye, ray = np.array(camera.position), camera.rays(np.array([pixel], float))[0]
    near = min(_distances(snapshot, eye, ray), default=np.inf)
    if not np.isfinite(near):
        raise InputError("there is nothing but sky at that point; click on a thing or the ground")
    return eye + near * ray


def _distances(snapshot: Snapshot, eye: FloatArray, ray: FloatArray) -> Iterator[float]:
    """How many times the ray reaches what it meets."""
    scene, state = snapshot.scene, snapshot.program.scene
    for item in state.objects:
        mesh = scene.meshes.get(item.name) if scene else None
        if mesh is not None and item.position is not None:
            turn = matrix_of(item.rotation)
            here = (eye - np.array(item.position)) @ turn
            yield from _hits(mesh.vertices[mesh.faces], here, ray @ turn)
    for mesh in scene.support_meshes.values() if scene else ():
        yield from _hits(mesh.vertices[mesh.faces], eye, ray)
    for support in state.supports:
        if isinstance(support.shape, Floor) and ray[2] < 0:
            yield float((support.shape.height - eye[2]) / ray[2])


def _hits(corners: FloatArray, eye: FloatArray, ray: FloatArray) -> Iterator[float]:
    """Where a ray meets triangles (N, 3, 3). Möller and Trumbore, 1997."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(ray, second)
    size = np.einsum("ij,ij->i", first, across)
    flat = np.abs(size) < GRAZING
    inverse = 1.0 / np.where(flat, 1.0, size)
    away = eye - corners[:, 0]
    u = np.einsum("ij,ij->i", away, across) * inverse
    over = np.cross(away, first)
    v = (over @ ray) * inverse
    share = np.einsum("ij,ij->i", second, over) * inverse
    met = ~flat & (u >= 0) & (v >= 0) & (u + v <= 1) & (share > 0)
    yield from share[met].tolist()
