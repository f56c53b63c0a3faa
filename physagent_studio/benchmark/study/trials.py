"""What each rater is asked: pairs of clips, order and sides by chance, and catch trials."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

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
