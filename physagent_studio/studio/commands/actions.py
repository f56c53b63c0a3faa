"""What every intent does: a change of the view, or a command to the workbench."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from dataclasses import replace
from functools import singledispatch
from typing import Any, Protocol

from physagent_studio.errors import InputError
from physagent_studio.jobs import Executor
from physagent_studio.program import PhysicalProgram, Support, apply
from physagent_studio.program.scene import state as shapes
from physagent_studio.records.clip_look import ClipLook
from physagent_studio.studio.commands import aloft, directing, shelf
from physagent_studio.studio.commands import mesh as mesh_actions
from physagent_studio.studio.commands import photo as photo_actions
from physagent_studio.studio.commands import program as program_actions
from physagent_studio.studio.commands import sketch as sketch_actions
from physagent_studio.studio.commands.mesh import MeshDesk
from physagent_studio.studio.commands.sketch import Sketches, kept_photo
from physagent_studio.studio.desk_apart import DeskApart
from physagent_studio.studio.finder import Finder
from physagent_studio.studio.intents import every as intents
from physagent_studio.studio.intents import shelf as intents_shelf
from physagent_studio.studio.library import Library, output_path
from physagent_studio.studio.painter import Painter
from physagent_studio.studio.replay import recording_of, replay_of
from physagent_studio.studio.scene.places import poses_at
from physagent_studio.studio.view import Selection, View
from physagent_studio.workbench import Snapshot, Workbench, commands
from physagent_studio.workbench.naming import names_in

Offer = tuple[str, dict[str, Any]]
"""What a notice offers: the words on its button, and the intent that it sends."""


class Studio(Protocol):
    """What an intent may use; `studio.Studio` is one."""

    workbench: Workbench
    snapshot: Snapshot
    view: View
    painter: Painter
    library: Library
    finder: Finder
    photo_desk: DeskApart
    apart: Executor
    mesh_desk: MeshDesk
    sketches: Sketches
    tokens: dict[int, str]
    presenting: set[int]

    def set_view(self, view: View) -> None: ...
    def say(
        self, browser: int | None, level: str, text: str, offer: Offer | None = None
    ) -> None: ...
    def tell(self, browser: int, channel: str, value: Any) -> None: ...
    def answer(self, browser: int, ticket: int | None, problem: str | None) -> None: ...
    def viewer_of(self, browser: int) -> int: ...
    def once_written(self, act: Callable[[], None]) -> None: ...


@singledispatch
def carry_out(intent: Any, studio: Studio, browser: int) -> None:
    """Carries out an intent; an `InputError` says why not."""
    raise InputError(f"{type(intent).__name__} is not known here")


# --- the view ----------------------------------------------------------------------------------


@carry_out.register
def _(intent: intents.Play, studio: Studio, browser: int) -> None:
    view, clip = studio.view, studio.snapshot.program.clip
    on = not view.playing if intent.on is None else intent.on
    view = replace(view, once=intent.once)
    if on and (intent.once or view.step >= view.range(clip)[1]):
        view = replace(view, step=view.range(clip)[0])
    studio.set_view(replace(view, playing=on and studio.snapshot.rollout is not None))


@carry_out.register
def _(intent: intents.Scrub, studio: Studio, browser: int) -> None:
    studio.set_view(studio.view.at_frame(intent.frame, studio.snapshot.program.clip))


@carry_out.register
def _(intent: intents.Speed, studio: Studio, browser: int) -> None:
    studio.set_view(replace(studio.view, speed=intent.factor))


@carry_out.register
def _(intent: intents.Loop, studio: Studio, browser: int) -> None:
    view = replace(studio.view, loop=intent.on, loop_start=intent.start, loop_end=intent.end)
    studio.set_view(view)


@carry_out.register
def _(intent: intents.Select, studio: Studio, browser: int) -> None:
    studio.set_view(replace(studio.view, selection=Selection(intent.kind, intent.name)))


@carry_out.register
def _(intent: intents.Show, studio: Studio, browser: int) -> None:
    studio.set_view(studio.view.with_shown(intent.what, intent.on))
    if intent.what == "collisions":
        studio.workbench.post(commands.ShowCollisions(intent.on))


@carry_out.register
def _(intent: intents.Compare, studio: Studio, browser: int) -> None:
    studio.set_view(replace(studio.view, compare=intent.round))


@carry_out.register
def _(intent: intents.Viewer, studio: Studio, browser: int) -> None:
    studio.tokens[browser] = intent.token


@carry_out.register
def _(intent: intents.Look, studio: Studio, browser: int) -> None:
    target = None
    if intent.view in ("selection", "follow"):
        place = poses_at(studio.snapshot, studio.view.step).get(studio.view.selection.name)
        if place is None:
            raise InputError("select an object first, then look at it")
        target = place[0]
    studio.painter.cameras.look(studio.viewer_of(browser), intent.view, target)


@carry_out.register
def _(intent: intents.Bookmark, studio: Studio, browser: int) -> None:
    cameras, viewer = studio.painter.cameras, studio.viewer_of(browser)
    if intent.keep:
        cameras.keep(viewer, intent.slot)
        studio.say(browser, "info", f"View {intent.slot} kept; press {intent.slot} to come back")
    elif not cameras.recall(viewer, intent.slot):
        studio.say(browser, "info", f"No view {intent.slot} yet; Shift+{intent.slot} keeps one")


# --- the loop ----------------------------------------------------------------------------------


@carry_out.register
def _(intent: intents.StepOn, studio: Studio, browser: int) -> None:
    state = studio.snapshot.state
    if state.outcome == "realised" and state.draft is None:
        studio.say(browser, "info", "The event happens already. Edit something, or overrule it.")
        return
    studio.workbench.post(commands.Run() if intent.all else commands.Step())


@carry_out.register
def _(intent: intents.Cancel, studio: Studio, browser: int) -> None:
    studio.workbench.cancel()


@carry_out.register
def _(intent: intents.DecideOn, studio: Studio, browser: int) -> None:
    head = studio.snapshot.state.current
    if intent.edits and head is not None:
        # Refused here and now, while the person still looks at what was typed.
        apply(head.program, intent.edits)
    studio.workbench.post(
        commands.Decide(
            kind=intent.kind,
            proposal_id=intent.proposal,
            reason=intent.reason,
            hunks=intent.hunks,
            edits=intent.edits,
        )
    )


@carry_out.register
def _(intent: intents.Overrule, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.OverruleVerdict(intent.passed, intent.words))


@carry_out.register
def _(intent: intents.Policy, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.SetPolicy(intent.name))


@carry_out.register
def _(intent: intents.Role, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.TakeRole(intent.name, intent.on))


@carry_out.register
def _(intent: intents.LookInto, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.Probe(intent.what))


@carry_out.register
def _(intent: intents.Budget, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.SetBudget(intent.rounds))


@carry_out.register
def _(intent: intents.PinFact, studio: Studio, browser: int) -> None:
    make = commands.Pin if intent.on else commands.Unpin
    studio.workbench.post(make(intent.path))


@carry_out.register
def _(intent: intents.ShowRound, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.ShowRound(intent.id))


@carry_out.register
def _(intent: intents.Fork, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.ForkFrom(intent.id))


# --- sessions ----------------------------------------------------------------------------------


@carry_out.register
def _(intent: intents.OpenKnown, studio: Studio, browser: int) -> None:
    studio.workbench.post(studio.library.opening(intent.key, intent.event))


@carry_out.register
def _(intent: intents.OpenBare, studio: Studio, browser: int) -> None:
    floor = Support(name="floor", shape=shapes.Floor(), material="concrete", source="person")
    program = PhysicalProgram(scene=shapes.SceneState(supports=(floor,)))
    studio.workbench.post(commands.OpenProgram(program, "Empty scene"))


@carry_out.register
def _(intent: intents.NewCase, studio: Studio, browser: int) -> None:
    path = kept_photo(intent.photo, studio.workbench.store.root / "photos")
    title = textwrap.shorten(intent.prompt, 48, placeholder="…").rstrip(".")
    studio.workbench.post(commands.OpenImage(path, intent.prompt, intent.objects, title))


@carry_out.register
def _(intent: intents.NamesIn, studio: Studio, browser: int) -> None:
    studio.finder.ask(
        browser, "names", intent.ticket, lambda: {"names": list(names_in(intent.prompt))}
    )


@carry_out.register
def _(intent: intents.RenameTo, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.Rename(intent.title))


@carry_out.register
def _(intent: intents.Dismiss, studio: Studio, browser: int) -> None:
    studio.workbench.post(commands.DismissNotice(intent.id))


@carry_out.register
def _(intent: intents.Video, studio: Studio, browser: int) -> None:
    shown = studio.snapshot
    path = output_path(studio.workbench.store, shown.session_id, shown.shown_round, ".mp4")
    width, _, height = intent.size.partition("x")
    size = (int(width), int(height)) if height else None
    studio.workbench.post(commands.Render(path, ClipLook(size, intent.way, intent.shutter)))


@carry_out.register
def _(intent: intents_shelf.Present, studio: Studio, browser: int) -> None:
    if intent.on:
        studio.presenting.add(browser)
    else:
        studio.presenting.discard(browser)


@carry_out.register
def _(intent: intents_shelf.Export, studio: Studio, browser: int) -> None:
    shown = studio.snapshot
    path = output_path(
        studio.workbench.store, shown.session_id, shown.shown_round, f".{intent.kind}"
    )
    if intent.kind == "html":
        studio.workbench.post(commands.Write(path, "The replay", replay_of))
    else:
        studio.workbench.post(commands.Write(path, "The recording", recording_of))


carry_out.register(intents_shelf.RenameSession, shelf.rename)
carry_out.register(intents_shelf.DuplicateSession, shelf.duplicate)
carry_out.register(intents_shelf.DeleteSession, shelf.delete)
carry_out.register(intents_shelf.RestoreSession, shelf.restore)
carry_out.register(intents_shelf.ListSessions, shelf.relist)

OTHERS = photo_actions.ACTIONS | mesh_actions.ACTIONS | program_actions.ACTIONS
OTHERS |= directing.ACTIONS | aloft.ACTIONS | sketch_actions.ACTIONS
for asked, act in OTHERS.items():
    carry_out.register(asked, act)
