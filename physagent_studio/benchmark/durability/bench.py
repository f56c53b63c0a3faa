"""`physagent bench durability`: kills, cancels, a failing disk, clients and very many rounds.

A dose ends in minutes; `full` is all of it. A disk fails by limits of the kernel: errors are real.
"""

import os
import random
import resource
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from physagent_studio.agent.loop import add_round
from physagent_studio.assets import assets_dir
from physagent_studio.benchmark.durability.kills import kills
from physagent_studio.benchmark.rows import Row, at_most, shown
from physagent_studio.errors import InputError, StorageError
from physagent_studio.jobs import Processes
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import load_program
from physagent_studio.records import Case, LoopState, Round
from physagent_studio.session import Session, Store
from physagent_studio.session.care import check
from physagent_studio.workbench import Workbench, commands, tasks

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
    case = Case("bench", prompt=program.event.prompt)
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


OPENING = commands.OpenCase(assets_dir() / "demo", "block_stays_standing")
"""An event of which every phase is long: its first program has to be repaired."""
LONGEST = {"opening": 6.0, "running": 9.0, "rendering": 4.0}
"""Seconds at most between the start of a command and its cancellation."""
PATIENCE = 300.0
"""Seconds for a command that nobody cancels."""


def cancelled(root: Path, times: int) -> list[Row]:
    """Figures over that many cancelled commands: photos opened, steps of the loop, videos."""
    executor, store = Processes(1, keeping=True), Store(root)
    executor.warm(*tasks.MODULES).join()
    workbench = Workbench(store, executor=executor)
    rng, waits, doing = random.Random(0), [], Counter[str]()
    try:
        begun, ended = _prepared(workbench, store)
        for number in range(times):
            kind = ("opening", "running", "rendering")[number % 3]
            command = _command(kind, workbench, store, begun, ended)
            workbench.post(command)
            time.sleep(rng.uniform(0.1, LONGEST[kind]))
            doing[(workbench.snapshot().busy or "nothing").rpartition(": ")[2]] += 1
            began = time.perf_counter()
            workbench.cancel()
            workbench.wait(PATIENCE)
            waits.append(time.perf_counter() - began)
        # Whatever was cut short goes on from where it was, to its end.
        _prepared(workbench, store)
        realised = workbench.snapshot().state.outcome == "realised"
    finally:
        workbench.close()
        executor.close()
    spread = ", ".join(f"{what} {count}" for what, count in sorted(doing.items()))
    loaded = os.getloadavg()[0] > (os.cpu_count() or 1) + 1
    words = f"longest of {times} cancels{', on a loaded machine' if loaded else ''}"
    return [
        at_most(f"until the worker is free, {words}", max(waits), 3.0 if loaded else 1.0, "s"),
        at_most("runs that do not reach their end after these", not realised, 0),
        shown("what was cancelled", spread),
    ]


def _prepared(workbench: Workbench, store: Store) -> tuple[str, str]:
    """Two sessions: one that has been reconstructed, and one that has run to its end."""
    workbench.post(OPENING)
    workbench.wait(PATIENCE)
    begun = store.duplicate(workbench.snapshot().session_id or "")
    workbench.post(commands.Run())
    workbench.wait(PATIENCE)
    return begun, workbench.snapshot().session_id or ""


def _command(
    kind: str, workbench: Workbench, store: Store, begun: str, ended: str
) -> commands.Command:
    if kind == "opening":
        return OPENING
    running = kind == "running"
    workbench.post(commands.OpenSession(store.duplicate(begun) if running else ended))
    workbench.wait(PATIENCE)
    return commands.Run() if running else commands.Render(store.root / "clip.mp4")


PAGE = 4096 + 24
"""Bytes of a page in SQLite's log of writes: each limit falls into another of them."""


def faults(root: Path, program: PhysicalProgram, times: int, kind: str) -> tuple[int, str]:
    """How often something was damaged or went unsaid, with the disk full or (`io`) failing.

    Runs in a process of its own, since the limits hold for all of one. Also what was said.
    """
    reading, writing = os.pipe()
    pid = os.fork()
    if pid == 0:
        try:
            wrong, said = _faults(root, program, times, kind)
            os.write(writing, f"{wrong} {said}".encode())
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as stream:
        wrong, _, said = stream.read().partition(" ")
    os.waitpid(pid, 0)
    return (int(wrong) if wrong else times), said


def _faults(root: Path, program: PhysicalProgram, times: int, kind: str) -> tuple[int, str]:
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    case = Case("bench", prompt="bench")
    session = Store(root).create(case, LoopState(draft=program), title=kind)
    wrong, said = 0, ""
    for number in range(times):
        before = session.load()
        state = add_round(before, program, "person", None)
        lift = _full(session, number) if kind == "full" else _failing(session)
        try:
            session.files.put(os.urandom(3 * PAGE), ".bin")
            session.save(state, checkpoint="step")
        except StorageError as error:
            said = str(error)
            kept = len(session.load().rounds) == len(before.rounds)
        else:
            kept = len(session.load().rounds) == len(state.rounds)
        lift()
        # There is room again: the same goes through, in the same process.
        session.save(state, checkpoint="again")
        wrong += (not kept) + (len(session.load().rounds) != len(state.rounds))
    folder = session.folder
    session.close()
    return wrong + len(check(folder)), said or "nothing was said"


def _full(session: Session, number: int) -> Callable[[], None]:
    """No file may grow beyond a size that lies in its next writes, part of one of them included."""
    log = session.folder / "session.db-wal"
    size = (log.stat().st_size if log.exists() else 0) + number % 24 * PAGE // 3
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    endless = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, endless)


def _failing(session: Session) -> Callable[[], None]:
    """The file behind SQLite's log of writes can be read, and every write to it fails."""
    log = session.folder / "session.db-wal"
    own = [int(one) for one in os.listdir("/proc/self/fd") if _leads(one) == str(log)]
    kept = [(one, os.dup(one)) for one in own]
    for one in own:
        only_read = os.open(log, os.O_RDONLY)
        os.dup2(only_read, one)
        os.close(only_read)

    def lift() -> None:
        for one, other in kept:
            os.dup2(other, one)
            os.close(other)

    return lift


def _leads(descriptor: str) -> str:
    try:
        return os.readlink(f"/proc/self/fd/{descriptor}")
    except OSError:
        return ""
