"""What is asked of the program: edits by hand, tries, wishes, text, undo."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from physagent_studio.errors import InputError, StudioError
from physagent_studio.program import apply
from physagent_studio.program.timing import retimed
from physagent_studio.studio.commands.removing import removing
from physagent_studio.studio.intents import every as intents
from physagent_studio.workbench import commands

if TYPE_CHECKING:
    from physagent_studio.studio.commands.actions import Studio


def change(intent: intents.Change, studio: Studio, browser: int) -> None:
    """Hand edits: checked here, carried out by the worker."""
    try:
        if studio.snapshot.read_only:
            raise InputError("an earlier round is open read-only; go on from here to edit it")
        apply(studio.snapshot.program, intent.edits)
    except StudioError as error:
        studio.workbench.try_out(None)
        studio.answer(browser, intent.ticket, str(error))
        raise
    studio.workbench.post(commands.ApplyEdits(intent.edits, intent.reason))
    studio.answer(browser, intent.ticket, None)


def remove(intent: intents.Remove, studio: Studio, browser: int) -> None:
    """Deletes an item and what speaks of it."""
    if studio.snapshot.read_only:
        raise InputError("an earlier round is open read-only; go on from here to edit it")
    edits = removing(studio.snapshot.program, intent.path)
    studio.workbench.post(commands.ApplyEdits(edits, "removed"))
    if len(edits) > 1:
        names = ", ".join(edit.path.split(".")[2].replace("_", " ") for edit in edits[:-1])
        text = f"Deleted, and with it what spoke of it: {names}"
        studio.say(browser, "info", text, ("Undo", {"do": "undo"}))


def try_out(intent: intents.Try, studio: Studio, browser: int) -> None:
    """Shows what edits under the pointer would make."""
    if not studio.snapshot.read_only:
        studio.workbench.try_out(intent.edits)


def wish(intent: intents.Wish, studio: Studio, browser: int) -> None:
    """A thing should be elsewhere: the agent proposes how."""
    clip, step = studio.snapshot.program.clip, studio.view.step
    if intent.frame is not None:
        step = min(intent.frame, clip.frames - 1) * clip.steps_per_frame
    if step == 0:
        raise InputError("at the beginning a thing is where you put it: move it there")
    studio.workbench.post(commands.Wish(intent.name, intent.position, step))


def retime(intent: intents.Retime, studio: Studio, browser: int) -> None:
    """Slow motion or time lapse, as one hand edit; the pace is pinned with it."""
    try:
        if studio.snapshot.read_only:
            raise InputError("an earlier round is open read-only; go on from here to edit it")
        apply(studio.snapshot.program, retimed(studio.snapshot.program, intent.factor))
    except StudioError as error:
        studio.answer(browser, intent.ticket, str(error))
        raise
    studio.workbench.post(commands.Retime(intent.factor))
    studio.answer(browser, intent.ticket, None)


def write_text(intent: intents.WriteText, studio: Studio, browser: int) -> None:
    """The program as text, looked at or applied."""
    make = commands.ApplyText if intent.apply else commands.ValidateText
    studio.workbench.post(make(intent.text))


def drop_draft(intent: intents.DropDraft, studio: Studio, browser: int) -> None:
    """Throws the draft away."""
    studio.workbench.post(commands.DiscardDraft())


def undo(intent: intents.Undo, studio: Studio, browser: int) -> None:
    """One step back or forward."""
    studio.workbench.post(commands.Redo() if intent.forward else commands.Undo())


ACTIONS: dict[type, Callable[..., None]] = {
    intents.Change: change,
    intents.Remove: remove,
    intents.Try: try_out,
    intents.Wish: wish,
    intents.Retime: retime,
    intents.WriteText: write_text,
    intents.DropDraft: drop_draft,
    intents.Undo: undo,
}
"""What each intent does."""
