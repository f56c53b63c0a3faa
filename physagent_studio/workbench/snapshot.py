"""`Snapshot`: the frozen picture of the workbench that views draw from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Literal

from physagent_studio.errors import Problem
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Case, Check, LoopState, Mesh, Rollout, Scene
from physagent_studio.workbench.meter import Spending
from physagent_studio.workbench.probing import Probed


@dataclass(frozen=True, slots=True)
class Notice:
    """Something a person should know; error and warning stay until dismissed."""

    id: int
    level: Literal["info", "warning", "error"]
    text: str


@dataclass(frozen=True, eq=False, slots=True)
class Attempt:
    """What an edit that is still under the pointer would make; nothing of it is stored.

    problem: why it cannot be, then there is no rollout.
    """

    program: PhysicalProgram | None = None
    rollout: Rollout | None = None
    checks: tuple[Check, ...] = ()
    problem: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class Snapshot:
    """All that a view needs.

    program: the draft if there is one, else that of the shown round. rollout, checks: of the
    same. preview_rollout: of the head's proposal, for a ghost; None while another round is
    shown. shown_round: id of the round on view; read_only: it is not the head. busy: what is
    happening now, in words, None at rest. progress: 0 … 1 of it, None where unknown.
    revision: grows with every change. attempt: while something is dragged, what would come of it.
    collisions: outlines of what the engine collides by name, of objects in the body frame, of
    supports in the world; None where nobody asked for them. version: of the document, which
    commands carry. locked: why nothing of the session can be changed here, "" where it can.
    probed: what was found by running the program on view many times, where somebody asked.
    """

    revision: int
    session_id: str | None = None
    title: str = ""
    case: Case | None = None
    state: LoopState = field(default_factory=LoopState)
    program: PhysicalProgram = field(default_factory=PhysicalProgram)
    scene: Scene | None = None
    rollout: Rollout | None = None
    checks: tuple[Check, ...] = ()
    preview_rollout: Rollout | None = None
    shown_round: str | None = None
    read_only: bool = False
    has_draft: bool = False
    yaml_text: str = ""
    yaml_problems: tuple[Problem, ...] = ()
    busy: str | None = None
    progress: float | None = None
    notices: tuple[Notice, ...] = ()
    can_undo: bool = False
    can_redo: bool = False
    spending: Spending = field(default_factory=Spending)
    version: int = 0
    locked: str = ""
    attempt: Attempt | None = None
    collisions: Mapping[str, tuple[Mesh, ...]] | None = None
    probed: Probed | None = None


def differ_by_attempt(old: Snapshot, new: Snapshot) -> bool:
    """Whether nothing but what is being tried has changed, so that little has to be drawn."""
    names = {one.name for one in fields(Snapshot)} - {"revision", "attempt"}
    same = all(getattr(old, name) is getattr(new, name) for name in names)
    return same and old.attempt is not new.attempt
