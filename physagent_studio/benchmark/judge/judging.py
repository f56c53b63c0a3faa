"""A model's grades of pairs of clips, blind to their methods, each pair in both orders."""

from __future__ import annotations

import csv
import itertools
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from physagent_studio.agent.vlm import Ledger, load_settings
from physagent_studio.agent.vlm.dialogue import converse
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Picture, Turn
from physagent_studio.agent.vlm.prompting import prompt, quoted
from physagent_studio.agent.vlm.wire import check_installed
from physagent_studio.benchmark.judge.frames import sheet_of
from physagent_studio.benchmark.study.trials import Study
from physagent_studio.errors import InputError

FILE = "judgements.csv"
CRITERIA = ("trajectory", "contact", "force", "material")
HIGHEST = 4
"""Grade of a criterion with which nothing is wrong; a clip's mean over it is its score, 0 … 1."""
FRAMES = 12
"""Frames of a clip that are shown, evenly spread."""
RUBRIC = Path(__file__).with_name("rubric.md")


class Grades(BaseModel):
    """The four grades of one clip."""

    model_config = ConfigDict(extra="forbid")

    trajectory: int = Field(ge=0, le=HIGHEST)
    contact: int = Field(ge=0, le=HIGHEST)
    force: int = Field(ge=0, le=HIGHEST)
    material: int = Field(ge=0, le=HIGHEST)

    @property
    def score(self) -> float:
        """Their mean, 0 … 1."""
        return sum(getattr(self, name) for name in CRITERIA) / (HIGHEST * len(CRITERIA))


class Verdict(BaseModel):
    """What the model answers."""

    model_config = ConfigDict(extra="forbid")

    first: Grades
    second: Grades
    more_real: Literal["first", "second", "equal"]
    reason: str = Field(max_length=2000)


@dataclass(frozen=True, slots=True)
class Judgement:
    """One answer: methods in the order shown, their scores, and the method that was preferred.

    preferred: "" where the model could not tell.
    """

    clip: str
    first: str
    second: str
    first_score: float
    second_score: float
    preferred: str
    reason: str


def line_from_environment(environ: Mapping[str, str] = os.environ) -> Line:
    """The line of the verifier's endpoint; raises BackendMissing where none is configured."""
    settings = load_settings(environ)
    check_installed()
    return Line("verifier", settings.endpoints["verifier"], Ledger.of(settings.limits))


def judge(study: Study, line: Line, frames: int = FRAMES) -> Iterator[Judgement]:
    """Every pair of clips of a name in both orders; what is kept already is not asked again.

    Which order comes first is drawn by the study's seed. Each answer is in the folder's
    `judgements.csv` before the next is asked for.
    """
    kept = {(j.clip, j.first, j.second): j for j in read_judgements(study.folder)}
    for key in _questions(study):
        if key not in kept:
            kept[key] = _asked(study, line, key, frames)
            _keep(study.folder, kept[key])
        yield kept[key]


def _questions(study: Study) -> Iterator[tuple[str, str, str]]:
    rng = np.random.default_rng(study.seed)
    for one, other in itertools.combinations(sorted(study.files), 2):
        for clip in sorted(set(study.files[one]) & set(study.files[other])):
            first, second = (one, other) if rng.random() < 0.5 else (other, one)
            yield clip, first, second
            yield clip, second, first


def _asked(study: Study, line: Line, key: tuple[str, str, str], frames: int) -> Judgement:
    clip, *methods = key
    sheets = [sheet_of(study.files[method][clip], frames) for method in methods]
    sentence = quoted(study.sentences.get(clip, "(none was given)"))
    pictures = (Picture(sheets[0], "the first clip"), Picture(sheets[1], "the second clip"))
    system = prompt("system", part=RUBRIC.read_text(encoding="utf-8"))
    turns = (
        Turn("system", (system,)),
        Turn("user", (f"The sentence:\n{sentence}", *pictures)),
    )
    said = converse(line, "judge.pair", turns, Verdict, lambda verdict: verdict)
    preferred = {"first": methods[0], "second": methods[1], "equal": ""}[said.more_real]
    return Judgement(
        clip, methods[0], methods[1], said.first.score, said.second.score, preferred, said.reason
    )


_COLUMNS = tuple(field.name for field in fields(Judgement))


def read_judgements(folder: Path) -> list[Judgement]:
    """What has been judged so far. Raises InputError where the file is something else."""
    path = folder / FILE
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    scores = ("first_score", "second_score")
    try:
        return [Judgement(**{**row, **{name: float(row[name]) for name in scores}}) for row in rows]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path} holds no judgements: {error}") from None


def _keep(folder: Path, judgement: Judgement) -> None:
    path = folder / FILE
    new = not path.is_file()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, _COLUMNS)
        if new:
            writer.writeheader()
        writer.writerow(asdict(judgement))
