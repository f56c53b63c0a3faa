"""Errors with a purpose: what was wrong, where, and what is allowed.

Everything that a person can cause derives from `StudioError` and is shown as one sentence.
"""

from dataclasses import dataclass


class StudioError(Exception):
    """Root of all errors that are shown to a person; `str(error)` is the sentence."""


class InputError(StudioError):
    """Bad input: a file, a picture, an argument, a value typed in the browser."""


class Unclear(InputError):
    """Where a thing is in the photo is not clear from its words alone; a person has to say."""


class StorageError(StudioError):
    """The disk took less than it was given, or a session is not this process's to write."""


class BackendMissing(StudioError):
    """An optional backend is not installed or not configured; names what to install."""


class SimulationError(StudioError):
    """The scene cannot be turned into a physics model, or the engine refused it."""


class Cancelled(StudioError):
    """The person cancelled; nothing that was acknowledged is lost."""


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a program.

    path: dotted path of the field, such as `event.actions.kick.velocity`.
    line: 1-based line in the person's text, or None where there is no text.
    """

    path: str
    message: str
    allowed: str = ""
    line: int | None = None

    def __str__(self) -> str:
        where = self.path or "program"
        if self.line is not None:
            where = f"line {self.line}, {where}"
        return f"{where}: {self.message}" + (f" ({self.allowed})" if self.allowed else "")


class ProgramError(InputError):
    """A program that cannot be accepted; carries every problem found.

    source: the file that it was read from, "" for none.
    """

    def __init__(self, problems: tuple[Problem, ...], *, source: str = "") -> None:
        self.problems = problems
        self.source = source
        super().__init__("; ".join(str(problem) for problem in problems))


class EditError(ProgramError):
    """An edit that does not apply to the program it was given."""
