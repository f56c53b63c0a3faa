"""Everything that a browser may ask for, as closed and bounded models: the studio's only door in.

Whatever arrives is text from a stranger. `read_intent` gives a frozen value whose every number is
finite and inside its bounds, or an `InputError` with a sentence.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal, NoReturn

from pydantic import Field, JsonValue, TypeAdapter, ValidationError

from physagent_studio.errors import InputError
from physagent_studio.program import Edit, Frozen
from physagent_studio.program.base import Name, Text
from physagent_studio.program.scene.state import Grounding
from physagent_studio.program.timing import FASTEST, SLOWEST
from physagent_studio.records.judgement import DecisionKind
from physagent_studio.records.loop_state import PolicyName, RoleName
from physagent_studio.studio.intents.aloft import AloftIntent
from physagent_studio.studio.intents.directing import DirectingIntent, Hide, Measure
from physagent_studio.studio.intents.mesh import MeshIntent
from physagent_studio.studio.intents.photo import PhotoIntent, Ticket
from physagent_studio.studio.intents.shelf import ListSessions, Present, ShelfIntent
from physagent_studio.workbench.probing import Looked

Id = Annotated[str, Field(min_length=1, max_length=200)]
Label = Annotated[str, Field(max_length=200)]
Frame = Annotated[int, Field(ge=0, le=10_000)]
Edits = Annotated[tuple[Edit, ...], Field(max_length=1000)]
Coordinate = Annotated[float, Field(ge=-1e5, le=1e5)]
Vector = tuple[Coordinate, Coordinate, Coordinate]

ViewOption = Literal[
    "photo", "supports", "frustum", "gravity", "axes", "labels", "trails", "ghosts", "contacts",
    "forces", "centres", "collisions", "gizmo",
]  # fmt: skip


# --- the playhead and what is looked at --------------------------------------------------------


class Play(Frozen):
    """Plays, or pauses; `once` plays from the start to the end and stops there."""

    do: Literal["play"] = "play"
    on: bool | None = None
    once: bool = False


class Scrub(Frozen):
    """Puts the playhead on a frame; a burst of these comes down to the last one."""

    do: Literal["scrub"] = "scrub"
    frame: Frame


class Speed(Frozen):
    """Playback speed, 1 is as the clip is shown."""

    do: Literal["speed"] = "speed"
    factor: Annotated[float, Field(ge=0.05, le=8)]


class Loop(Frozen):
    """Repeats the clip, or the frames from `start` to `end`."""

    do: Literal["loop"] = "loop"
    on: bool
    start: Frame | None = None
    end: Frame | None = None


class Select(Frozen):
    """Selects a thing in all views at once."""

    do: Literal["select"] = "select"
    kind: Literal["object", "support", "landmark", "action", "statement", "camera", "clip", "none"]
    name: Label = ""


class Show(Frozen):
    """Shows or hides something in the scene."""

    do: Literal["show"] = "show"
    what: ViewOption
    on: bool


class Look(Frozen):
    """Moves this browser's camera; `follow` keeps it on the selected object."""

    do: Literal["look"] = "look"
    view: Literal["photo", "top", "side", "front", "selection", "follow"]


class Bookmark(Frozen):
    """Keeps this browser's camera under a number, or goes back to it."""

    do: Literal["bookmark"] = "bookmark"
    slot: Annotated[int, Field(ge=1, le=9)]
    keep: bool = False


class Viewer(Frozen):
    """Which 3D view belongs to the page that speaks."""

    do: Literal["viewer"] = "viewer"
    token: Annotated[str, Field(pattern=r"^[0-9a-f]{8,64}$")]


class Compare(Frozen):
    """Compares the shown round with another; None ends it."""

    do: Literal["compare"] = "compare"
    round: Id | None = None


# --- the loop ----------------------------------------------------------------------------------


class StepOn(Frozen):
    """Goes on to the next decision, or (`all`) to the end."""

    do: Literal["step"] = "step"
    all: bool = False


class Cancel(Frozen):
    """Stops what is happening now."""

    do: Literal["cancel"] = "cancel"


class DecideOn(Frozen):
    """A decision on the proposal of that id."""

    do: Literal["decide"] = "decide"
    kind: DecisionKind
    proposal: Id
    reason: Text = ""
    hunks: Annotated[tuple[Id, ...], Field(max_length=500)] = ()
    edits: Edits = ()


class Overrule(Frozen):
    """A person's verdict."""

    do: Literal["overrule"] = "overrule"
    passed: bool
    words: Text = ""


class Policy(Frozen):
    """Who decides from now on."""

    do: Literal["policy"] = "policy"
    name: PolicyName


class Role(Frozen):
    """A person plays this role from now on, or (`on` false) no longer."""

    do: Literal["role"] = "role"
    name: RoleName
    on: bool


class LookInto(Frozen):
    """Runs what is on view many times, to say how sturdy it is or what brought it about."""

    do: Literal["probe"] = "probe"
    what: Looked


class Budget(Frozen):
    """How many rounds there may be."""

    do: Literal["budget"] = "budget"
    rounds: Annotated[int, Field(ge=1, le=100)]


class PinFact(Frozen):
    """The agent never changes this path, or (`on` false) may again."""

    do: Literal["pin"] = "pin"
    path: Annotated[str, Field(min_length=1, max_length=500)]
    on: bool


class ShowRound(Frozen):
    """Opens a round read-only; None goes back to the current one."""

    do: Literal["round"] = "round"
    id: Id | None


class Fork(Frozen):
    """Goes on from an earlier round; a new branch."""

    do: Literal["fork"] = "fork"
    id: Id


# --- the program -------------------------------------------------------------------------------


class Change(Frozen):
    """Hand edits. `ticket` comes back with the answer, so that the page can undo what it drew."""

    do: Literal["edit"] = "edit"
    edits: Edits
    reason: Text = ""
    ticket: Annotated[int, Field(ge=0, le=2**53)] | None = None


class Remove(Frozen):
    """Deletes the item at a path, and what speaks of it."""

    do: Literal["remove"] = "remove"
    path: Annotated[str, Field(min_length=1, max_length=500)]


class Try(Frozen):
    """Edits that are still under the pointer: run and shown, not kept; None ends it."""

    do: Literal["try"] = "try"
    edits: Edits | None


class Wish(Frozen):
    """A thing should be at a place now (or at `frame`); the agent proposes what brings it there."""

    do: Literal["wish"] = "wish"
    name: Name
    position: Vector
    frame: Frame | None = None


class Retime(Frozen):
    """Another time factor for the clip, which is pinned; see `program.timing`."""

    do: Literal["retime"] = "retime"
    factor: Annotated[float, Field(ge=SLOWEST, le=FASTEST)]
    ticket: Annotated[int, Field(ge=0, le=2**53)] | None = None


class WriteText(Frozen):
    """The program as text: only looked at, or applied."""

    do: Literal["text"] = "text"
    text: Annotated[str, Field(max_length=4_000_000)]
    apply: bool = False


class DropDraft(Frozen):
    """Throws the draft away."""

    do: Literal["discard"] = "discard"


class Undo(Frozen):
    """One step back, or (`forward`) one forward again."""

    do: Literal["undo"] = "undo"
    forward: bool = False


# --- sessions ----------------------------------------------------------------------------------


class OpenKnown(Frozen):
    """Opens one of the cases or sessions that the server has offered, by its key."""

    do: Literal["open"] = "open"
    key: Id
    event: Label = ""


class OpenBare(Frozen):
    """A new session without a photo."""

    do: Literal["bare"] = "bare"


class NamesIn(Frozen):
    """Which things a sentence names; nothing is changed."""

    do: Literal["names"] = "names"
    prompt: Annotated[str, Field(max_length=4000)]
    ticket: Ticket


class NewCase(Frozen):
    """A new session from a photo (base64 of the file), a sentence, and boxes or clicks per thing.

    Without objects, what the sentence names is looked for.
    """

    do: Literal["new"] = "new"
    photo: Annotated[str, Field(max_length=23_000_000)]
    prompt: Annotated[str, Field(min_length=1, max_length=4000)]
    objects: Annotated[tuple[tuple[Name, Grounding], ...], Field(max_length=100)]


class RenameTo(Frozen):
    """Gives the session another title."""

    do: Literal["rename"] = "rename"
    title: Annotated[str, Field(min_length=1, max_length=200)]


class Dismiss(Frozen):
    """Removes a notice."""

    do: Literal["dismiss"] = "dismiss"
    id: Annotated[int, Field(ge=0, le=2**53)]


class Video(Frozen):
    """Writes the shown clip as a video file, in the photo's size or another."""

    do: Literal["video"] = "video"
    size: Literal["", "832x480", "480x832", "720x480", "1280x720"] = ""
    way: Literal["crop", "letterbox"] = "crop"
    shutter: Annotated[float, Field(ge=0, le=1)] = 0.0


Intent = Annotated[
    Play | Scrub | Speed | Loop | Select | Show | Look | Bookmark | Viewer | Compare
    | StepOn | Cancel | DecideOn | Overrule | Policy | Role | LookInto | Budget | PinFact
    | ShowRound | Fork
    | Change | Remove | Try | Wish | Retime | WriteText | DropDraft | Undo
    | OpenKnown | OpenBare | NamesIn | NewCase | RenameTo | Dismiss | Video | ShelfIntent
    | PhotoIntent | MeshIntent | DirectingIntent | AloftIntent,
    Field(discriminator="do"),
]  # fmt: skip

LOOKING = (
    Play, Scrub, Speed, Loop, Select, Show, Look, Bookmark, Viewer, Compare, ShowRound, Dismiss,
    ListSessions, Present, Measure, Hide,
)  # fmt: skip
"""What a page that presents may ask for: nothing of it changes a session."""

WATCHING = (Viewer, Look, Bookmark)
"""What somebody may ask for who only watches: nothing that any other page would see."""

_ADAPTER: TypeAdapter[Any] = TypeAdapter(Intent)


def read_intent(text: str) -> Any:
    """The intent that a browser's message holds.

    Raises:
        InputError: it is no JSON, not finite, out of bounds, or nothing that may be asked for.
    """
    return read_letter(text)[0]


def read_letter(text: str) -> tuple[Any, int | None]:
    """The intent in a browser's message, and the version of the document that it was made against.

    Raises what `read_intent` raises.
    """
    try:
        data: JsonValue = _DECODER.decode(text)
        seen = data.pop("seen", None) if isinstance(data, dict) else None
        return _ADAPTER.validate_python(data), seen if type(seen) is int else None
    except ValidationError as error:
        raise InputError(_sentence(error)) from error
    except (ValueError, RecursionError) as error:
        raise InputError("the page sent something that is not JSON") from error


def _refuse_constant(name: str) -> NoReturn:
    raise InputError(f"{name} is not a number that can be used; give a finite number")


_DECODER = json.JSONDecoder(parse_constant=_refuse_constant)
"""One for all messages: a new one for each leaves names behind in the interpreter's own cache."""


def _sentence(error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    if first["type"] == "union_tag_invalid" and len(first["loc"]) < 2:
        return f"nothing here does '{str(first.get('ctx', {}).get('tag', ''))[:80]}'"
    where = ".".join(str(part) for part in first["loc"][1:])
    text = first["msg"].removeprefix("Value error, ")
    return f"{where}: {text[0].lower()}{text[1:]}" if where else text
