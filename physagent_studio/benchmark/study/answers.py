"""The answers of a study: a CSV file that every answer is added to at once."""

from __future__ import annotations

import csv
import os
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from physagent_studio.benchmark.study.trials import BLANK
from physagent_studio.errors import InputError

FILE = "answers.csv"


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

    @property
    def other(self) -> str:
        """The method that was not."""
        return self.right if self.choice == "left" else self.left


_COLUMNS = tuple(field.name for field in fields(Answer))


def read_answers(folder: Path) -> list[Answer]:
    """All answers so far; none where there is no file. Raises InputError for another file."""
    path = folder / FILE
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        return [
            Answer(**{**row, "trial": int(row["trial"]), "seconds": float(row["seconds"])})
            for row in rows
        ]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path} holds no answers of a study: {error}") from None


def keep(folder: Path, answer: Answer) -> None:
    """Adds an answer to the file; when this returns it is on the disk."""
    path = folder / FILE
    new = not path.is_file()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, _COLUMNS)
        if new:
            writer.writeheader()
        writer.writerow(asdict(answer))
        file.flush()
        os.fsync(file.fileno())
