"""What a video generator is to us, and the embedded one: the clip as we draw it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from physagent_studio import errors
from physagent_studio.exchange.prior import Prior
from physagent_studio.exchange.prior.framing import Framing
from physagent_studio.exchange.video import write_video
from physagent_studio.records.clip_look import Way

Cancelled = Callable[[], bool] | None
Progress = Callable[[str, float], None] | None


class VideoGenerator(Protocol):
    """Makes a video from a motion prior."""

    @property
    def name(self) -> str:
        """What it is called."""
        ...

    def generate(
        self, prior: Prior, out: Path, *, cancelled: Cancelled = None, progress: Progress = None
    ) -> Path:
        """Writes the video to `out` and returns where it is.

        cancelled: asked between steps. progress: told the step's name and the share done, 0 … 1.

        Raises:
            InputError: what it was given cannot be used, or it answered with an error.
            BackendMissing: it is not there.
            Cancelled: `cancelled` said so; nothing is left at `out`.
        """
        ...


@dataclass(frozen=True, slots=True)
class Composite:
    """size: width and height, None for the photo's own. fps: None for the prior's."""

    size: tuple[int, int] | None = None
    way: Way = "crop"
    fps: float | None = None
    name: str = "composite"

    def generate(
        self, prior: Prior, out: Path, *, cancelled: Cancelled = None, progress: Progress = None
    ) -> Path:
        """See `VideoGenerator`."""
        framing = Framing.of(prior.size, self.size or _even(prior.size), self.way)
        timing = {key: float(prior.meta[key]) for key in ("time_factor", "simulated_seconds")}

        def pictures() -> Iterator[NDArray[np.uint8]]:
            for number, picture in enumerate(prior.pictures()):
                if cancelled is not None and cancelled():
                    raise errors.Cancelled("writing the video was cancelled")
                yield framing.picture(picture)
                if progress is not None:
                    progress("writing", (number + 1) / prior.frames)

        fps = self.fps or float(prior.meta["fps"])
        write_video(out, pictures(), fps, timing | {"playback_fps": fps})
        return out


def _even(size: tuple[int, int]) -> tuple[int, int]:
    width, height = size
    return width - width % 2, height - height % 2
