"""What each rater is asked, the answers in a CSV file, and what they come to.

Pairs of clips, order and sides by chance, with catch trials; shares are exact binomial ones
(Clopper and Pearson 1934).
"""

import csv
import hashlib
import itertools
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import TypeAdapter, ValidationError
from scipy.stats import binomtest

from physagent_studio.errors import InputError

MEDIA = {
    ".mp4": "video/mp4", ".webm": "video/webm", ".gif": "image/gif", ".png": "image/png",
    ".jpg": "image/jpeg",
}  # fmt: skip
"""Kinds of files that a browser shows, by suffix."""
PER_CATCH = 8
"""Trials for each catch trial, in which one side is blank: who looks at all answers it."""
BLANK = ""
"""The method of the blank side of a catch trial."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One question: the clip's name and the method on each side; `BLANK` for nothing to see."""

    clip: str
    left: str
    right: str

    @property
    def catch(self) -> bool:
        """Whether its answer is known beforehand."""
        return BLANK in (self.left, self.right)

    def method(self, side: str) -> str:
        """The method on a side, `left` or `right`."""
        return self.left if side == "left" else self.right


@dataclass(frozen=True, slots=True)
class Study:
    """files: of each method, by the clip's name. sentences: what a clip shall show, by its name."""

    folder: Path
    files: Mapping[str, Mapping[str, Path]]
    sentences: Mapping[str, str]
    seed: int = 0

    def pairs(self) -> Iterator[tuple[str, str, str]]:
        """Every pair of clips: their name and the two methods."""
        for one, other in itertools.combinations(sorted(self.files), 2):
            for clip in sorted(set(self.files[one]) & set(self.files[other])):
                yield clip, one, other

    def trials(self, rater: str) -> list[Trial]:
        """All trials of a rater in their order; the same for the same name and seed."""
        said = hashlib.sha256(f"{self.seed}/{rater}".encode()).digest()
        rng = np.random.default_rng(int.from_bytes(said[:8], "big"))
        asked = list(self.pairs())
        count = max(1, round(len(asked) / PER_CATCH))
        caught = rng.choice(len(asked), min(count, len(asked)), replace=False)
        asked += [(asked[k][0], asked[k][1 + int(rng.integers(2))], BLANK) for k in caught]
        order = [asked[k] for k in rng.permutation(len(asked))]
        turned = rng.random(len(order)) < 0.5
        return [
            Trial(clip, other, one) if turn else Trial(clip, one, other)
            for (clip, one, other), turn in zip(order, turned, strict=True)
        ]


def study_of(folder: Path, seed: int = 0) -> Study:
    """The study in a folder; raises InputError where no two methods have a clip of one name.

    A sentence is the text file of a clip's name beside it, of whichever method has one.
    """
    if not folder.is_dir():
        raise InputError(f"there is no folder {folder}")
    files: dict[str, dict[str, Path]] = {}
    sentences: dict[str, str] = {}
    for method in sorted(path for path in folder.iterdir() if path.is_dir()):
        clips = {p.stem: p for p in sorted(method.iterdir()) if p.suffix.lower() in MEDIA}
        if clips:
            files[method.name] = clips
        for clip in clips.values():
            text = clip.with_suffix(".txt")
            if text.is_file():
                sentences.setdefault(clip.stem, text.read_text(encoding="utf-8").strip())
    study = Study(folder, files, sentences, seed)
    if not any(study.pairs()):
        raise InputError(
            f"{folder} needs a folder for each of at least two methods, with clips of the same "
            f"names in them ({', '.join(MEDIA)})"
        )
    return study


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


CONFIDENCE = 0.95
HELD = 0.75
"""Share of the catch trials that a rater has to answer rightly to be counted."""


@dataclass(frozen=True, slots=True)
class Pair:
    """How often `one` was chosen over `other`: the interval of its share, p of no preference."""

    one: str
    other: str
    wins: int
    count: int
    low: float
    high: float
    p: float

    @property
    def share(self) -> float:
        """Part of the answers that chose `one`."""
        return self.wins / self.count


def counted(answers: Sequence[Answer]) -> tuple[list[Answer], list[str]]:
    """The answers to true pairs by raters who saw what was blank, and the raters left out."""
    left_out = []
    for rater in sorted({answer.rater for answer in answers}):
        caught = [answer for answer in answers if answer.rater == rater and answer.catch]
        if caught and sum(bool(a.chosen) for a in caught) < HELD * len(caught):
            left_out.append(rater)
    return [a for a in answers if not a.catch and a.rater not in left_out], left_out


def pairs(answers: Sequence[Answer]) -> list[Pair]:
    """Every pair of methods that was asked for."""
    out = []
    methods = sorted({name for a in answers for name in (a.left, a.right)})
    for one, other in itertools.combinations(methods, 2):
        mine = [a for a in answers if {a.left, a.right} == {one, other}]
        if mine:
            wins = sum(a.chosen == one for a in mine)
            test = binomtest(wins, len(mine))
            ends = test.proportion_ci(CONFIDENCE, "exact")
            figures = (float(ends.low), float(ends.high), float(test.pvalue))
            out.append(Pair(one, other, wins, len(mine), *figures))
    return out


def summary(answers: Sequence[Answer]) -> list[str]:
    """The figures as lines of Markdown."""
    good, left_out = counted(answers)
    lines = [f"{len(good)} answers of {len({a.rater for a in good})} raters count."]
    if left_out:
        lines.append(f"Left out, for they chose blank sides: {', '.join(left_out)}.")
    if not good:
        return lines
    side = binomtest(sum(a.choice == "left" for a in good), len(good))
    lines += [f"The left side was chosen in {side.statistic:.0%} (p = {side.pvalue:.2g}).", ""]
    lines += ["| chosen | over | share | 95 % | answers | p |", "|---|---|---|---|---|---|"]
    return lines + [
        f"| {p.one} | {p.other} | {p.share:.3f} | {p.low:.3f} … {p.high:.3f} | {p.count} "
        f"| {p.p:.2g} |"
        for p in pairs(good)
    ]
