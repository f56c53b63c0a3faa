"""Files of an export: written whole, fast rather than small, and their hashes kept."""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physagent_studio.exchange.files import written
from physagent_studio.exchange.prior.stretches import Stretches


@dataclass(frozen=True, eq=False, slots=True)
class Sink:
    """A folder that is written into. hashes: SHA-256 by path within it."""

    folder: Path
    hashes: dict[str, str] = field(default_factory=dict)
    stretches: Stretches = field(default_factory=Stretches)

    def data(self, name: str, data: bytes) -> None:
        """Writes bytes. Raises InputError where the place cannot be written."""
        with written(self.folder / name) as partial:
            partial.write_bytes(data)
        self.hashes[name] = hashlib.sha256(data).hexdigest()

    def text(self, name: str, text: str) -> None:
        """Writes UTF-8."""
        self.data(name, text.encode("utf-8"))

    def json(self, name: str, value: Any) -> None:
        """Writes JSON that a person can read."""
        self.text(name, json.dumps(value, indent=2) + "\n")

    def png(self, name: str, picture: NDArray[Any]) -> None:
        """Writes a PNG of (H, W) or of (H, W, 3) RGB, 8 or 16 bit, as it is."""
        self.data(name, self.stretches.png(_kind(name), picture))

    def npz(self, name: str, **arrays: NDArray[Any]) -> None:
        """Writes arrays as `numpy.load` reads them."""
        self.data(name, self.stretches.npz(_kind(name), arrays))

    def npy(self, name: str, array: NDArray[Any]) -> None:
        """Writes one array, not compressed, as generators map it into memory."""
        out = io.BytesIO()
        np.lib.format.write_array(out, np.ascontiguousarray(array))
        self.data(name, out.getvalue())

    def adopt(self, name: str) -> None:
        """Takes down the hash of a file that another writer has made there."""
        with open(self.folder / name, "rb") as file:
            self.hashes[name] = hashlib.file_digest(file, "sha256").hexdigest()


def _kind(name: str) -> str:
    """What files of a clip have in common: folder, ending, and name but for digits."""
    return name.rstrip("0123456789.npgz") + name[-3:]
