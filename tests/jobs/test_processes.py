"""Tasks end at their limits, with a reason, and the next one finds the pool as it was."""

from __future__ import annotations

import os
import signal
import threading
import time

import numpy as np
import pytest

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.jobs import Inline, JobFailed, Limits, Processes, hearing

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


def dividing(number: int) -> float:
    return number / 0


def unsendable() -> object:
    return threading.Lock()


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


def talking() -> int:
    """Tells of its progress all the time, for ten seconds."""
    cancelled, tell = hearing()
    for number in range(1000):
        if cancelled():
            raise Cancelled(str(number))
        tell("talking", number / 1000)
        time.sleep(0.01)
    return 1000


@pytest.mark.parametrize("keeping", [False, True])
def test_a_task_that_tells_all_the_time_is_cancelled_too(keeping: bool) -> None:
    pool, cancel = Processes(width=1, keeping=keeping), threading.Event()
    told: list[float] = []

    def hear(what: str, share: float) -> None:
        told.append(share)
        if len(told) == 5:
            cancel.set()

    try:
        with pytest.raises(Cancelled):
            pool.submit(talking, cancelled=cancel.is_set, tell=hear)
    finally:
        pool.close()
    assert len(told) < 500


def test_a_task_gives_back_nothing_that_could_be_called(pool: Processes) -> None:
    with pytest.raises(JobFailed, match="may not give back"):
        pool.submit(calling_back)


@pytest.mark.parametrize("made", [Inline, lambda: Processes(width=1)])
def test_the_log_says_where_a_task_broke_down_and_the_person_only_why(
    made, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(JobFailed, match="division by zero") as failed:
        made().submit(dividing, 1)
    assert "in dividing" in caplog.text
    assert "in dividing" not in str(failed.value)


def test_what_cannot_be_sent_is_a_crash_that_says_so(pool: Processes) -> None:
    with pytest.raises(JobFailed, match="pickle"):
        pool.submit(unsendable)
    with pytest.raises((TypeError, AttributeError), match="pickle"):
        # Of our own side: no fault of the task, and not told as one.
        pool.submit(greedy, threading.Lock())
    assert pool.submit(greedy, 3) == 3


def test_the_signal_that_ended_a_task_is_named(pool: Processes) -> None:
    with pytest.raises(JobFailed, match="Segmentation"):
        pool.submit(crashing)


def test_inline_is_the_same_without_limits() -> None:
    assert Inline().submit(greedy, 7) == 7
    with pytest.raises(InputError):
        Inline().submit(refusing)
    with pytest.raises(JobFailed, match="ZeroDivisionError"):
        Inline().submit(divmod, 1, 0)


# --- processes that keep -----------------------------------------------------------------------


def first_of(values: tuple[np.ndarray, ...]) -> np.ndarray:
    return values[0]


def number_of(values: np.ndarray) -> int:
    return id(values)


def telling(count: int) -> bool:
    cancelled, tell = hearing()
    for number in range(count):
        tell("at", number)
    return cancelled()


def heeding() -> None:
    cancelled, tell = hearing()
    tell("begun")
    while not cancelled():
        time.sleep(0.01)
    raise Cancelled("as asked")


@pytest.fixture(scope="module")
def keeper():
    made = Processes(width=1, keeping=True)
    yield made
    made.close()


def test_an_array_crosses_once(keeper: Processes) -> None:
    values = np.arange(1e5)
    assert keeper.submit(first_of, (values, values)) is values
    assert keeper.submit(number_of, values) == keeper.submit(number_of, values)
    made = keeper.submit(doubled, values)
    assert keeper.submit(first_of, (made,)) is made
    assert np.array_equal(made, values * 2)


def test_what_nobody_has_any_more_is_forgotten(keeper: Processes) -> None:
    for number in range(20):
        assert keeper.submit(doubled, np.full(10_000, number))[0] == 2 * number
    keeper.submit(greedy, 1)
    kept = keeper._idle[0]._kept
    assert kept is not None
    assert len(kept._arrays) <= 2


def test_a_task_tells_and_hears(keeper: Processes) -> None:
    said: list[tuple[str, int]] = []
    assert keeper.submit(telling, 3, tell=lambda *news: said.append(news)) is False
    assert said == [("at", 0), ("at", 1), ("at", 2)]
    here: list[tuple[str, int]] = []
    Inline().submit(telling, 3, tell=lambda *news: here.append(news))
    assert here == said


def test_a_fault_of_the_listener_is_its_own(keeper: Processes) -> None:
    def listener(*_news: object) -> None:
        raise KeyError("of the listener")

    with pytest.raises(KeyError, match="of the listener"):
        keeper.submit(telling, 1, tell=listener)
    assert keeper.submit(greedy, 3) == 3


def test_a_task_that_ends_when_asked_keeps_its_process(keeper: Processes) -> None:
    keeper.submit(greedy, 1)
    before, begun = keeper._idle[0], threading.Event()
    with pytest.raises(Cancelled, match="as asked"):
        keeper.submit(heeding, cancelled=begun.is_set, tell=lambda *_: begun.set())
    assert keeper._idle == [before]


def test_a_task_that_does_not_is_ended(keeper: Processes) -> None:
    cancel = threading.Event()
    threading.Timer(0.2, cancel.set).start()
    with pytest.raises(Cancelled):
        keeper.submit(busy, cancelled=cancel.is_set)
    assert keeper.submit(greedy, 3) == 3
