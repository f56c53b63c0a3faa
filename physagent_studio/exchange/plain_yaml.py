"""YAML as plain data with the line of every value, for case folders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from physagent_studio.errors import InputError, ProgramError
from physagent_studio.program.text.yaml_nodes import Location, parse

MAX_BYTES = 1_000_000


@dataclass(frozen=True, slots=True)
class PlainYaml:
    """A document: its data and the 1-based line of each place (keys and indices) in it."""

    data: Any
    lines: Mapping[Location, int]

    def line(self, place: Location) -> int:
        """The line of a place, or of the nearest thing that holds it."""
        while place and place not in self.lines:
            place = place[:-1]
        return self.lines.get(place, 1)


def read_yaml(text: str, name: str) -> PlainYaml:
    """Parse a document called `name` in messages.

    Raises:
        InputError: it is no YAML, or uses more of YAML than it may; says on which line.
    """
    try:
        root = parse(text, MAX_BYTES)
    except ProgramError as error:
        first = error.problems[0]
        where = f" (at {first.path})" if first.path else ""
        allowed = f"; {first.allowed}" if first.allowed else ""
        told = f"{name}, line {first.line}: {first.message}{allowed}{where}"
        raise InputError(told) from error
    return PlainYaml(root.plain(), root.lines())
