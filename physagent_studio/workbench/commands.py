"""Commands: what a person or a program may ask of the workbench, as frozen values.

The bounds of fields hold for what comes from a browser.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from physagent_studio.program import Edit, Grounding, PhysicalProgram
from physagent_studio.program.base import Text
from physagent_studio.records import Mesh
from physagent_studio.records.clip_look import AS_DRAWN, ClipLook
from physagent_studio.records.judgement import DecisionKind
from physagent_studio.records.loop_state import PolicyName, RoleName
from physagent_studio.workbench.probing import Looked

if TYPE_CHECKING:
    from physagent_studio.workbench.desk import Desk

Short = Annotated[str, Field(min_length=1, max_length=200)]
Writer = Callable[["Desk"], bytes]
"""Makes the bytes of a file from the open session."""


@dataclass(frozen=True, slots=True)
class OpenCase:
    """A new session from a case folder; event None takes its first."""

    folder: Path
    event: str | None = None


@dataclass(frozen=True, slots=True)
class OpenImage:
    """A new session from a photo, a sentence, and clicks or a box per object name."""

    path: Path
    prompt: str
    objects: tuple[tuple[str, Grounding], ...]
    title: str | None = None


@dataclass(frozen=True, slots=True)
class OpenProgram:
    """A new session from a program alone, without a photo.

    forms: the stored forms that it names, by asset; see `mesh_edits.forms_beside`.
    """

    program: PhysicalProgram
    title: str = "program"
    forms: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class OpenSession:
    """Reopens a stored session."""

    id: str


@dataclass(frozen=True, slots=True)
class Advance:
    """Goes on by another policy than the session's, or only until a phase: how one is begun."""

    policy: PolicyName | None = None
    until: str = "done"


@dataclass(frozen=True, slots=True)
class Step:
    """Goes on until a person has to decide or the loop ends; a draft becomes a round first."""


@dataclass(frozen=True, slots=True)
class Run:
    """Goes on until the loop ends, deciding by policy `auto` whatever the session's policy."""


@dataclass(frozen=True, slots=True)
class Decide:
    """A person's decision on the proposal of that id; another id than the current is ignored."""

    kind: DecisionKind
    proposal_id: str
    reason: str = ""
    hunks: tuple[str, ...] = ()
    edits: tuple[Edit, ...] = ()
    author: str = "person"


@dataclass(frozen=True, slots=True)
class ApplyEdits:
    """Hand edits of the program: they go to the draft, which is simulated at once."""

    edits: tuple[Edit, ...]
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Retime:
    """Another time factor for the clip, 0.25 … 4, its schedule kept in seconds, and both numbers
    that hold it pinned: a draft like any hand edit."""

    factor: float


@dataclass(frozen=True, eq=False, slots=True)
class AddMesh:
    """A new object with the form `body` (body frame, m), set down with its lowest point on `foot`.

    foot: world, m. support: what it stands on there; None for nothing in particular.
    """

    name: str
    body: Mesh
    foot: tuple[float, float, float]
    support: str | None = None


@dataclass(frozen=True, slots=True)
class Wish:
    """The object should be at `position`, world, m, on the step: becomes a proposal."""

    name: str
    position: tuple[float, float, float]
    step: int


@dataclass(frozen=True, slots=True)
class ApplyText:
    """Replaces the program by a YAML text; on a problem nothing changes."""

    text: str


@dataclass(frozen=True, slots=True)
class ValidateText:
    """Checks a YAML text and shows its problems; nothing changes."""

    text: str


@dataclass(frozen=True, slots=True)
class DiscardDraft:
    """Drops the draft; the round's own program is current again."""


@dataclass(frozen=True, slots=True)
class ShowRound:
    """Shows a round read-only; None shows the head."""

    id: Short | None


@dataclass(frozen=True, slots=True)
class ForkFrom:
    """Moves the head to a round; what is decided there makes a new branch."""

    id: Short


@dataclass(frozen=True, slots=True)
class OverruleVerdict:
    """A person's verdict on the head, recorded beside the machine's."""

    passed: bool
    words: Text = ""


@dataclass(frozen=True, slots=True)
class SetPolicy:
    """Who decides from now on."""

    policy: PolicyName


@dataclass(frozen=True, slots=True)
class TakeRole:
    """A person plays this role from now on, or (`on` false) the agent does again."""

    role: RoleName
    on: bool = True


@dataclass(frozen=True, slots=True)
class SetBudget:
    """How many rounds the path may have."""

    rounds: Annotated[int, Field(ge=1, le=100)]


@dataclass(frozen=True, slots=True)
class Pin:
    """The agent never changes this path of the program."""

    path: str


@dataclass(frozen=True, slots=True)
class Unpin:
    """The agent may change this path again."""

    path: str


@dataclass(frozen=True, slots=True)
class Undo:
    """One step back."""


@dataclass(frozen=True, slots=True)
class Redo:
    """One step forward."""


@dataclass(frozen=True, slots=True)
class Probe:
    """Looks into what is on view by running it many times; nothing is changed."""

    what: Looked


@dataclass(frozen=True, slots=True)
class ShowCollisions:
    """Whether snapshots hold what the engine collides."""

    on: bool


@dataclass(frozen=True, slots=True)
class Rename:
    """Gives the session another title."""

    title: Short


@dataclass(frozen=True, slots=True)
class Render:
    """Writes the shown rollout as a video."""

    path: Path
    look: ClipLook = AS_DRAWN


@dataclass(frozen=True, slots=True)
class Write:
    """Writes a file of the session; upper rooms bring the writer, which may be cancelled."""

    path: Path
    what: str
    writer: Writer


@dataclass(frozen=True, slots=True)
class DismissNotice:
    """Removes a notice."""

    id: Annotated[int, Field(ge=0, le=2**53)]


Command = (
    OpenCase
    | OpenImage
    | OpenProgram
    | OpenSession
    | Advance
    | Step
    | Run
    | Decide
    | ApplyEdits
    | Retime
    | AddMesh
    | Wish
    | ApplyText
    | ValidateText
    | DiscardDraft
    | ShowRound
    | ForkFrom
    | OverruleVerdict
    | SetPolicy
    | TakeRole
    | SetBudget
    | Pin
    | Unpin
    | Undo
    | Redo
    | Probe
    | ShowCollisions
    | Rename
    | Render
    | Write
    | DismissNotice
)
