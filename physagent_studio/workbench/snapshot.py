"""`Snapshot`: the frozen picture of the workbench that views draw from; what a session costs."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Literal

from physagent_studio.agent.vlm import CallRecord, Ledger, Limits
from physagent_studio.errors import Problem
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Case, Check, LoopState, Mesh, Rollout, Scene
from physagent_studio.session import Session
from physagent_studio.workbench.probing import Probed

WORKED = "worked_seconds"


@dataclass(frozen=True, slots=True)
class Spending:
    """seconds: of work, waiting for the model included. waited: s of these for the model.

    calls, tokens, money: of the model, with the limits that stop it; None without a limit.
    money is in the currency of the configured prices; 0 without prices.
    """

    seconds: float = 0.0
    waited: float = 0.0
    calls: int = 0
    tokens: int = 0
    money: float = 0.0
    most_calls: int | None = None
    most_tokens: int | None = None
    most_money: float | None = None


class Meter:
    """Adds up one session; reads only what has come to its log since the last reading."""

    def __init__(self, session: Session, limits: Limits | None = None) -> None:
        self._session = session
        self._ledger = Ledger(limits or Limits())
        self._limited = limits is not None
        self._seen = 0
        self._waited = 0.0

    def add_work(self, seconds: float) -> None:
        """Counts time of work, for good."""
        self._session.note(WORKED, f"{self._worked() + seconds:.3f}")

    def read(self) -> Spending:
        """Everything up to now."""
        for number, payload in self._session.log_after(self._seen, "model call"):
            call = CallRecord.model_validate(payload)
            self._ledger.add(call)
            self._waited += 0.0 if call.outcome == "replayed" else call.seconds
            self._seen = number
        ledger, limits = self._ledger, self._ledger.limits
        return Spending(
            seconds=self._worked(),
            waited=self._waited,
            calls=ledger.calls,
            tokens=ledger.tokens,
            money=ledger.money,
            most_calls=limits.calls if self._limited else None,
            most_tokens=limits.tokens if self._limited else None,
            most_money=limits.money if self._limited else None,
        )

    def _worked(self) -> float:
        return float(self._session.meta(WORKED) or 0.0)


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
    commands carry.
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
    yaml_problems: tuple[Problem, ...] = ()
    busy: str | None = None
    progress: float | None = None
    notices: tuple[Notice, ...] = ()
    can_undo: bool = False
    can_redo: bool = False
    spending: Spending = field(default_factory=Spending)
    version: int = 0
    attempt: Attempt | None = None
    collisions: Mapping[str, tuple[Mesh, ...]] | None = None
    probed: Probed | None = None


def differ_by_attempt(old: Snapshot, new: Snapshot) -> bool:
    """Whether nothing but what is being tried has changed, so that little has to be drawn."""
    names = {one.name for one in fields(Snapshot)} - {"revision", "attempt"}
    same = all(getattr(old, name) is getattr(new, name) for name in names)
    return same and old.attempt is not new.attempt
