"""`physagent bench durability`: a dose that ends in minutes, or (`full`) all of it."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from physagent_studio.agent.loop import add_round
from physagent_studio.benchmark.durability.cancelling import cancelled
from physagent_studio.benchmark.durability.disk import faults
from physagent_studio.benchmark.durability.kills import kills
from physagent_studio.benchmark.rows import Row, at_most, shown
from physagent_studio.errors import InputError
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import load_program
from physagent_studio.records import Case, LoopState, Round
from physagent_studio.session import Session, Store
from physagent_studio.workbench import Workbench, commands

PROGRAM = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.1], support: floor}
    - {name: box, shape: {kind: box, size: [0.2, 0.2, 0.2]}, position: [1, 2, 0.1], support: floor}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The ball rolls to the right and hits the box.
  actions:
    - {operator: SetVelocity, id: go, name: ball, velocity: [0.5, 0, 0], start_step: 0}
contract:
  clauses: [{id: c1, text: hits the box}]
  statements:
    - {id: hit, kind: contacts, subject: ball, other: box, clause: c1}
"""


def bench(
    *,
    cases: Path | None = None,
    out: Path | None = None,
    full: bool = False,
    dose: tuple[int, int, int, int, int, int] = (100, 18, 120, 12, 50, 10_000),
) -> list[Row]:
    """All rows. dose: kills, cancels, failing writes, walks of clients, steps of each, rounds."""
    all_of_it = (1000, 300, 2000, 500, 50, 10_000)
    killed, cancels, writes, walks, steps, rounds = all_of_it if full else dose
    program = load_program(PROGRAM)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        rows = kills(root / "kills", program, killed)
        rows += cancelled(root / "cancels", cancels)
        for kind, words in (("full", "disk full"), ("io", "I/O error")):
            wrong, said = faults(root / kind, program, writes, kind)
            rows.append(at_most(f"damage or loss, {words}, {writes} writes", wrong, 0))
            rows.append(shown(f"what is said, {words}", said))
        return rows + _walks(program, walks, steps) + _long(root / "long", program, rounds)


def _walks(program: PhysicalProgram, runs: int, steps: int) -> list[Row]:
    try:
        from physagent_studio.benchmark.durability.walks import walked
    except ImportError as error:
        raise InputError(
            "the walks need hypothesis: pip install 'physagent-studio[test]'"
        ) from error
    lost, taken, why = walked(program, runs, steps)
    words = f"{runs} walks of {steps} steps of 2–4 clients, {taken} taken"
    return [at_most(f"lost updates, {words}", lost, 0)] + [shown("what was lost", why)] * lost


def _long(root: Path, program: PhysicalProgram, rounds: int) -> list[Row]:
    """A session of very many rounds: opening it, and adding one more."""
    case = Case("bench", None, "", (), (), (), program.event.prompt)
    store = Store(root)
    workbench = Workbench(store, evidence=False)
    workbench.post(commands.OpenProgram(program, "long"))
    workbench.post(commands.Step())
    workbench.wait(120)
    first = workbench.snapshot().state.rounds[0]
    workbench.post(commands.OpenProgram(program, "other"))
    workbench.wait(120)
    session = store.create(case, LoopState(), title="long")
    grown = tuple(_grown(first, number) for number in range(1, rounds + 1))
    session.save(LoopState(rounds=grown, head="r1", phase="done"), checkpoint="made")
    session.close()
    began = time.perf_counter()
    workbench.post(commands.OpenSession(session.id))
    workbench.wait(120)
    opened = time.perf_counter() - began
    assert len(workbench.snapshot().state.rounds) == rounds
    workbench.close()
    last = store.open(session.id)
    try:
        commits = _commits(last, program, f"a new round commits beside {rounds}, p95")
    finally:
        last.close()
    return [at_most(f"seconds to open {rounds} rounds", opened, 2.0, "s"), *commits]


def _commits(session: Session, program: PhysicalProgram, words: str) -> list[Row]:
    """What a hundred more rounds take; of that work, waiting for a core, and for the disk."""
    state, taken = session.load(), list[tuple[float, ...]]()
    for _ in range(100):
        state = add_round(state, program, "person", None)
        before = np.array([time.perf_counter(), time.process_time(), _waited_for_a_core()])
        session.save(state, checkpoint="step")
        after = np.array([time.perf_counter(), time.process_time(), _waited_for_a_core()])
        wall, work, core = (after - before) * 1000
        taken.append((wall, work, core, wall - work - core, wall - core))
    wall, work, core, disk, alone = np.percentile(taken, 95, axis=0).round(2).tolist()
    return [
        at_most(words, wall, 20.0, "ms"),
        shown("processor time of that, p95", work, "ms"),
        shown("waiting for a core, p95", core, "ms"),
        shown("waiting for the disk, p95", disk, "ms"),
        shown("all but waiting for a core, p95", alone, "ms"),
    ]


def _waited_for_a_core() -> float:
    """Seconds for which this thread could have gone on and others had the cores; 0 if unknown."""
    told = Path("/proc/thread-self/schedstat")
    return int(told.read_text().split()[1]) / 1e9 if told.exists() else 0.0


def _grown(first: Round, number: int) -> Round:
    parent = None if number == 1 else f"r{number // 2}"
    return first.model_copy(
        update={"id": f"r{number}", "number": number, "parent": parent, "rollout": None}
    )
