"""A model's grades of pairs of clips, blind to their methods, each pair in both orders."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import av
import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from physagent_studio.agent.vlm import Ledger, load_settings
from physagent_studio.agent.vlm.dialogue import converse
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Picture, Turn, prompt, quoted
from physagent_studio.agent.vlm.wire import check_installed
from physagent_studio.benchmark.study.trials import Study, keep, read_rows
from physagent_studio.errors import InputError
from physagent_studio.records import Image
from physagent_studio.rendering.sheets import contact_sheet

FILE = "judgements.csv"
FRAMES = 12
"""Frames of a clip that are shown, evenly spread."""
HIGHEST = 4
"""Grade of a criterion with which nothing is wrong; a clip's mean over it is its score, 0 … 1."""
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
        return (self.trajectory + self.contact + self.force + self.material) / (4 * HIGHEST)


class Verdict(BaseModel):
    """What the model answers."""

    model_config = ConfigDict(extra="forbid")

    first: Grades
    second: Grades
    more_real: Literal["first", "second", "equal"]
    reason: str = Field(max_length=2000)


@dataclass(frozen=True, slots=True)
class Judgement:
    """One answer: methods in the order shown, their scores, and the one preferred, "" for none."""

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
    path = study.folder / FILE
    kept = {(j.clip, j.first, j.second): j for j in read_rows(path, Judgement)}
    rng = np.random.default_rng(study.seed)
    for clip, *pair in study.pairs():
        order = pair if rng.random() < 0.5 else pair[::-1]
        for first, second in (order, order[::-1]):
            key = (clip, first, second)
            if key not in kept:
                kept[key] = _asked(study, line, key, frames)
                keep(path, kept[key])
            yield kept[key]


def _asked(study: Study, line: Line, key: tuple[str, str, str], frames: int) -> Judgement:
    clip, first, second = key
    words = f"The sentence:\n{quoted(study.sentences.get(clip, '(none was given)'))}"
    pictures = [
        Picture(sheet_of(study.files[method][clip], frames), f"the {place} clip")
        for method, place in ((first, "first"), (second, "second"))
    ]
    system = prompt("system", part=RUBRIC.read_text(encoding="utf-8"))
    turns = (Turn("system", (system,)), Turn("user", (words, *pictures)))
    said = converse(line, "judge.pair", turns, Verdict, lambda verdict: verdict)
    preferred = {"first": first, "second": second, "equal": ""}[said.more_real]
    return Judgement(*key, said.first.score, said.second.score, preferred, said.reason)


def sheet_of(path: Path, count: int) -> Image:
    """So many frames of a video, evenly spread, as one sheet that says nothing but the time.

    Raises InputError where it cannot be read.
    """
    try:
        with av.open(str(path)) as container:
            times = [float(frame.time or 0.0) for frame in container.decode(video=0)]
            wanted = set(np.linspace(0, len(times) - 1, count).round().astype(int).tolist())
            container.seek(0)
            every = enumerate(container.decode(video=0))
            chosen = [frame.to_ndarray(format="rgb24") for k, frame in every if k in wanted]
    except (OSError, IndexError, ValueError) as error:
        raise InputError(f"{path} cannot be read as a video: {error}") from None
    if not chosen:
        raise InputError(f"{path} has no frame")
    frames = [np.asarray(frame, np.uint8) for frame in chosen]
    return contact_sheet(frames, [f"{times[k]:.2f} s" for k in sorted(wanted)])
