"""What is known of a sweep, on the disk: one line for each run, named by what went into it."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

from pydantic import ValidationError

from physagent_studio.errors import InputError
from physagent_studio.session.lock import Lock
from physagent_studio.sweep.run import Ran

RUNS = "runs.jsonl"
"""The file of a sweep's folder that only grows; a line that a kill has cut off is run again."""


class Store:
    """The runs of a folder by key. One process writes it; what `add` returned from is kept."""

    def __init__(self, folder: Path) -> None:
        """Raises InputError where the folder cannot be written, or another sweep is at it."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.folder, path = folder, folder / RUNS
            self._lock = Lock(folder / ".lock")
            if not self._lock.taken:
                raise InputError(f"another sweep (process {self._lock.holder}) writes to {folder}")
            lines = list(_whole_lines(path))
            self._places = {key: place for key, place, lost in lines if not lost}
            end = sum(size for _, (_, size), _ in lines)
            self._file = path.open("a+b")
            # What follows the last whole line was never acknowledged.
            self._file.truncate(end)
        except OSError as error:
            raise InputError(f"{folder} cannot be written: {error.strerror}") from error

    def __contains__(self, key: str) -> bool:
        return key in self._places

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, key: str) -> Ran:
        """The run of a key, read from the disk: a sweep of any size fits into memory."""
        at, size = self._places[key]
        line = os.pread(self._file.fileno(), size, at)
        return Ran.model_validate(json.loads(line)["ran"])

    def add(self, key: str, ran: Ran) -> None:
        """Keeps a run; raises InputError where the disk does not take it."""
        kept = ran.model_dump(mode="json", exclude={"path", "objects"})
        line = json.dumps({"key": key, "ran": kept}, separators=(",", ":")).encode() + b"\n"
        at = self._file.seek(0, os.SEEK_END)
        try:
            self._file.write(line)
            self._file.flush()
        except OSError as error:
            raise InputError(f"{self.folder} cannot be written: {error.strerror}") from error
        self._places[key] = (at, len(line))

    def close(self) -> None:
        """Lets another sweep write here."""
        self._file.close()
        self._lock.release()


def _whole_lines(path: Path) -> Iterator[tuple[str, tuple[int, int], bool]]:
    """(key, (offset, bytes), lost) of each line up to the first that is not whole."""
    if not path.exists():
        return
    at = 0
    with path.open("rb") as file:
        for line in file:
            try:
                found = json.loads(line)
                lost = Ran.model_validate(found["ran"]).lost
            except (ValueError, KeyError, TypeError, ValidationError):
                return
            yield found["key"], (at, len(line)), lost
            at += len(line)
