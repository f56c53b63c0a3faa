"""`Prior`: an exported motion prior, read frame by frame."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.errors import InputError
from physagent_studio.exchange.prior.export import MARK, META
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.rollout_io import load_rollout
from physagent_studio.rendering import Flow


@dataclass(frozen=True, eq=False, slots=True)
class Prior:
    """A folder that `export_motion_prior` has finished, and what its manifest says."""

    folder: Path
    meta: dict[str, Any]

    @classmethod
    def open(cls, folder: Path | str) -> Self:
        """Raises InputError where the folder is no finished export."""
        folder = Path(folder)
        try:
            meta = json.loads((folder / META).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(f"{folder} is no finished motion prior: {META} cannot be read") from (
                error
            )
        if not isinstance(meta, dict) or meta.get("kind") != MARK:
            raise InputError(f"{folder / META} is not the manifest of a motion prior")
        return cls(folder, meta)

    @property
    def frames(self) -> int:
        """How many frames it has."""
        return int(self.meta["frames"])

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        width, height = self.meta["size"]
        return int(width), int(height)

    def picture(self, number: int) -> NDArray[np.uint8]:
        """(H, W, 3) RGB."""
        return self._png(f"frames/frame_{number:04d}.png")[..., ::-1]

    def ids(self, number: int) -> NDArray[np.int32]:
        """(H, W) index of the object, −1 for the background."""
        return self._png(f"ids/ids_{number:04d}.png").astype(np.int32) - 1

    def depth(self, number: int) -> NDArray[np.float32]:
        """(H, W) m along the optical axis, inf for the background."""
        return np.load(self.folder / f"depth/depth_{number:04d}.npz")["depth"]

    def flow(self, number: int) -> Flow:
        """From frame `number` to the next."""
        found = np.load(self.folder / f"flow/flow_{number:04d}.npz")
        return Flow(found["flow"], found["visible"])

    def backward(self, number: int) -> Flow:
        """From the frame after `number` back to it."""
        found = np.load(self.folder / f"flow/flow_{number:04d}.npz")
        return Flow(found["backward"], found["backward_visible"])

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """All of them, one at a time."""
        return (self.picture(number) for number in range(self.frames))

    def rollout(self) -> Rollout:
        """What was simulated."""
        return load_rollout(self.folder / "rollout.npz")

    def _png(self, name: str) -> NDArray[Any]:
        found = cv2.imread(str(self.folder / name), cv2.IMREAD_UNCHANGED)
        if found is None:
            raise InputError(f"{self.folder / name} is missing or cannot be read")
        return found
