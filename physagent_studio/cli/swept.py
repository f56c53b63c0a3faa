"""What `physagent sweep` and `attribute` do: targets from words, runs, tables, sentences."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from physagent_studio.cli.files import read_program
from physagent_studio.cli.programs import bare_case
from physagent_studio.cli.targets import PROGRAMS, case_of, is_session
from physagent_studio.errors import InputError
from physagent_studio.exchange.files import written
from physagent_studio.jobs import Executor
from physagent_studio.program.text.document import dump_program
from physagent_studio.records import LoopState, Round
from physagent_studio.session import Session
from physagent_studio.session import Store as Sessions
from physagent_studio.sweep.attribution import attribution
from physagent_studio.sweep.carry_out import carry_out, into
from physagent_studio.sweep.page import write_page
from physagent_studio.sweep.plan import Plan, Target, planned
from physagent_studio.sweep.robustness import judged
from physagent_studio.sweep.store import Store
from physagent_studio.sweep.table import Table, table_of, write_csv, write_parquet
from physagent_studio.workbench.tasks import likened


def swept(
    words: list[str],
    event: str | None,
    plan: Plan,
    executor: Executor,
    out: Path,
    workspace: Path | None,
    *,
    tell: Callable[[int, int], None],
) -> dict[str, Any]:
    """Carries a sweep out and writes all of it into a folder; what is said of it."""
    targets = tuple(one for word in words for one in targets_of(word, event, Sessions(workspace)))
    total, done = plan.size * len(targets), 0
    points = planned(plan, targets)
    store = Store(out)

    def told() -> None:
        nonlocal done
        done += 1
        tell(done, total)

    try:
        known = len(store)
        for target in targets:
            with written(out / "programs" / f"{_file_name(target.label)}.yaml") as partial:
                partial.write_text(dump_program(target.program), encoding="utf-8")
        carry_out(points, executor, into(store, told), known=store.__contains__)
        table = table_of((point, store[point.key]) for point in planned(plan, targets))
        said = [f"{total} points, {len(store) - known} run now"]
        if plan.draw is not None and not plan.grid:
            for target in targets:
                runs = [store[point.key] for point in planned(plan, (target,))]
                said.append(f"{target.label} {judged(target, runs).sentence}")
        said.append(_written(table, out, tuple(said)))
        return {"said": said, "points": total, "run": done, "holds": sum(table.column("holds"))}
    finally:
        store.close()


def _file_name(label: str) -> str:
    return "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in label)


def _written(table: Table, out: Path, said: tuple[str, ...]) -> str:
    """Writes the tables and the page; which they are."""
    write_page(table, out / "index.html", "Sweep", said)
    if write_parquet(table, out / "results.parquet"):
        return f"wrote {out / 'results.parquet'} and {out / 'index.html'}"
    write_csv(table, out / "results.csv")
    return (
        f"wrote {out / 'results.csv'} and {out / 'index.html'}; with pyarrow (pip install"
        " 'physagent-studio[tables]') the table is Parquet"
    )


# --- what is swept -------------------------------------------------------------------------------


def targets_of(word: str, event: str | None, sessions: Sessions) -> list[Target]:
    """The programs that a word means: a file's, a session's best, the first of each of a case's
    events."""
    from physagent_studio.reconstruction import reconstruct

    path = Path(word)
    if path.suffix.lower() in PROGRAMS and path.name not in ("case.yaml", "case.yml"):
        program = read_program(path)
        scene = reconstruct(bare_case(program, path.stem), program.scene)
        whole = program.model_copy(update={"scene": scene.state})
        return [Target.of(path.stem, whole, scene)]
    if is_session(word, sessions):
        session = sessions.open(word, writing=False)
        try:
            return [_of_round(session, _chosen(session.load(), None), session.id)]
        finally:
            session.close()
    return _of_case(word, event)


def _of_case(word: str, event: str | None) -> list[Target]:
    """The program that the embedded agent would begin with, for each event."""
    from physagent_studio.agent.rules import RuleGenerator
    from physagent_studio.reconstruction import reconstruct

    names = [event] if event else [name for name, _ in case_of(word, None, "", ()).events]
    found = []
    for name in names or [None]:
        case = case_of(word, name, "", ())
        program = RuleGenerator().first(case, lambda state: reconstruct(case, state))  # noqa: B023
        scene = reconstruct(case, program.scene)
        whole = program.model_copy(update={"scene": scene.state})
        label = "/".join(part for part in (case.name, name) if part)
        found.append(Target.of(label, whole, scene, likened(scene)))
    return found


def _chosen(state: LoopState, round_id: str | None) -> Round:
    item = next((one for one in state.rounds if one.id == round_id), None)
    if round_id is not None and item is None:
        known = ", ".join(one.id for one in state.rounds)
        raise InputError(f"there is no round {round_id}; rounds: {known or 'none'}")
    if (chosen := item or state.best) is None:
        raise InputError("the session has no simulated round yet")
    return chosen


def _of_round(session: Session, item: Round, label: str) -> Target:
    if item.scene is None:
        raise InputError(f"round {item.id} has no scene: it ended before its reconstruction")
    scene = session.scene(item.scene)
    return Target.of(label, item.program, scene, likened(scene))


# --- attribution ---------------------------------------------------------------------------------


def attributed(
    session_id: str, round_id: str | None, executor: Executor, workspace: Path | None
) -> dict[str, Any]:
    """What the hunks of the proposal that made a round brought about."""
    session = Sessions(workspace).open(session_id, writing=False)
    try:
        state = session.load()
        item = _chosen(state, round_id)
        parent = next((one for one in state.rounds if one.id == item.parent), None)
        kind = item.origin.kind if item.origin else ""
        if parent is None or parent.proposal is None or kind not in ("accept", "accept_hunks"):
            made = ", ".join(one.id for one in state.rounds if one.origin is not None)
            raise InputError(f"no proposal made round {item.id}; such are: {made or 'none'}")
        target = _of_round(session, parent, session.id)
    finally:
        session.close()
    assert item.origin is not None
    taken = item.origin.hunks if kind == "accept_hunks" else ()
    hunks = [hunk for hunk in parent.proposal.hunks if not taken or hunk.id in taken]
    found = attribution(target, hunks, executor)
    rows = [
        {"id": one.hunk.id, "summary": one.hunk.summary, "needed": one.needed,
         "shapley": one.shapley}
        for one in found.credits
    ]  # fmt: skip
    way = "every order" if found.exact else "a sample of orders"
    said = (
        f"round {item.id}: {_outcome(found.before)} without the proposal, {_outcome(found.after)}"
    )
    said += f" with it ({found.runs} programs, shares over {way})"
    return {"round": item.id, "said": said, "hunks": rows, "exact": found.exact}


def _outcome(holds: bool) -> str:
    return "holds" if holds else "fails"
