"""What a video generator is to us."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from physagent_studio.exchange.prior import Prior

Cancelled = Callable[[], bool]
Progress = Callable[[str, float], None]


class VideoGenerator(Protocol):
    """Makes a video from a motion prior."""

    @property
    def name(self) -> str:
        """What it is called."""
        ...

    def generate(
        self,
        prior: Prior,
        out: Path,
        *,
        cancelled: Cancelled | None = None,
        progress: Progress | None = None,
    ) -> Path:
        """Writes the video to `out` and returns where it is.

        cancelled: asked between steps. progress: told the step's name and the share done, 0 … 1.

        Raises:
            InputError: what it was given cannot be used, or it answered with an error.
            BackendMissing: it is not there.
            Cancelled: `cancelled` said so; nothing is left at `out`.
        """
        ...
