"""SAM 2 as a `Segmenter`, out of process, through the same job folder."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.backends.jobs import inside, numbers, read_result, write_job
from physagent_studio.reconstruction.masks.segmenter import Cancelled
from physagent_studio.reconstruction.photo.reading import read_photo
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate


@dataclass(frozen=True, slots=True)
class Sam2Segmenter:
    """Reads `folder/result`; where there is none, writes the job and says how to run it."""

    folder: Path

    def segment(
        self, image: Image, groundings: Sequence[tuple[str, Grounding]], cancelled: Cancelled = None
    ) -> dict[str, tuple[Candidate, ...]]:
        """Candidate masks (H, W) with the model's scores, best first."""
        if not (self.folder / "result").is_dir():
            write_job(self.folder, "sam2", image, groundings, {}, None)
        out: dict[str, tuple[Candidate, ...]] = {name: () for name, _ in groundings}
        for entry in read_result(self.folder, "sam2"):
            name = str(entry.get("name"))
            if name not in out:
                raise InputError(f"the result has '{name}', which was not asked for")
            files = list(entry.get("masks", ()))[:4]
            scores = numbers(entry, "scores", len(files)) if files else np.zeros(0)
            found = [
                Candidate(self._mask(file, image), float(np.clip(score, 0, 1)), "sam2")
                for file, score in zip(files, scores, strict=False)
            ]
            out[name] = tuple(sorted(found, key=lambda candidate: -candidate.score))
        return out

    def _mask(self, file: object, image: Image) -> np.ndarray:
        pixels, _ = read_photo(inside(self.folder, file))
        if pixels.shape[:2] != image.shape[:2]:
            raise InputError(f"the mask {file} has not the size of the picture")
        return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY) > 127)
