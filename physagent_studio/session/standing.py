"""How a session stands: it goes on, it waits, it was cut short, or it has ended in doubt."""

from physagent_studio.session.session import Session

BEGUN, DONE, FAILED = "begun", "done", "failed"
"""Kinds of log entries: a command without one of the other two behind it was interrupted."""
CANCELLED = "Cancelled"
"""Kind of failure of a command that a person has ended."""
IN_DOUBT = "as far as it is tested and what is doubted is right"
"""How far an event is realised of which something is untested, not understood or doubted."""


def interrupted(session: Session) -> str:
    """The command that an end of the process has cut short, in a word; "" where none was."""
    last = session.last_of((BEGUN, DONE, FAILED))
    return str(last[1]["command"]["kind"]) if last is not None and last[0] == BEGUN else ""


def standing(session: Session, held: bool) -> str:
    """How a loop stands that has not ended. held: whether a process has the session to write.

    "running": a command is being carried out; "interrupted": the process that did so is gone;
    "cancelled": a person ended it; "open": it waits for the next.
    """
    if interrupted(session):
        return "running" if held else "interrupted"
    last = session.last_of((DONE, FAILED))
    return "cancelled" if last is not None and last[1].get("kind") == CANCELLED else "open"


def is_in_doubt(session: Session) -> bool:
    """Whether something of the best round is untested, not understood or doubted."""
    state = session.load()
    best = state.best or state.current
    if best is None:
        return False
    contract = best.program.contract
    unsure = best.scene is not None and session.is_doubted(best.scene)
    return bool(contract.untested or contract.not_understood or unsure)
