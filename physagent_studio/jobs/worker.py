"""The other side: a process that carries out one task after the other, each under its limits."""

from __future__ import annotations

import importlib
import resource
import signal
import socket
from pathlib import Path
from typing import Any

from physagent_studio.errors import StudioError
from physagent_studio.jobs.executor import Limits
from physagent_studio.jobs.letters import post, take

STATISTICS = Path("/proc/self/statm")
"""Where Linux says how much address space a process has; its limit is not enforced elsewhere."""


def main(descriptor: int) -> None:
    """Serves until the other end of the socket is closed."""
    # Ctrl+C goes to all processes of a terminal; the one that is asked decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with socket.socket(fileno=descriptor) as line:
        while True:
            try:
                # Imports what the task needs, before its limits begin.
                task, values, limits = take(line, strict=False)
            except EOFError:
                return
            post(line, _carried_out(task, values, limits))


def _carried_out(task: Any, values: tuple[Any, ...], limits: Limits) -> tuple[str, Any]:
    _limit(limits)
    try:
        return "result", task(*values)
    except StudioError as error:
        return "said", error
    except MemoryError:
        return "memory", ""
    except Exception as error:  # noqa: BLE001 - whatever it is, the other side is told
        return "crash", repr(error)[:500]
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
