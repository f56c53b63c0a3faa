"""Tasks end at their limits, with a reason, and the next one finds the pool as it was."""

from __future__ import annotations

import os
import signal
import threading
import time

import numpy as np
import pytest

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.jobs import Inline, JobFailed, Limits, Processes

MIB = 2**20


def doubled(values: np.ndarray) -> np.ndarray:
    return values * 2


def busy() -> None:
    while True:
        pass


def greedy(size: int) -> int:
    return len(bytearray(size))


def crashing() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def refusing() -> None:
    raise InputError("no such thing")


def sleeping() -> None:
    time.sleep(60)


def calling_back() -> object:
    return os.system


@pytest.fixture(scope="module")
def pool():
    made = Processes(width=1)
    yield made
    made.close()


def test_arrays_go_there_and_back(pool: Processes) -> None:
    values = np.arange(1e5).reshape(100, -1)
    assert np.array_equal(pool.submit(doubled, values), values * 2)


@pytest.mark.parametrize(
    ("task", "values", "reason"),
    [(busy, (), "time"), (greedy, (900 * MIB,), "memory"), (crashing, (), "crash")],
)
def test_a_limit_or_a_crash_is_a_reason(pool: Processes, task, values, reason) -> None:
    with pytest.raises(JobFailed) as failed:
        pool.submit(task, *values, limits=Limits(0.2, 64 * MIB))
    assert failed.value.reason == reason
    assert pool.submit(greedy, 10, limits=Limits(5.0, 64 * MIB)) == 10


def test_what_a_task_says_is_said_here(pool: Processes) -> None:
    with pytest.raises(InputError, match="no such thing"):
        pool.submit(refusing)


def test_a_task_is_cancelled_at_once(pool: Processes) -> None:
    cancel = threading.Event()
    threading.Timer(0.3, cancel.set).start()
    with pytest.raises(Cancelled):
        pool.submit(sleeping, cancelled=cancel.is_set)
    assert pool.submit(greedy, 3) == 3


def test_a_task_gives_back_nothing_that_could_be_called(pool: Processes) -> None:
    with pytest.raises(JobFailed, match="may not give back"):
        pool.submit(calling_back)


def test_inline_is_the_same_without_limits() -> None:
    assert Inline().submit(greedy, 7) == 7
    with pytest.raises(InputError):
        Inline().submit(refusing)
    with pytest.raises(JobFailed, match="ZeroDivisionError"):
        Inline().submit(divmod, 1, 0)
