"""A disk that is full or fails, at every write: by limits of the kernel, so errors are real."""

from __future__ import annotations

import os
import resource
import signal
from collections.abc import Callable
from pathlib import Path

from physagent_studio.agent.loop import add_round
from physagent_studio.errors import StorageError
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Case, LoopState
from physagent_studio.session import Session, Store
from physagent_studio.session.care import check

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
    case = Case("bench", None, "", (), (), (), "bench")
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
