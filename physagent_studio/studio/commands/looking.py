"""The playhead and what is looked at: nothing here changes a session."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from physagent_studio.errors import InputError
from physagent_studio.studio.commands.asking import Frame, Id, Label, asked
from physagent_studio.studio.scene.places import poses_at
from physagent_studio.studio.view import Selection
from physagent_studio.workbench import commands

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio

ViewOption = Literal[
    "photo", "supports", "frustum", "gravity", "axes", "labels", "trails", "ghosts", "contacts",
    "forces", "centres", "collisions", "gizmo",
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


@asked("viewer", "watch")
def viewer(
    studio: Studio, browser: int, token: Annotated[str, Field(pattern=r"^[0-9a-f]{8,64}$")]
) -> None:
    """Which 3D view belongs to the page that speaks."""
    studio.tokens[browser] = token


@asked("look", "watch")
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


@asked("bookmark", "watch")
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
