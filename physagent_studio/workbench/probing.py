"""Looks into what is on view: how sturdy it is, and which changes brought it about."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from physagent_studio.errors import InputError
from physagent_studio.program.edits import Hunk
from physagent_studio.records import LoopState, Round
from physagent_studio.sweep import Target
from physagent_studio.sweep.attribution import Attribution, attribution
from physagent_studio.sweep.robustness import Robustness, robustness

if TYPE_CHECKING:
    from physagent_studio.workbench.desk import Desk

Looked = Literal["sturdiness", "credit"]
RUNS = 50
"""Runs with the uncertain numbers moved: one in fifty is seen, and two cores take seconds."""


@dataclass(frozen=True, eq=False, slots=True)
class Probed:
    """What was found about a program. credit: the changes that made its round, and their shares."""

    program: str = ""
    sturdiness: Robustness | None = None
    credit: tuple[tuple[Hunk, ...], Attribution] | None = None


def probed(desk: Desk, what: Looked, known: Probed) -> Probed:
    """Runs the program on view, or the one it was made from, many times. Raises InputError."""
    found = known if known.program == desk.program.hash else Probed(desk.program.hash)
    if what == "sturdiness":
        return replace(found, sturdiness=_sturdiness(desk))
    return replace(found, credit=_credit(desk))


def _sturdiness(desk: Desk) -> Robustness:
    scene, rollout, _ = desk.on_view()
    if scene is None or rollout is None:
        raise InputError("nothing has run yet; run it first, then see how sturdy it is")
    program = desk.program.model_copy(update={"scene": scene.state})
    target = Target("on view", program, scene, desk.engine.likeness(scene))
    control = desk.control

    def tell(share: float) -> None:
        control.progress(f"running it {RUNS} times", share)

    return robustness(target, desk.engine.executor, RUNS, cancelled=control.cancelled, tell=tell)


def _credit(desk: Desk) -> tuple[tuple[Hunk, ...], Attribution]:
    if desk.round is None:
        raise InputError("there is no round yet")
    parent, hunks = made_by(desk.round, desk.state)
    scene = desk.session.scene(parent.scene or "")
    target = Target("before", parent.program, scene, desk.engine.likeness(scene))
    control = desk.control

    def tell(share: float) -> None:
        control.progress("running it without each change", share)

    found = attribution(target, hunks, desk.engine.executor, cancelled=control.cancelled, tell=tell)
    return hunks, found


def made_by(item: Round, state: LoopState) -> tuple[Round, tuple[Hunk, ...]]:
    """The round that one was made from, and the hunks of its proposal that were taken.

    Raises InputError where no accepted proposal made it.
    """
    parent = next((one for one in state.rounds if one.id == item.parent), None)
    origin = item.origin
    if parent is None or parent.proposal is None or parent.scene is None or origin is None:
        raise InputError(f"round {item.id} was not made by a proposal")
    if origin.kind not in ("accept", "accept_hunks"):
        raise InputError(f"round {item.id} was not made by accepting a proposal")
    taken = origin.hunks if origin.kind == "accept_hunks" else ()
    return parent, tuple(one for one in parent.proposal.hunks if not taken or one.id in taken)
