"""Contact sheets: what a person needs to judge a clip at a glance, and no figure beside it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from physagent_studio.agent.vlm.pictures import contact_sheet
from physagent_studio.records import Image, Rollout, Scene
from physagent_studio.rendering import Compositor, frame_of

FRAMES = 8
"""Frames of a sheet, evenly spread from the first to the last."""
COLUMNS, WIDTH = 4, 480
"""Pictures in a row, and their width in pixels."""


def sheet_of(scene: Scene, rollout: Rollout) -> Image:
    """Eight frames of a clip with their numbers."""
    compositor = Compositor(scene)
    numbers = np.linspace(0, rollout.frames - 1, FRAMES).round().astype(int)
    frames = [frame_of(compositor, rollout, int(number)).rgb for number in numbers]
    labels = [f"frame {number} of {rollout.frames - 1}" for number in numbers]
    return contact_sheet(frames, labels, COLUMNS, WIDTH)


def write_sheet(path: Path, scene: Scene, rollout: Rollout, sentence: str) -> None:
    """Writes the sheet as PNG, and the sentence beside it as text."""
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), sheet_of(scene, rollout)[:, :, ::-1])
    path.with_suffix(".txt").write_text(sentence + "\n", encoding="utf-8")
