"""`Prior`: an exported motion prior, read frame by frame."""

import json
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.errors import InputError
from physagent_studio.exchange.files import bytes_of, text_of
from physagent_studio.exchange.prior.export import FORMAT, MARK, META
from physagent_studio.jobs import Limits, within
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.rollout_io import rollout_from_bytes
from physagent_studio.rendering import Flow

MAX_META, MAX_PROGRAM = 16 * 2**20, 16 * 2**20
MAX_ROLLOUT, MAX_PNG = 512 * 2**20, 128 * 2**20
"""Bytes of files that are read."""
MAX_PIXEL = 24
"""Bytes for each pixel of what an archive of a frame holds: 18 of flow, forward and backward."""
LARGEST = 10_000
"""Pixels each way, and frames."""
OLDEST = 4
"""The first format with flow both ways; 5 added captions, which no bundle reads."""


@dataclass(frozen=True, eq=False, slots=True)
class Prior:
    """A folder that `export_motion_prior` has finished, and what its manifest says.

    reading: told what is read of which frame; it may raise to end that.
    """

    folder: Path
    meta: dict[str, Any]
    reading: Callable[[str], None] = lambda what: None

    @classmethod
    def open(cls, folder: Path | str) -> Self:
        """Raises InputError where the folder is no finished export."""
        folder = Path(folder)
        try:
            meta = json.loads(text_of(folder / META, MAX_META))
        except (InputError, ValueError, RecursionError) as error:
            raise InputError(f"{folder} is no finished motion prior: {META} cannot be read") from (
                error
            )
        if not isinstance(meta, dict) or meta.get("kind") != MARK:
            raise InputError(f"{folder / META} is not the manifest of a motion prior")
        made = meta.get("made_from")
        number = made.get("format", 0) if isinstance(made, dict) else 0
        if not isinstance(number, int) or not OLDEST <= number <= FORMAT:
            raise InputError(
                f"{folder} is a motion prior of format {number}; this version reads {OLDEST} … "
                f"{FORMAT}: export its session again"
            )
        size = meta.get("size")
        numbers = [*(size if isinstance(size, list) else ()), meta.get("frames")]
        if len(numbers) != 3 or any(type(n) is not int or not 0 < n <= LARGEST for n in numbers):
            raise InputError(f"{folder / META} says no size and number of frames that a clip has")
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
        return self._png("frames/frame", number)[..., ::-1]

    def ids(self, number: int) -> NDArray[np.int32]:
        """(H, W) index of the object, −1 for the background."""
        return self._png("ids/ids", number).astype(np.int32) - 1

    def depth(self, number: int) -> NDArray[np.float32]:
        """(H, W) m along the optical axis, inf for the background."""
        return self._npz("depth/depth", number, "depth")[0]

    def flow(self, number: int) -> Flow:
        """From frame `number` to the next."""
        return Flow(*self._npz("flow/flow", number, "flow", "visible"))

    def backward(self, number: int) -> Flow:
        """From the frame after `number` back to it."""
        return Flow(*self._npz("flow/flow", number, "backward", "backward_visible"))

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """All of them, one at a time."""
        return (self.picture(number) for number in range(self.frames))

    def rollout(self) -> Rollout:
        """What was simulated."""
        data = bytes_of(self.folder / "rollout.npz", MAX_ROLLOUT)
        limits = Limits(0.8 + 4e-7 * len(data), 128 * 2**20 + 12 * len(data))
        failed = f"rollout.npz in {self.folder} cannot be read"
        return within(limits, failed, rollout_from_bytes, data)

    def png(self, stem: str, number: int) -> bytes:
        """The file of a picture as it is, by its folder and name."""
        try:
            return bytes_of(self._place(stem, number, "png"), MAX_PNG)
        except InputError as error:
            raise InputError(f"{self.folder}/{stem}_{number:04d}.png is missing") from error

    def _png(self, stem: str, number: int) -> NDArray[Any]:
        data = np.frombuffer(self.png(stem, number), np.uint8)
        # Its header says how large it is to be.
        fits = bytes(data[16:24]) == struct.pack(">II", *self.size)
        found = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if fits else None
        if found is None:
            raise InputError(f"{self.folder}/{stem}_{number:04d}.png is damaged")
        return found

    def _npz(self, stem: str, number: int, *names: str) -> list[NDArray[Any]]:
        try:
            place = self._place(stem, number, "npz")
            with zipfile.ZipFile(place) as archive:
                told = sum(one.file_size for one in archive.infolist())
            if told > MAX_PIXEL * self.size[0] * self.size[1] + 2**16:
                raise ValueError("too large")
            with np.load(place, allow_pickle=False) as found:
                return [found[name] for name in names]
        except (OSError, ValueError, KeyError, zipfile.BadZipFile, zlib.error) as error:
            what = f"{self.folder}/{stem}_{number:04d}.npz"
            raise InputError(f"{what} is missing or damaged") from error

    def _place(self, stem: str, number: int, ending: str) -> Path:
        self.reading(f"{stem.partition('/')[0]} {number + 1} of {self.frames}")
        return self.folder / f"{stem}_{number:04d}.{ending}"
