"""The embedded generator: the clip as we draw it, in a generator's size and rate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physagent_studio import errors
from physagent_studio.exchange.generators.protocol import Cancelled, Progress
from physagent_studio.exchange.prior import Prior
from physagent_studio.exchange.prior.framing import Framing
from physagent_studio.exchange.video import write_video
from physagent_studio.records.clip_look import Way


@dataclass(frozen=True, slots=True)
class Composite:
    """size: width and height, None for the photo's own. fps: None for the prior's."""

    size: tuple[int, int] | None = None
    way: Way = "crop"
    fps: float | None = None
    name: str = "composite"

    def generate(
        self,
        prior: Prior,
        out: Path,
        *,
        cancelled: Cancelled | None = None,
        progress: Progress | None = None,
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
