"""The boundary of the command line: errors become one sentence and an exit code; what many take."""

import functools
import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Annotated, ParamSpec, TypeVar

import typer

from physagent_studio.cli import output
from physagent_studio.errors import Cancelled, ProgramError, StudioError, Unclear
from physagent_studio.jobs import JobFailed

P = ParamSpec("P")
R = TypeVar("R")
Json = Annotated[bool, typer.Option("--json", help="Print one JSON value for machines.")]
Workspace = Annotated[
    Path | None,
    typer.Option(help="Folder of sessions; else $PHYSAGENT_HOME, else your data folder."),
]
OUR_FAULT, BAD_INPUT, NOT_REALISED, WAITING, CANCELLED = 1, 2, 3, 4, 130

KEPT = "cancelled; everything up to here is kept"


def guarded(command: Callable[P, R]) -> Callable[P, R]:
    """Wraps a command so that what a person can do something about is one sentence."""

    @functools.wraps(command)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return command(*args, **kwargs)
        except (Cancelled, KeyboardInterrupt):
            if kwargs.get("as_json"):
                output.print_json({"outcome": "cancelled"})
            say(KEPT)
            raise typer.Exit(CANCELLED) from None
        except ProgramError as error:
            for problem in error.problems:
                say(f"{error.source}, {problem}" if error.source else str(problem))
            raise typer.Exit(BAD_INPUT) from None
        except Unclear as error:
            say(str(error))
            raise typer.Exit(WAITING) from None
        except StudioError as error:
            if isinstance(error.__cause__, JobFailed) and error.__cause__.reason == "crash":
                # A step that broke down is no bad input: `our_fault` says so.
                raise
            say(str(error))
            raise typer.Exit(BAD_INPUT) from None
        except BrokenPipeError:
            # The reader of our output is gone; nothing more can be said to it.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(OUR_FAULT) from None

    return wrapper


def our_fault(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """As `sys.excepthook`: what nobody expected ends in one sentence, with exit code 1."""
    if os.environ.get("PHYSAGENT_DEBUG"):
        sys.__excepthook__(kind, error, trace)
    else:
        say(f"this is our fault: {error!r}; PHYSAGENT_DEBUG=1 shows where")


def say(text: str) -> None:
    """One sentence on standard error."""
    typer.echo(f"physagent: {' '.join(text.split())}", err=True)
