"""What an executor is, what it limits, and how a task fails."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeVar

from physagent_studio.errors import Cancelled, StudioError

Result = TypeVar("Result")
Reason = Literal["time", "memory", "crash"]
_WORDS: dict[Reason, str] = {
    "time": "it took longer than {seconds:g} s of processor time",
    "memory": "it took more than {memory:.0f} MB of memory",
    "crash": "what reads it broke down",
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


class Executor(Protocol):
    """Runs pure functions."""

    def submit(
        self,
        task: Callable[..., Result],
        *values: Any,
        limits: Limits = ...,
        cancelled: Callable[[], bool] = ...,
    ) -> Result:
        """The task's result; its own `StudioError`, `JobFailed`, or `Cancelled`."""
        ...


class Inline:
    """Runs a task in this process, without limits; a task of which nobody knows ends as it will."""

    def submit(
        self,
        task: Callable[..., Result],
        *values: Any,
        limits: Limits = Limits(),
        cancelled: Callable[[], bool] = never,
    ) -> Result:
        """The task's result; what it raises besides a `StudioError` is a `JobFailed`."""
        if cancelled():
            raise Cancelled("cancelled")
        try:
            return task(*values)
        except StudioError:
            raise
        except MemoryError as error:
            raise JobFailed("memory", limits) from error
        except Exception as error:
            raise JobFailed("crash", limits, repr(error)) from error
