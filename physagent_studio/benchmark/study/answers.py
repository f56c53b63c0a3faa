"""Answers in a CSV file that every one is added to at once: of people, and of a model."""

from __future__ import annotations

import csv
import os
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from physagent_studio.benchmark.study.trials import BLANK
from physagent_studio.errors import InputError

Row = TypeVar("Row")


@dataclass(frozen=True, slots=True)
class Answer:
    """Who chose what: number of the trial in the rater's order, methods on the sides, seconds."""

    rater: str
    trial: int
    clip: str
    left: str
    right: str
    choice: str
    seconds: float

    @property
    def catch(self) -> bool:
        """Whether one side was blank."""
        return BLANK in (self.left, self.right)

    @property
    def chosen(self) -> str:
        """The method that was chosen; `BLANK` where the blank side was."""
        return self.left if self.choice == "left" else self.right


def read_answers(folder: Path) -> list[Answer]:
    """All answers of people so far."""
    return read_rows(folder / "answers.csv", Answer)


def read_rows(path: Path, kind: type[Row]) -> list[Row]:
    """All rows of a file; none where there is none. Raises InputError for another file."""
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        read = TypeAdapter(kind)
        return [read.validate_python(row) for row in rows]
    except ValidationError as error:
        raise InputError(f"{path} is another file: {error.errors()[0]['msg']}") from None


def keep(path: Path, row: Any) -> None:
    """Adds a row to the file; when this returns it is on the disk."""
    new = not path.is_file()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(row)])
        if new:
            writer.writeheader()
        writer.writerow(asdict(row))
        file.flush()
        os.fsync(file.fileno())
