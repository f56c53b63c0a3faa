"""Numbers of a program by dotted path: which there are, and what a range of them is written as."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import JsonValue

from physagent_studio.errors import EditError, InputError, Problem
from physagent_studio.program import PhysicalProgram, SetField, apply, value_at
from physagent_studio.program.edits import label_of

LISTED_FIELDS = 12
"""Numbers that an error names: as many as are taken in at a glance."""
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
    def values(self) -> tuple[float, ...]:
        """The values of a grid, both ends among them."""
        return tuple(np.linspace(self.low, self.high, self.steps).tolist())


def span_of(word: str, *, grid: bool) -> Span:
    """`FIELD=A:B:N` of a grid, or `FIELD=A:B` of what is drawn. Raises InputError."""
    form = "FIELD=A:B:N" if grid else "FIELD=A:B"
    path, equals, ends = word.partition("=")
    parts = ends.split(":")
    try:
        low, high = float(parts[0]), float(parts[1])
        steps = int(parts[2]) if grid else 0
    except (IndexError, ValueError):
        raise InputError(f"{word} is not of the form {form}") from None
    whole = path.strip() and equals and len(parts) == (3 if grid else 2)
    if not whole or not math.isfinite(low) or not math.isfinite(high):
        raise InputError(f"{word} is not of the form {form}")
    if grid and not 1 <= steps <= MOST_STEPS:
        raise InputError(f"{word} has {steps} values; 1 … {MOST_STEPS} are allowed")
    return Span(path.strip(), low, high, steps)


def checked(program: PhysicalProgram, span: Span) -> None:
    """Raises `EditError` where a field is no number of the program, or an end is not allowed."""
    now = value_at(program, span.path)
    if isinstance(now, bool) or not isinstance(now, int | float | None):
        numbers = [*_numbers(now, span.path)]
        shown = ", ".join(numbers[:LISTED_FIELDS]) + (" …" if len(numbers) > LISTED_FIELDS else "")
        raise EditError((Problem(span.path, "is no number", f"numbers: {shown or 'none'}"),))
    for end in (span.low, span.high):
        apply(program, (setting(program, span.path, end),))


def setting(program: PhysicalProgram, path: str, value: float) -> SetField:
    """The edit that sets a field; where a whole number stands it stays one."""
    whole = isinstance(value_at(program, path), int)
    return SetField(path=path, value=round(value) if whole else value)


def _numbers(node: JsonValue, path: str) -> Iterator[str]:
    """The paths of the numbers below a node, and of what is open and may be one."""
    items: Iterable[tuple[Any, Any]] = ()
    if isinstance(node, dict):
        items = node.items()
    elif isinstance(node, list):
        items = ((label_of(one) or index, one) for index, one in enumerate(node))
    elif isinstance(node, int | float) and not isinstance(node, bool):
        yield path
    for name, one in items:
        yield from _numbers(one, f"{path}.{name}")
