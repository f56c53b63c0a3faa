"""Commands: what a person or a program may ask of the workbench, as frozen values.

The bounds of fields hold for what comes from a browser.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, dataclass_transform

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


@dataclass_transform(frozen_default=True)
class Command:
    """Base of all commands: each is a frozen dataclass."""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True)(cls)


class OpenCase(Command):
    """A new session from a case folder; event None takes its first."""

    folder: Path
    event: str | None = None


class OpenImage(Command):
    """A new session from a photo, a sentence, and clicks or a box per object name."""

    path: Path
    prompt: str
    objects: tuple[tuple[str, Grounding], ...]
    title: str | None = None


class OpenProgram(Command):
    """A new session from a program alone, without a photo.

    forms: the stored forms that it names, by asset; see `mesh_edits.forms_beside`.
    """

    program: PhysicalProgram
    title: str = "program"
    forms: Mapping[str, bytes] = field(default_factory=dict)


class OpenSession(Command):
    """Reopens a stored session."""

    id: str


class Advance(Command):
    """Goes on by another policy than the session's, or only until a phase: how one is begun."""

    policy: PolicyName | None = None
    until: str = "done"


class Step(Command):
    """Goes on until a person has to decide or the loop ends; a draft becomes a round first."""


class Run(Command):
    """Goes on until the loop ends, deciding by policy `auto` whatever the session's policy."""


class Decide(Command):
    """A person's decision on the proposal of that id; another id than the current is ignored."""

    kind: DecisionKind
    proposal_id: str
    reason: str = ""
    hunks: tuple[str, ...] = ()
    edits: tuple[Edit, ...] = ()
    author: str = "person"


class ApplyEdits(Command):
    """Hand edits of the program: they go to the draft, which is simulated at once."""

    edits: tuple[Edit, ...]
    reason: str = ""


class Retime(Command):
    """Another time factor for the clip, 0.25 … 4, its schedule kept in seconds, and both numbers
    that hold it pinned: a draft like any hand edit."""

    factor: float


class AddMesh(Command):
    """A new object with the form `body` (body frame, m), set down with its lowest point on `foot`.

    foot: world, m. support: what it stands on there; None for nothing in particular.
    """

    name: str
    body: Mesh
    foot: tuple[float, float, float]
    support: str | None = None


class Wish(Command):
    """The object should be at `position`, world, m, on the step: becomes a proposal."""

    name: str
    position: tuple[float, float, float]
    step: int


class ApplyText(Command):
    """Replaces the program by a YAML text; on a problem nothing changes."""

    text: str


class ValidateText(Command):
    """Checks a YAML text and shows its problems; nothing changes."""

    text: str


class DiscardDraft(Command):
    """Drops the draft; the round's own program is current again."""


class ShowRound(Command):
    """Shows a round read-only; None shows the head."""

    id: Short | None


class ForkFrom(Command):
    """Moves the head to a round; what is decided there makes a new branch."""

    id: Short


class OverruleVerdict(Command):
    """A person's verdict on the head, recorded beside the machine's."""

    passed: bool
    words: Text = ""


class SetPolicy(Command):
    """Who decides from now on."""

    policy: PolicyName


class TakeRole(Command):
    """A person plays this role from now on, or (`on` false) the agent does again."""

    role: RoleName
    on: bool = True


class SetBudget(Command):
    """How many rounds the path may have."""

    rounds: Annotated[int, Field(ge=1, le=100)]


class Pin(Command):
    """The agent never changes this path of the program."""

    path: str


class Unpin(Command):
    """The agent may change this path again."""

    path: str


class Undo(Command):
    """One step back."""


class Redo(Command):
    """One step forward."""


class Probe(Command):
    """Looks into what is on view by running it many times; nothing is changed."""

    what: Looked


class ShowCollisions(Command):
    """Whether snapshots hold what the engine collides."""

    on: bool


class Rename(Command):
    """Gives the session another title."""

    title: Short


class Render(Command):
    """Writes the shown rollout as a video."""

    path: Path
    look: ClipLook = AS_DRAWN


class Write(Command):
    """Writes a file of the session; upper rooms bring the writer, which may be cancelled."""

    path: Path
    what: str
    writer: Writer


class DismissNotice(Command):
    """Removes a notice."""

    id: Annotated[int, Field(ge=0, le=2**53)]
