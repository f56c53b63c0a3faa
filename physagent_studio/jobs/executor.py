"""What an executor is, what it limits, and how a task fails."""

import logging
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeVar

from physagent_studio.errors import Cancelled, StudioError

log = logging.getLogger(__name__)
Result = TypeVar("Result")
TRACEBACK = 10_000
"""Characters of where a task broke down, of its end."""
Reason = Literal["time", "memory", "crash"]
_WORDS: dict[Reason, str] = {
    "time": "it took longer than {seconds:g} s of processor time",
    "memory": "it took more than {memory:.0f} MB of memory",
    "crash": "what was at work on it broke down",
}


@dataclass(frozen=True, slots=True)
class Limits:
    """seconds: of processor time, on all threads together. memory: bytes beyond an idle process."""

    seconds: float = 10.0
    memory: int = 256 * 2**20


class JobFailed(StudioError):
    """A task that was ended at a limit, or broke down; `reason` says which."""

    def __init__(self, reason: Reason, limits: Limits, detail: str = "") -> None:
        self.reason, self.limits, self.detail = reason, limits, detail
        words = _WORDS[reason].format(seconds=limits.seconds, memory=limits.memory / 2**20)
        super().__init__(f"{words} ({detail})" if detail else words)


def never() -> bool:
    """Nobody cancels."""
    return False


def quiet(*_news: Any) -> None:
    """Nobody listens."""


Tell = Callable[..., None]
"""Hears what a task says of its progress, in the words of whoever asked for it."""
_HEARING: ContextVar[tuple[Callable[[], bool], Tell]] = ContextVar(
    "hearing", default=(never, quiet)
)


def hearing() -> tuple[Callable[[], bool], Tell]:
    """For a task: whether it is cancelled by now, and whom it tells of its progress."""
    return _HEARING.get()


@contextmanager
def heard(cancelled: Callable[[], bool], tell: Tell) -> Iterator[None]:
    """While this lasts, a task on this thread hears and tells by these."""
    token = _HEARING.set((cancelled, tell))
    try:
        yield
    finally:
        _HEARING.reset(token)


def answer_of(task: Callable[..., Any], values: tuple[Any, ...]) -> tuple[str, Any]:
    """What a worker answers: a result, what the task said, or how it broke down."""
    try:
        return "result", task(*values)
    except StudioError as error:
        return "said", error
    except MemoryError:
        return "memory", ""
    except Exception as error:  # noqa: BLE001 - whatever it is, the other side is told
        return "crash", crash_of(error)


def crash_of(error: Exception) -> str:
    """A line for the person, and where it was for the log."""
    return f"{' '.join(repr(error)[:500].split())}\n{traceback.format_exc()[-TRACEBACK:]}"


def failure_of(
    kind: str, found: Any, task: Callable[..., Any], limits: Limits
) -> StudioError | None:
    """What an answer means that is no result; where a task broke down goes to the log."""
    if kind == "result":
        return None
    if kind == "said":
        return found
    if kind == "memory":
        return JobFailed("memory", limits)
    detail, _, trace = found.partition("\n")
    log.error("%s broke down\n%s", task, trace)
    return JobFailed("crash", limits, detail)


class Executor(Protocol):
    """Runs pure functions; `width`: how many at a time, each asked for by a thread of its own."""

    @property
    def width(self) -> int: ...

    def submit(
        self,
        task: Callable[..., Result],
        *values: Any,
        limits: Limits = ...,
        cancelled: Callable[[], bool] = ...,
        tell: Tell = ...,
    ) -> Result:
        """The task's result; its own `StudioError`, `JobFailed`, or `Cancelled`."""
        ...


class Inline:
    """Runs a task in this process, without limits; a task of which nobody knows ends as it will."""

    width = 1

    def submit(
        self,
        task: Callable[..., Result],
        *values: Any,
        limits: Limits = Limits(),
        cancelled: Callable[[], bool] = never,
        tell: Tell = quiet,
    ) -> Result:
        """The task's result; what it raises besides a `StudioError` is a `JobFailed`."""
        if cancelled():
            raise Cancelled("cancelled")
        with heard(cancelled, tell):
            kind, found = answer_of(task, values)
        if (failure := failure_of(kind, found, task, limits)) is not None:
            raise failure
        return found
