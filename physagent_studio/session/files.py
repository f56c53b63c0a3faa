"""Content-addressed files: named by the hash of their bytes, so never rewritten."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from physagent_studio.errors import InputError


class FileStore:
    """Byte strings in a folder, by SHA-256. A key that was returned is on the disk."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def put(self, data: bytes, suffix: str) -> str:
        """Stores bytes durably and returns their key, such as `ab12….npz`."""
        key = hashlib.sha256(data).hexdigest() + suffix
        path = self._folder / key
        if not path.exists():
            self._write(path, data)
        return key

    def get(self, key: str) -> bytes:
        """The bytes of a key; an `InputError` where the file is gone or was changed."""
        path = self._folder / key
        try:
            data = path.read_bytes()
        except OSError as error:
            raise InputError(
                f"the session's file {key} cannot be read: {error.strerror}"
            ) from error
        if hashlib.sha256(data).hexdigest() != key.partition(".")[0]:
            raise InputError(f"the session's file {key} was changed after it was written")
        return data

    def __contains__(self, key: str) -> bool:
        return (self._folder / key).exists()

    def _write(self, path: Path, data: bytes) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        temporary = path.with_name(f".{path.name}.{os.getpid()}")
        with temporary.open("wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
