"""Roles that a person plays: whose turn it is, and what the person finds laid out for it."""

from collections.abc import Iterable

from physagent_studio.program import PhysicalProgram
from physagent_studio.records import LoopState
from physagent_studio.records.loop_state import ROLES, RoleName

TURNS: dict[str, RoleName] = {"generate": "generator", "judge": "verifier", "propose": "planner"}
"""The phase in which a role acts."""


AWAITED: dict[RoleName, str] = {
    "generator": "your first program",
    "verifier": "your verdict",
    "planner": "your repair",
}


def turn_of(state: LoopState) -> RoleName | None:
    """The role that a person plays and that is to act now; None where the loop can go on."""
    role = TURNS.get(state.phase)
    return role if role in state.by_hand else None


def waits_for(state: LoopState) -> str:
    """What a person has to do before the loop can go on; empty where it need not wait."""
    if state.phase == "decide":
        return "a decision on the proposal"
    role = turn_of(state)
    return AWAITED[role] if role else ""


def in_order(roles: Iterable[str]) -> tuple[RoleName, ...]:
    """Each role once, in the order in which they act."""
    wanted = set(roles)
    return tuple(role for role in ROLES if role in wanted)


def without_schedule(program: PhysicalProgram) -> PhysicalProgram:
    """Scene and demands with nothing scheduled yet, for a person in the generator's role."""
    event = program.event.model_copy(update={"actions": ()})
    return program.model_copy(update={"event": event})
