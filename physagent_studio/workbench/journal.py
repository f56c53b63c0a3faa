"""Every command that changes a session, before and after: for the audit, a restart and a replay."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from physagent_studio.errors import Cancelled, InputError, StorageError, StudioError
from physagent_studio.records import LoopState, Rollout
from physagent_studio.session import Session, Store
from physagent_studio.session.standing import BEGUN, CANCELLED, DONE, FAILED
from physagent_studio.workbench import commands
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.engine import AgentName, Control

CHANGING: tuple[type, ...] = (
    commands.Advance, commands.Step, commands.Run, commands.Decide, commands.ApplyEdits,
    commands.Retime, commands.AddMesh, commands.Wish, commands.ApplyText, commands.DiscardDraft,
    commands.ForkFrom, commands.OverruleVerdict, commands.SetPolicy, commands.TakeRole,
    commands.SetBudget, commands.Pin, commands.Unpin, commands.Undo, commands.Redo, commands.Rename,
    commands.ShowRound,
)  # fmt: skip
"""Commands of which a session keeps something, or on which the effect of another depends."""
_KINDS = {kind.__name__: kind for kind in CHANGING}


def carry_out(desk: Desk, command: Any, author: str) -> None:
    """Carries out a command, with an entry before and one after it in the session's log.

    Raises what the command raises; a `StorageError` where the session is only read here.
    """
    if not isinstance(command, CHANGING):
        desk.handle(command)
        return
    session = desk.session
    if isinstance(command, commands.ShowRound) and session.read_only:
        desk.handle(command)
        return
    session.record(BEGUN, author, {"command": _told(desk, command), **_mark(desk)})
    try:
        desk.handle(command)
    except (StudioError, KeyboardInterrupt) as error:
        ended = isinstance(error, (Cancelled, KeyboardInterrupt))
        session.use_answers() if not ended else None
        kind = CANCELLED if ended else type(error).__name__
        session.record(FAILED, author, {"why": str(error)[:500], "kind": kind, **_mark(desk)})
        raise
    session.record(DONE, author, _mark(desk))


def _told(desk: Desk, command: Any) -> dict[str, Any]:
    """A command as plain data; the form of a new thing is kept as a file and named."""
    name = type(command).__name__
    if isinstance(command, commands.AddMesh):
        asset = desk.session.put_mesh(command.body)
        rest = {"name": command.name, "foot": command.foot, "support": command.support}
        return {"kind": name, "fields": rest, "asset": asset}
    return {"kind": name, "fields": TypeAdapter(type(command)).dump_python(command, mode="json")}


def command_of(told: dict[str, Any], session: Session) -> Any:
    """The command of `_told`."""
    kind, fields = _KINDS[told["kind"]], dict(told["fields"])
    if kind is commands.AddMesh:
        body = session.mesh(told["asset"])
        assert body is not None
        x, y, z = fields["foot"]
        return commands.AddMesh(fields["name"], body, (x, y, z), fields["support"])
    return TypeAdapter(kind).validate_python(fields)


def _mark(desk: Desk) -> dict[str, Any]:
    """Where a session stands: the program, and the content of what was made of it."""
    head = desk.state.current
    made = [head.scene, head.rollout] if head is not None else []
    return {"program": desk.program.hash, "head": desk.state.head, "made": made}


def replay(
    source: Session,
    store: Store,
    agent: AgentName = "rules",
    tell: Callable[[str], None] = lambda text: None,
) -> Iterator[tuple[str, bool]]:
    """Does everything that a session's log names again, in a new session of the store.

    Yields each command with whether program, scene and rollout are the same to the bit. What was
    interrupted or cancelled is done to its end, so that from there on nothing is compared.
    """
    fresh = store.create(source.case, first_state(source), title="replay")
    desk = Desk(fresh, Control(), agent=agent, answers=source.answers())
    log = [(kind, payload) for _, kind, _, payload in source.log()]
    ends = [i for i, (kind, _) in enumerate(log) if kind == BEGUN]
    try:
        for at in ends:
            told = log[at][1]["command"]
            after = next((p for k, p in log[at + 1 :] if k in (BEGUN, DONE, FAILED)), None)
            whole = after is not None and "command" not in after
            if after is None or not whole or after.get("kind") == CANCELLED:
                tell(f"{told['kind']} was cut short here; nothing after it can be compared")
                return
            try:
                carry_out(desk, command_of(told, source), "replay")
            except StorageError:
                raise
            except StudioError as error:
                tell(str(error))
            mine = _mark(desk)
            same = all(mine[key] == after[key] for key in mine)
            keys = [made[1] for made in (after["made"], mine["made"]) if len(made) > 1]
            if not same and len(keys) == 2 and all(keys) and keys[0] != keys[1]:
                tell(f"{told['kind']}: {_apart(source.rollout(keys[0]), fresh.rollout(keys[1]))}")
            yield told["kind"], same
    finally:
        fresh.close()


def _apart(before: Rollout, now: Rollout) -> str:
    """How far a run that was done again lies from the recorded one, in words."""
    if before.objects != now.objects or before.positions.shape != now.positions.shape:
        return "the run is of other things or of another length than the recorded one"
    gaps = [np.linalg.norm(now.positions - before.positions, axis=-1)]
    for (_, old), (_, new) in zip(before.vertices, now.vertices, strict=False):
        gaps += [np.linalg.norm(new - old, axis=-1)] if old.shape == new.shape else []
    # What has blown up has no place.
    most = max(float(np.nanmax(gap, initial=0)) for gap in gaps)
    made = [", ".join(f"{a} {b}" for a, b in one.versions) for one in (before, now)]
    return f"up to {1000 * most:.3g} mm apart; recorded with {made[0]}, done again with {made[1]}"


def first_state(session: Session) -> LoopState:
    """The state that a session began with."""
    stored = session.meta("first")
    if stored is None:
        raise InputError(f"session {session.id} was begun before there was an audit to replay from")
    return LoopState.model_validate_json(stored)


def replayed(store: Store, session_id: str, scratch: Path, agent: AgentName) -> dict[str, Any]:
    """How many commands of a session were done again to the same bits, and which were not."""
    source = store.open(session_id, writing=False)
    said: list[str] = []
    try:
        rows = list(replay(source, Store(scratch), agent, said.append))
    finally:
        source.close()
    return {"commands": len(rows), "same": sum(ok for _, ok in rows),
            "different": [kind for kind, ok in rows if not ok], "said": said}  # fmt: skip
