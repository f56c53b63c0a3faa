"""The other side: a process that carries out one task after the other, each under its limits."""

import importlib
import os
import pickle
import resource
import select
import signal
import socket
import threading
from pathlib import Path
from typing import Any

from physagent_studio.jobs.executor import Limits, answer_of, crash_of, heard
from physagent_studio.jobs.letters import Kept, post, take

STATISTICS = Path("/proc/self/statm")
"""Where Linux says how much address space a process has; its limit is not enforced elsewhere."""


def main(descriptor: int, keeping: bool) -> None:
    """Serves until the other end of the socket is closed. keeping: arrays cross only once."""
    # Ctrl+C goes to all processes of a terminal; the one that is asked decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    kept = Kept(weak=False) if keeping else None
    with socket.socket(fileno=descriptor) as line:
        threading.Thread(target=_leave_with, args=(descriptor,), daemon=True).start()
        while True:
            try:
                # Imports what the task needs, before its limits begin.
                task, values, limits = take(line, strict=False, kept=kept)
            except EOFError:
                return
            found = _carried_out(line, task, values, limits)
            try:
                post(line, found, kept)
            except (pickle.PicklingError, TypeError, AttributeError) as error:
                # What cannot be sent was never begun to be sent; the other side ends this process.
                post(line, ("crash", crash_of(error)))
            # What it was about may be forgotten while nothing is to be done.
            del task, values, found


def _leave_with(descriptor: int) -> None:
    """Ends this process with the one that it works for, whatever it is doing then."""
    hung_up = select.poll()
    hung_up.register(descriptor, select.POLLHUP | getattr(select, "POLLRDHUP", 0))
    hung_up.poll()
    os._exit(0)


def _carried_out(
    line: socket.socket, task: Any, values: tuple[Any, ...], limits: Limits
) -> tuple[str, Any]:
    cancelled, speaking = threading.Event(), threading.Lock()
    signal.signal(signal.SIGUSR1, lambda *_: cancelled.set())

    def tell(*news: Any) -> None:
        with speaking:
            post(line, ("told", news))

    _limit(limits)
    try:
        with heard(cancelled.is_set, tell):
            return answer_of(task, values)
    finally:
        _limit(None)


def _limit(limits: Limits | None) -> None:
    """Sets the limits; at that of time the kernel ends this process, whatever it is doing."""
    signal.setitimer(signal.ITIMER_PROF, 0.0 if limits is None else limits.seconds)
    if STATISTICS.exists():
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        soft = hard if limits is None else _address_space() + limits.memory
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _address_space() -> int:
    return int(STATISTICS.read_text().split()[0]) * resource.getpagesize()


def import_all(names: tuple[str, ...]) -> None:
    """A task that only makes what is needed later be there."""
    for name in names:
        importlib.import_module(name)
