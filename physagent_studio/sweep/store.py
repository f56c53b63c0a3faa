"""What is known of a sweep, on the disk: one line for each run, named by what went into it."""

from __future__ import annotations

import json
import os
from pathlib import Path

from pydantic import ValidationError

from physagent_studio.errors import InputError
from physagent_studio.session.lock import Lock
from physagent_studio.sweep.run import Ran


class Store:
    """The runs of a folder by key. One process writes it; what `add` returned from is kept.

    Only places are held in memory. A line that a kill has cut off is dropped, and run again.
    """

    def __init__(self, folder: Path) -> None:
        """Raises InputError where the folder cannot be written, or another sweep is at it."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = Lock(folder / ".lock")
            if not self._lock.taken:
                raise InputError(f"another sweep (process {self._lock.holder}) writes to {folder}")
            self._file = (folder / "runs.jsonl").open("a+b")
            self._places = self._read()
        except OSError as error:
            raise InputError(f"{folder} cannot be written: {error.strerror}") from error

    def _read(self) -> dict[str, tuple[int, int]]:
        """(offset, bytes) of each whole line that another sweep need not try again."""
        places, at = dict[str, tuple[int, int]](), 0
        self._file.seek(0)
        for line in self._file:
            try:
                found = json.loads(line)
                if not Ran.model_validate(found["ran"]).lost:
                    places[found["key"]] = (at, len(line))
            except (ValueError, KeyError, TypeError, ValidationError):
                break
            at += len(line)
        self._file.truncate(at)
        return places

    def __contains__(self, key: str) -> bool:
        return key in self._places

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, key: str) -> Ran:
        at, size = self._places[key]
        line = os.pread(self._file.fileno(), size, at)
        return Ran.model_validate(json.loads(line)["ran"])

    def add(self, key: str, ran: Ran) -> None:
        """Keeps a run; raises InputError where the disk does not take it."""
        found = {"key": key, "ran": ran.model_dump(mode="json", exclude={"path", "objects"})}
        line = json.dumps(found, separators=(",", ":")).encode() + b"\n"
        try:
            self._places[key] = (self._file.seek(0, os.SEEK_END), len(line))
            self._file.write(line)
            self._file.flush()
        except OSError as error:
            raise InputError(f"a run cannot be kept: {error.strerror}") from error

    def close(self) -> None:
        """Lets another sweep write here."""
        self._file.close()
        self._lock.release()
