"""Kinds of things by their names and paces of motion by their senses, from the tables beside.

`objects.yaml` and `verbs.yaml` say in their heads what their columns mean; both are read once.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from physagent_studio.errors import InputError

Heading = Literal["long_axis", "short_axis", "none"]
Number = Annotated[float, Field(ge=0)]


class _Row(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


R = TypeVar("R", bound=_Row)


class Kind(_Row):
    """A kind of thing. name, synonyms: words as in an object's name, singular.

    wheels: whether it rolls on wheels. heading: along which of its level axes it faces: the longer
    or the shorter one of its outline from above, or none (a ball, a chair on castors).
    """

    name: str
    synonyms: tuple[str, ...] = ()
    wheels: bool
    heading: Heading


class Range(_Row):
    """A range of speeds, and the one that is met with most."""

    low: Number
    usual: Number
    high: Number

    @model_validator(mode="before")
    @classmethod
    def _listed(cls, row: Any) -> Any:
        names = ("low", "usual", "high")
        return dict(zip(names, row, strict=True)) if isinstance(row, list | tuple) else row

    @model_validator(mode="after")
    def _ordered(self) -> Range:
        if not self.low <= self.usual <= self.high:
            raise ValueError("low, usual and high rise in this order")
        return self


class Speeds(_Row):
    """One manner of a motion: metres, m/s; lengths, of the moving thing's own length per second."""

    metres: Range
    lengths: Range


class Pace(_Row):
    """How fast what a sense of motion says is. plain: as said by itself; slow: slowly, gently;
    fast: fast, hard. source: where the figures come from.
    """

    sense: str
    plain: Speeds
    slow: Speeds
    fast: Speeds
    source: Annotated[str, Field(min_length=10)]


@cache
def kinds() -> tuple[Kind, ...]:
    """All rows of `objects.yaml`."""
    return tuple(_read("objects.yaml", Kind))


@cache
def paces() -> tuple[Pace, ...]:
    """All rows of `verbs.yaml`."""
    return tuple(_read("verbs.yaml", Pace))


def kind_of(name: str) -> Kind | None:
    """The kind of thing that a snake_case name speaks of, None where no word of it is known.

    Its last words count most: a `car_box` is a box, an `office_chair_2` an office chair.
    """
    words = [word for word in name.lower().replace("-", "_").split("_") if word.isalpha()]
    table, longest = _by_word()
    for end in range(len(words), 0, -1):
        for start in range(max(end - longest, 0), end):
            for last in _singular(words[end - 1]):
                found = table.get("_".join([*words[start : end - 1], last]))
                if found is not None:
                    return found
    return None


def pace_of(sense: str) -> Pace | None:
    """The pace of a sense of motion, None where it has no row."""
    return _by_sense().get(sense)


@cache
def _by_word() -> tuple[dict[str, Kind], int]:
    """The kinds by name and synonym, and the words of the longest of these."""
    table: dict[str, Kind] = {}
    for kind in kinds():
        for word in (kind.name, *kind.synonyms):
            if word in table:
                raise InputError(f"objects.yaml: '{word}' stands in two rows")
            table[word] = kind
    return table, max(word.count("_") + 1 for word in table)


@cache
def _by_sense() -> dict[str, Pace]:
    return {pace.sense: pace for pace in paces()}


def _singular(word: str) -> tuple[str, ...]:
    """What a word may be the plural of, itself first."""
    endings = (("ies", "y"), ("ves", "fe"), ("ves", "f"), ("es", ""), ("s", ""))
    return (word, *(word.removesuffix(a) + b for a, b in endings if word.endswith(a)))


def _read(file: str, model: type[R]) -> list[R]:
    path = Path(__file__).with_name(file)
    rows = yaml.safe_load(path.read_text(encoding="utf-8"))
    found = []
    for number, row in enumerate(rows, 1):
        try:
            found.append(model.model_validate(row))
        except ValidationError as error:
            raise InputError(f"{file}, row {number} ({row}): {error}") from None
    return found
