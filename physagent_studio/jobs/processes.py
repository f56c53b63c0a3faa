"""`Processes`: a small pool of processes, each ended at the limit of the task that it is at."""

from __future__ import annotations

import atexit
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from physagent_studio.errors import Cancelled, InputError, StudioError
from physagent_studio.jobs.executor import (
    JobFailed,
    Limits,
    Reason,
    Result,
    Tell,
    failure_of,
    never,
    quiet,
)
from physagent_studio.jobs.letters import Kept, Meanwhile, post, take
from physagent_studio.jobs.worker import import_all

START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[2]); "
    "from physagent_studio.jobs.worker import main; main(int(sys.argv[1]), len(sys.argv) > 3)"
)
PATIENCE = 10.0
"""Seconds by the clock for one of processor time where others load the machine; then it hangs."""
START_SECONDS = 30.0
"""Seconds that a process may take to start and to import what its first task needs."""
SINGLE = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OPENCV_FOR_THREADS_NUM", "MKL_NUM_THREADS"), "1"
)
"""Threads of numeric libraries would take address space, which is limited."""


GRACE = 0.3
"""Seconds in which a cancelled task may end by itself, and its process with all it has stays."""

HEAVY = 2**30
"""Bytes from which on a process that keeps what it has is replaced by a new one between tasks."""


class Processes:
    """Carries out tasks in at most `width` processes, which are started when they are needed.

    keeping: they are as this process is, threads of numeric libraries included, so that results
    have the same bits; arrays cross once; a cancelled task may end by itself within `grace`
    seconds; and a process that had to be ended is replaced at once, with the modules of `warm`.
    """

    def __init__(self, width: int = 2, *, keeping: bool = False, grace: float = GRACE) -> None:
        self.width, self._keeping, self._grace = width, keeping, grace
        self._modules: tuple[str, ...] = ()
        self._reset()
        atexit.register(self.close)
        os.register_at_fork(after_in_child=self._reset)

    def _reset(self) -> None:
        """As new: a forked process may not speak over the lines of the one that it came from."""
        self._idle: list[_Process] = []
        self._lock = threading.Lock()
        self._room = threading.Semaphore(self.width)
        self._open = True

    def submit(
        self,
        task: Callable[..., Result],
        *values: Any,
        limits: Limits = Limits(),  # noqa: B008
        cancelled: Callable[[], bool] = never,
        tell: Tell = quiet,
    ) -> Result:
        """The task's result; the task has to be a function of a module.

        Raises:
            JobFailed: it reached a limit or broke down; the process is ended and replaced.
            Cancelled: `cancelled()` became true; free within a tenth of a second, or `grace`.
            StudioError: what the task itself raised.
        """
        while not self._room.acquire(timeout=0.05):
            if cancelled():
                raise Cancelled("cancelled")
        process = None
        try:
            process = self._free()
            kind, found = process.carry_out((task, values, limits), limits, cancelled, tell)
            failure = failure_of(kind, found, task, limits)
            if isinstance(failure, JobFailed) and self._keeping:
                # What it keeps may be half of what it should be.
                raise failure
        except BaseException:
            # Ctrl+C as well: what is left of this answer may not be taken for that of the next.
            if process is not None:
                process.end()
            self._replace()
            raise
        else:
            self._give_back(process)
        finally:
            self._room.release()
        if failure is not None:
            raise failure
        return found

    def _give_back(self, process: _Process) -> None:
        heavy = self._keeping and process.resident() > HEAVY
        with self._lock:
            if self._open and not heavy:
                self._idle.append(process)
                return
        process.end()
        self._replace()

    def _replace(self) -> None:
        """Nobody shall wait for a process that was ended: the next one starts now."""
        if self._keeping and self._open and self._modules:
            self.warm(*self._modules)

    def warm(self, *modules: str) -> threading.Thread:
        """Starts a process that has these modules, in the background; the thread ends with it."""
        self._modules = modules
        limits = Limits(START_SECONDS, 2**40)

        def start() -> None:
            # Where that fails, the first task will say what is wrong.
            with suppress(StudioError):
                self.submit(import_all, modules, limits=limits)

        thread = threading.Thread(target=start, name="jobs-warm", daemon=True)
        thread.start()
        return thread

    def another(self, *modules: str) -> None:
        """Starts one more process that has these modules, and waits for it."""
        process = _Process(self._grace if self._keeping else None)
        limits = Limits(START_SECONDS, 2**40)
        try:
            process.carry_out((import_all, (modules,), limits), limits, never)
        except StudioError:
            process.end()
            raise
        self._give_back(process)

    def close(self) -> None:
        """Ends the idle processes; one at work ends with its task, or with this process."""
        with self._lock:
            idle, self._idle, self._open = self._idle, [], False
        for one in idle:
            one.end()

    def _free(self) -> _Process:
        with self._lock:
            while self._idle:
                one = self._idle.pop()
                if one.alive:
                    return one
                one.end()
        return _Process(self._grace if self._keeping else None)


class _Process:
    """One process and the line to it."""

    def __init__(self, grace: float | None) -> None:
        """grace: seconds for a cancelled task to end by itself; None keeps nothing."""
        self._grace, keeping = grace, grace is not None
        self._kept = Kept(weak=True) if keeping else None
        self._line, theirs = socket.socketpair()
        command = [sys.executable, "-P", "-c", START, str(theirs.fileno()), json.dumps(sys.path)]
        command += ["keeping"] * keeping
        with theirs:
            self._process = subprocess.Popen(
                command,
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=dict(os.environ) if keeping else os.environ | SINGLE,
            )

    @property
    def alive(self) -> bool:
        """Whether it still runs."""
        return self._process.poll() is None

    def carry_out(
        self,
        letter: tuple[Any, ...],
        limits: Limits,
        cancelled: Callable[[], bool],
        tell: Tell = quiet,
    ) -> tuple[str, Any]:
        """What the process answers; raises `JobFailed` where it was ended."""
        until = time.monotonic() + START_SECONDS + PATIENCE * limits.seconds
        most = self.resident() + limits.memory + _BASE
        held = self._kept.hold() if self._kept is not None else []
        ending: list[float] = []

        def meanwhile() -> None:
            if cancelled():
                self._cancel(ending)
            if time.monotonic() > until:
                raise JobFailed("time", limits)
            if self.resident() > most:
                raise JobFailed("memory", limits)

        try:
            self._line.settimeout(START_SECONDS)
            with self._broken_off(ending, limits):
                post(self._line, letter, self._kept, meanwhile)
            while True:
                with self._broken_off(ending, limits):
                    kind, found = self._answer(limits, meanwhile)
                if kind != "told":
                    return kind, found
                tell(*found)
                # A task that tells of its progress all the time leaves no time to wait in.
                meanwhile()
        finally:
            held.clear()

    @contextmanager
    def _broken_off(self, ending: list[float], limits: Limits) -> Iterator[None]:
        """A line that breaks off means that the process has ended; why, its end tells."""
        try:
            yield
        except (EOFError, OSError) as error:
            if ending:
                # It was asked to end while it was only starting, and has ended for good.
                raise Cancelled("cancelled") from error
            reason, detail = self._ended_by()
            raise JobFailed(reason, limits, detail) from error

    def _answer(self, limits: Limits, meanwhile: Meanwhile) -> tuple[str, Any]:
        """The next letter of the process, of which nothing is trusted."""
        try:
            kind, found = take(self._line, strict=True, kept=self._kept, meanwhile=meanwhile)
        except (EOFError, OSError, StudioError):
            raise
        # Broad on purpose: what a process sends that was taken over may raise anything.
        except Exception as error:
            raise JobFailed("crash", limits, repr(error)) from error
        if not isinstance(kind, str) or not isinstance(found, _ANSWERS.get(kind, ())):
            raise JobFailed("crash", limits, "its answer cannot be read")
        return kind, found

    def _cancel(self, ending: list[float]) -> None:
        """Asks the task to end, where that keeps what is of use later, and then ends it."""
        if not ending:
            ending.append(time.monotonic() + (self._grace or 0.0))
        if self._grace is None or time.monotonic() > ending[0]:
            raise Cancelled("cancelled")
        # Again and again, since it goes by unheard while the task is only read.
        self._process.send_signal(signal.SIGUSR1)

    def resident(self) -> int:
        """Bytes of memory that it holds; 0 where nobody says."""
        try:
            pages = Path(f"/proc/{self._process.pid}/statm").read_text().split()[1]
            return int(pages) * os.sysconf("SC_PAGE_SIZE")
        except (OSError, IndexError):
            return _asked(self._process.pid)

    def end(self) -> None:
        """Ends it at once, whatever it is doing."""
        self._line.close()
        self._process.kill()
        # The kernel takes a while to take back much memory; nobody has to wait for that.
        threading.Thread(target=self._process.wait, name="jobs-end", daemon=True).start()

    def _ended_by(self) -> tuple[Reason, str]:
        """Why the process has ended, and the signal that ended it."""
        try:
            code = self._process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            return "crash", ""
        if code == -signal.SIGPROF:
            return "time", ""
        return "crash", (signal.strsignal(-code) or "") if code < 0 else ""


_ANSWERS = {"told": tuple, "said": StudioError, "memory": str, "crash": str, "result": object}
"""What each kind of answer has to hold."""
_BASE = 128 * 2**20
"""Bytes that a process may come to hold by importing what its task needs."""


def _asked(pid: int) -> int:
    """What `ps` says of a process where there is no /proc, as on macOS."""
    if sys.platform == "linux":
        return 0
    command = ["ps", "-o", "rss=", "-p", str(pid)]
    said = subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()
    return int(said) * 1024 if said.isdigit() else 0


@lru_cache(maxsize=1)
def shared() -> Processes:
    """The pool of this process."""
    return Processes()


def within(limits: Limits, failed: str, task: Callable[..., Result], *values: Any) -> Result:
    """What a task gives in the pool of this process. Raises what it raises, and an InputError that
    begins with `failed` and says why where it is ended at its limits."""
    try:
        return shared().submit(task, *values, limits=limits)
    except JobFailed as error:
        raise InputError(f"{failed}: {error}") from error
