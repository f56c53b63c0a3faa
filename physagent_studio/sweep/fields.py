"""Numbers of a program by dotted path: which there are, and what a range of them is written as."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.errors import EditError, InputError, Problem
from physagent_studio.program import PhysicalProgram, SetField, apply, value_at

MOST_STEPS = 10_000
"""Values of one field in a grid."""


@dataclass(frozen=True, slots=True)
class Span:
    """A field and the ends between which it is moved; steps: values of a grid, 0 where drawn."""

    path: str
    low: float
    high: float
    steps: int = 0

    @property
    def values(self) -> list[float]:
        """The values of a grid, both ends among them."""
        return np.linspace(self.low, self.high, self.steps).tolist()


def span_of(word: str, *, grid: bool) -> Span:
    """`FIELD=A:B:N` of a grid, or `FIELD=A:B` of what is drawn. Raises InputError."""
    path, _, ends = word.partition("=")
    try:
        low, high, *rest = (float(part) for part in ends.split(":"))
        steps = int(*rest) if grid else 0
        if len(rest) != grid or not path or not math.isfinite(low + high):
            raise ValueError(word)
    except (ValueError, OverflowError, TypeError):
        form = "FIELD=A:B:N" if grid else "FIELD=A:B"
        raise InputError(f"{word} is not of the form {form}") from None
    if grid and not 1 <= steps <= MOST_STEPS:
        raise InputError(f"{word} has {steps} values; 1 … {MOST_STEPS} are allowed")
    return Span(path.strip(), low, high, steps)


def checked(program: PhysicalProgram, span: Span) -> None:
    """Raises `EditError` where a field is no number of the program, or an end is not allowed."""
    if isinstance(value_at(program, span.path), bool | str | list | dict):
        try:
            value_at(program, f"{span.path}.?")
        except EditError as error:
            # What is in it is what may be meant.
            allowed = error.problems[0].allowed or "a field that holds a number"
            raise EditError((Problem(span.path, "is no number", allowed),)) from None
    for end in (span.low, span.high):
        apply(program, (setting(program, span.path, end),))


def setting(program: PhysicalProgram, path: str, value: float) -> SetField:
    """The edit that sets a field; where a whole number stands it stays one."""
    whole = isinstance(value_at(program, path), int)
    return SetField(path=path, value=round(value) if whole else value)
