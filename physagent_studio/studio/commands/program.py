"""What is asked of the program: edits by hand, tries, wishes, text, undo."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from physagent_studio.errors import EditError, InputError, ProgramError, StudioError
from physagent_studio.program import Edit, PhysicalProgram, RemoveItem, SetField, apply
from physagent_studio.program.base import Name, Text
from physagent_studio.program.timing import FASTEST, SLOWEST, retimed
from physagent_studio.studio.commands.asking import Edits, FieldPath, Frame, Ticket, Vector, asked
from physagent_studio.workbench import commands

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio

LISTS = ("event.actions", "contract.statements", "scene.landmarks")
"""Lists whose items are of no use without what they speak of."""
ROUNDS = 20
"""How often something else may turn out to speak of what goes."""
Pace = Annotated[float, Field(ge=SLOWEST, le=FASTEST)]


def open_program(studio: Studio) -> PhysicalProgram:
    """The program on view, where it may be edited."""
    if studio.snapshot.read_only:
        raise InputError("an earlier round is open read-only; go on from here to edit it")
    return studio.snapshot.program


def carry(studio: Studio, edits: tuple[Edit, ...], reason: str, *, keep: bool) -> None:
    """Makes an edit, or under the pointer only tries it."""
    if keep:
        studio.workbench.post(commands.ApplyEdits(edits, reason))
    else:
        studio.workbench.try_out(edits)


@asked("edit")
def change(
    studio: Studio, browser: int, edits: Edits, reason: Text = "", ticket: Ticket | None = None
) -> None:
    """Hand edits: checked here, carried out by the worker.

    ticket: comes back with the answer, so that the page can undo what it drew.
    """
    try:
        apply(open_program(studio), edits)
    except StudioError as error:
        studio.workbench.try_out(None)
        studio.answer(browser, ticket, str(error))
        raise
    studio.workbench.post(commands.ApplyEdits(edits, reason))
    studio.answer(browser, ticket, None)


@asked("retime")
def retime(studio: Studio, browser: int, factor: Pace, ticket: Ticket | None = None) -> None:
    """Slow motion or time lapse, as one hand edit; the pace is pinned with it."""
    try:
        apply(open_program(studio), retimed(studio.snapshot.program, factor))
    except StudioError as error:
        studio.answer(browser, ticket, str(error))
        raise
    studio.workbench.post(commands.Retime(factor))
    studio.answer(browser, ticket, None)


@asked("try")
def try_out(studio: Studio, browser: int, edits: Edits | None) -> None:
    """Shows what edits under the pointer would make, and keeps nothing; None ends it."""
    if not studio.snapshot.read_only:
        studio.workbench.try_out(edits)


@asked("wish")
def wish(
    studio: Studio, browser: int, name: Name, position: Vector, frame: Frame | None = None
) -> None:
    """A thing should be at a place now (or at `frame`); the agent proposes what brings it there."""
    clip, step = studio.snapshot.program.clip, studio.view.step
    if frame is not None:
        step = min(frame, clip.frames - 1) * clip.steps_per_frame
    if step == 0:
        raise InputError("at the beginning a thing is where you put it: move it there")
    studio.workbench.post(commands.Wish(name, position, step))


@asked("text")
def write_text(
    studio: Studio,
    browser: int,
    text: Annotated[str, Field(max_length=4_000_000)],
    apply: bool = False,
) -> None:
    """The program as text: only looked at, or applied."""
    studio.workbench.post((commands.ApplyText if apply else commands.ValidateText)(text))


@asked("undo")
def undo(studio: Studio, browser: int, forward: bool = False) -> None:
    """One step back, or (`forward`) one forward again."""
    studio.workbench.post(commands.Redo() if forward else commands.Undo())


# --- deleting ------------------------------------------------------------------------------------


@asked("remove")
def remove(studio: Studio, browser: int, path: FieldPath) -> None:
    """Deletes the item at a path, and what speaks of it."""
    edits = removing(open_program(studio), path)
    studio.workbench.post(commands.ApplyEdits(edits, "removed"))
    if len(edits) > 1:
        names = ", ".join(edit.path.split(".")[2].replace("_", " ") for edit in edits[:-1])
        text = f"Deleted, and with it what spoke of it: {names}"
        studio.say(browser, "info", text, ("Undo", {"do": "undo"}))


def removing(program: PhysicalProgram, path: str) -> tuple[Edit, ...]:
    """The edits that delete the item at a path, and before it what would speak of nothing.

    An object that stood on it then stands where it is. Raises ProgramError where the item cannot
    be deleted for another reason.
    """
    edits: list[Edit] = [RemoveItem(path=path)]
    for _ in range(ROUNDS):
        try:
            apply(program, edits)
        except EditError:
            raise
        except ProgramError as error:
            more = [edit for one in error.problems if (edit := _without(one.path, program))]
            fresh = [edit for edit in dict.fromkeys(more) if edit not in edits]
            if not fresh:
                raise
            edits = [*fresh, *edits]
        else:
            break
    return tuple(edits)


def _without(path: str, program: PhysicalProgram) -> Edit | None:
    """The edit that takes back what a problem at a path is about."""
    for listed in LISTS:
        if path.startswith(listed + "."):
            name = path.removeprefix(listed + ".").partition(".")[0]
            return RemoveItem(path=f"{listed}.{name}")
    if path.startswith("scene.objects.") and path.endswith(".support"):
        name = path.split(".")[2]
        return SetField(path=path, value=None) if program.scene.object(name) else None
    return None
