"""Frames of a finished clip, evenly spread, as one sheet that says nothing but the time."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np

from physagent_studio.agent.vlm.pictures import contact_sheet
from physagent_studio.errors import InputError
from physagent_studio.records import Image

MOST_FRAMES = 2000
"""Frames of a clip that are read at most: a minute and more of any of them."""


def sheet_of(path: Path, count: int) -> Image:
    """The sheet of so many frames of a video; raises InputError where it cannot be read."""
    frames, seconds = _read(path)
    chosen = np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int)
    labels = [f"{seconds[k]:.2f} s" for k in chosen]
    return contact_sheet([frames[k] for k in chosen], labels)


def _read(path: Path) -> tuple[list[Image], list[float]]:
    frames: list[Image] = []
    seconds: list[float] = []
    try:
        with av.open(str(path)) as container:
            for frame in container.decode(video=0):
                frames.append(frame.to_ndarray(format="rgb24").astype(np.uint8, copy=False))
                seconds.append(float(frame.time or 0.0))
                if len(frames) == MOST_FRAMES:
                    break
    except (OSError, IndexError, av.error.FFmpegError) as error:
        raise InputError(f"{path} cannot be read as a video: {error}") from None
    if not frames:
        raise InputError(f"{path} has no frame")
    return frames, seconds
