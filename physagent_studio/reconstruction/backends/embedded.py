"""The embedded default as a `Reconstructor`."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction.masks.segmenter import Segmenter
from physagent_studio.reconstruction.pipeline import reconstruct
from physagent_studio.records.case import Case
from physagent_studio.records.scene import Scene


@dataclass(frozen=True, slots=True)
class Embedded:
    """Everything in NumPy and OpenCV; `segmenter` may be another one."""

    segmenter: Segmenter | None = None

    def reconstruct(
        self,
        case: Case,
        state: SceneState,
        *,
        previous: Scene | None = None,
        cancelled: Callable[[], bool] | None = None,
        progress: Callable[[str, float], None] | None = None,
    ) -> Scene:
        """See `reconstruction.reconstruct`."""
        return reconstruct(
            case,
            state,
            previous=previous,
            cancelled=cancelled,
            progress=progress,
            segmenter=self.segmenter,
        )


def make(folder: Path | None) -> Embedded:
    """The embedded backend; it needs no folder."""
    return Embedded()
