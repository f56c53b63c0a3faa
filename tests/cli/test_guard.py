"""What the boundary of the command line takes for bad input, and what for our own fault."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import typer

from physagent_studio.cli.guard import BAD_INPUT, guarded
from physagent_studio.errors import StudioError
from physagent_studio.jobs import Inline, JobFailed


def step(task: Callable[..., object]) -> None:
    try:
        Inline().submit(task, 1, 0)
    except JobFailed as error:
        raise StudioError(f"the step was ended: {error}") from error


def hungry(*_: int) -> None:
    raise MemoryError


def test_a_step_that_broke_down_is_our_fault():
    with pytest.raises(StudioError, match="ZeroDivisionError"):
        guarded(step)(divmod)


def test_a_step_that_reached_a_limit_is_not():
    with pytest.raises(typer.Exit) as ended:
        guarded(step)(hungry)
    assert ended.value.exit_code == BAD_INPUT
