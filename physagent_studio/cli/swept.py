"""What `physagent sweep` and `attribute` do: targets from words, runs, tables, sentences."""

import sys
from contextlib import closing
from pathlib import Path

from physagent_studio.cli.early import is_session
from physagent_studio.cli.files import read_program
from physagent_studio.cli.targets import PROGRAMS, case_of
from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.exchange.tables import write_csv, write_parquet
from physagent_studio.jobs import Executor
from physagent_studio.reconstruction import reconstruct
from physagent_studio.records import Case, LoopState, Round
from physagent_studio.session import Session
from physagent_studio.session import Store as Sessions
from physagent_studio.sweep import Plan, Point, Ran, Store, Target, carry_out, planned
from physagent_studio.sweep.attribution import attribution
from physagent_studio.sweep.page import columns_of, write_page
from physagent_studio.sweep.plan import span_of
from physagent_studio.sweep.robustness import draw, judged
from physagent_studio.workbench.first import first_program
from physagent_studio.workbench.probing import made_by
from physagent_studio.workbench.tasks import likened


def plan_of(grid: list[str], random: list[str], draws: int) -> Plan:
    """The plan in words; without fields of their own the draws move all that is uncertain."""
    drawn = tuple(span_of(word, grid=False) for word in random)
    grids = tuple(span_of(word, grid=True) for word in grid)
    return Plan(grids, drawn, draws, draw if draws and not drawn else None)


def swept(
    words: list[str],
    event: str | None,
    plan: Plan,
    executor: Executor,
    out: Path,
    workspace: Path | None,
) -> list[str]:
    """Carries a sweep out and writes all of it into a folder; what is said of it."""
    targets = tuple(_target(word, event, Sessions(workspace)) for word in words)
    points, total, done = planned(plan, targets), plan.size * len(targets), 0

    def keep(point: Point, ran: Ran) -> None:
        nonlocal done
        store.add(point.key, ran)
        done += 1
        if sys.stderr.isatty() or done * 10 // total > (done - 1) * 10 // total:
            print(f"{done} of {total} runs", file=sys.stderr, flush=True)

    with closing(Store(out)) as store:
        carry_out(points, executor, keep, known=store.__contains__)
        columns = columns_of((point, store[point.key]) for point in planned(plan, targets))
        said = [f"{total} points, {done} of them run now, {sum(columns['holds'])} hold"]
        for target in targets if plan.draw and not plan.grid else ():
            runs = [store[point.key] for point in planned(plan, (target,))]
            said.append(f"{target.label} {judged(target, runs).sentence}")
    write_page(columns, out / "index.html", said)
    try:
        write_parquet(columns, out / "results.parquet")
    except BackendMissing as error:
        write_csv(columns, out / "results.csv")
        said.append(str(error))
    return [*said, f"wrote {out}: results and index.html"]


# --- what is swept -------------------------------------------------------------------------------


def _target(word: str, event: str | None, sessions: Sessions) -> Target:
    """The program that a word means: a file's, a session's best, the first of a case."""
    path = Path(word)
    if is_session(word):
        with sessions.open(word, writing=False) as session:
            return _of_round(session, _chosen(session, None)[0])
    if path.suffix.lower() in PROGRAMS and path.stem != "case":
        program, label = read_program(path), path.stem
        scene = reconstruct(Case(label, prompt=program.event.prompt), program.scene)
    else:
        case = case_of(word, event, "", ())
        program, scene = first_program(case)
        label = "/".join(part for part in (case.name, case.event) if part)
    return Target(label, program.model_copy(update={"scene": scene.state}), scene, likened(scene))


def _chosen(session: Session, round_id: str | None) -> tuple[Round, LoopState]:
    """A round that was simulated, by its id, or the best one; and all of them."""
    state = session.load()
    known = {one.id: one for one in state.rounds if one.scene}
    if (chosen := known.get(round_id) if round_id else state.best) is None:
        raise InputError(f"there is no such simulated round; rounds: {', '.join(known) or 'none'}")
    return chosen, state


def _of_round(session: Session, item: Round) -> Target:
    scene = session.scene(item.scene or "")
    return Target(session.id, item.program, scene, likened(scene))


def attributed(
    session_id: str, round_id: str | None, executor: Executor, workspace: Path | None
) -> list[str]:
    """What the hunks of the proposal that made a round brought about, a line each."""
    with Sessions(workspace).open(session_id, writing=False) as session:
        item, state = _chosen(session, round_id)
        parent, hunks = made_by(item, state)
        target = _of_round(session, parent)
    found = attribution(target, hunks, executor)
    without, whole = ("holds" if one else "fails" for one in (found.before, found.after))
    way = "every order" if found.exact else "a sample of orders"
    said = [f"{item.id} {without} without its proposal, {whole} with it; shares over {way}"]
    for index, hunk in enumerate(hunks):
        share = f"{found.shapley[index]:+.2f}" if found.shapley else ""
        needed = "needed" if found.needed[index] else ""
        said.append(f"{share:>6}  {needed:6}  {hunk.summary}")
    return said
