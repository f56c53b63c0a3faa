"""The loop, the sessions in the list, and files to take away."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from physagent_studio.errors import InputError
from physagent_studio.program import Grounding, PhysicalProgram, Support, apply
from physagent_studio.program.base import Name, Text
from physagent_studio.program.scene import state as shapes
from physagent_studio.records.clip_look import ClipLook
from physagent_studio.records.judgement import DecisionKind
from physagent_studio.studio.commands.asking import (
    Edits,
    FieldPath,
    FileText,
    Id,
    Label,
    Ticket,
    asked,
    posted,
)
from physagent_studio.studio.commands.photo import kept_photo
from physagent_studio.studio.library import output_path
from physagent_studio.studio.replay import recording_of, replay_of
from physagent_studio.workbench import commands
from physagent_studio.workbench.naming import names_in

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio

Title = Annotated[str, Field(min_length=1, max_length=200)]

posted("overrule", commands.OverruleVerdict)
posted("policy", commands.SetPolicy)
posted("role", commands.TakeRole)
posted("budget", commands.SetBudget)
posted("probe", commands.Probe)
posted("round", commands.ShowRound, "look")
posted("fork", commands.ForkFrom)
posted("rename", commands.Rename)
posted("dismiss", commands.DismissNotice, "look")
posted("discard", commands.DiscardDraft)


@asked("step")
def step(studio: Studio, browser: int, all: bool = False) -> None:
    """Goes on to the next decision, or (`all`) to the end."""
    state = studio.snapshot.state
    if state.outcome == "realised" and state.draft is None:
        studio.say(browser, "info", "The event happens already. Edit something, or overrule it.")
        return
    studio.workbench.post(commands.Run() if all else commands.Step())


@asked("cancel")
def cancel(studio: Studio, browser: int) -> None:
    """Stops what is happening now."""
    studio.workbench.cancel()


@asked("decide")
def decide(
    studio: Studio,
    browser: int,
    kind: DecisionKind,
    proposal: Id,
    reason: Text = "",
    hunks: Annotated[tuple[Id, ...], Field(max_length=500)] = (),
    edits: Edits = (),
) -> None:
    """A decision on the proposal of that id."""
    head = studio.snapshot.state.current
    if edits and head is not None:
        # Refused here and now, while the person still looks at what was typed.
        apply(head.program, edits)
    studio.workbench.post(commands.Decide(kind, proposal, reason, hunks, edits))


@asked("pin")
def pin(studio: Studio, browser: int, path: FieldPath, on: bool) -> None:
    """The agent never changes this path, or (`on` false) may again."""
    studio.workbench.post((commands.Pin if on else commands.Unpin)(path))


# --- sessions ------------------------------------------------------------------------------------


@asked("open")
def open_known(studio: Studio, browser: int, key: Id, event: Label = "") -> None:
    """Opens one of the cases or sessions that the server has offered, by its key."""
    studio.workbench.post(studio.library.opening(key, event))


@asked("bare")
def open_bare(studio: Studio, browser: int) -> None:
    """A new session without a photo."""
    floor = Support(name="floor", shape=shapes.Floor(), material="concrete", source="person")
    program = PhysicalProgram(scene=shapes.SceneState(supports=(floor,)))
    studio.workbench.post(commands.OpenProgram(program, "Empty scene"))


@asked("new")
def new(
    studio: Studio,
    browser: int,
    photo: FileText,
    prompt: Annotated[str, Field(min_length=1, max_length=4000)],
    objects: Annotated[tuple[tuple[Name, Grounding], ...], Field(max_length=100)],
) -> None:
    """A new session from a photo (base64 of the file), a sentence, and boxes or clicks per thing.

    Without objects, what the sentence names is looked for.
    """
    path = kept_photo(photo, studio.workbench.store.root / "photos")
    title = textwrap.shorten(prompt, 48, placeholder="…").rstrip(".")
    studio.workbench.post(commands.OpenImage(path, prompt, objects, title))


@asked("names")
def find_names(
    studio: Studio,
    browser: int,
    prompt: Annotated[str, Field(max_length=4000)],
    ticket: Ticket,
) -> None:
    """Which things a sentence names; nothing is changed."""
    studio.finder.ask(browser, "names", ticket, lambda: {"names": list(names_in(prompt))})


@asked("rename_session")
def rename(studio: Studio, browser: int, key: Id, title: Title) -> None:
    """Gives a listed session another title: the open one is the worker's, another is nobody's."""
    name, title = studio.library.session_of(key), title.strip()
    if not title:
        raise InputError("a title has 1 to 200 characters")
    if name == studio.snapshot.session_id:
        studio.workbench.post(commands.Rename(title))
    else:
        with studio.workbench.store.open(name) as session:
            session.rename(title)
    relist(studio, browser)


@asked("duplicate_session")
def duplicate(studio: Studio, browser: int, key: Id) -> None:
    """Copies a listed session, beside it under the same title with a number behind."""
    store = studio.workbench.store
    name = studio.library.session_of(key)
    titles = {one.title for one in store.list()}
    with store.open(store.duplicate(name)) as copy:
        stem, number = copy.title[:190], 2
        while (title := f"{stem} ({number})") in titles:
            number += 1
        copy.rename(title)
    relist(studio, browser)
    studio.say(browser, "info", f"Copied as “{title}”")


@asked("delete_session")
def delete(studio: Studio, browser: int, key: Id) -> None:
    """Takes a session off the list for a week in which it can be brought back.

    Never the open one: what somebody looks at does not vanish under their hands.
    """
    name = studio.library.session_of(key)
    if name == studio.snapshot.session_id:
        raise InputError("this session is open; open another one first, then delete it")
    title = next((one.title for one in studio.workbench.store.list() if one.id == name), name)
    studio.workbench.store.discard(name)
    relist(studio, browser)
    back = {"do": "restore_session", "key": f"session:{name}"}
    studio.say(browser, "info", f"“{title}” was deleted", ("Undo", back))


@asked("restore_session")
def restore(studio: Studio, browser: int, key: Id) -> None:
    """Brings a deleted session back."""
    studio.workbench.store.restore(key.removeprefix("session:"))
    relist(studio, browser)


@asked("list_sessions", "look")
def relist(studio: Studio, browser: int) -> None:
    """Tells all pages which sessions there are now; the command line makes some too."""
    studio.library.forget()
    studio.painter.publish_library(studio.library.listing(studio.snapshot))


# --- files ---------------------------------------------------------------------------------------


@asked("video")
def video(
    studio: Studio,
    browser: int,
    size: Literal["", "832x480", "480x832", "720x480", "1280x720"] = "",
    way: Literal["crop", "letterbox"] = "crop",
    shutter: Annotated[float, Field(ge=0, le=1)] = 0.0,
) -> None:
    """Writes the shown clip as a video file, in the photo's size or another."""
    shown = studio.snapshot
    path = output_path(studio.workbench.store, shown.session_id, shown.shown_round, ".mp4")
    width, _, height = size.partition("x")
    wanted = (int(width), int(height)) if height else None
    studio.workbench.post(commands.Render(path, ClipLook(wanted, way, shutter)))


@asked("export")
def export(studio: Studio, browser: int, kind: Literal["html", "viser"]) -> None:
    """Writes the session as one HTML file, or the scene as a recording for viser."""
    shown = studio.snapshot
    path = output_path(studio.workbench.store, shown.session_id, shown.shown_round, f".{kind}")
    what, writer = ("The replay", replay_of) if kind == "html" else ("The recording", recording_of)
    studio.workbench.post(commands.Write(path, what, writer))
