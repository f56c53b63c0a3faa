"""Content-addressed files, named by the hash of their bytes, so never rewritten; and a lock of the
kernel, which a process cannot keep beyond its end: one writer for each session."""

import fcntl
import hashlib
import os
import time
from contextlib import suppress
from pathlib import Path

from physagent_studio.errors import InputError, StorageError
from physagent_studio.session.schema import reported

QUOTA = 8 * 2**30
"""Bytes that the files of one session may take; `PHYSAGENT_QUOTA` says another number of GB."""


class FileStore:
    """Byte strings in a folder, by SHA-256. A key that was returned is on the disk."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._held: int | None = None

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

    def keys(self) -> set[str]:
        """All keys that there are."""
        with suppress(FileNotFoundError):
            return {one.name for one in os.scandir(self._folder) if not one.name.startswith(".")}
        return set()

    def _write(self, path: Path, data: bytes) -> None:
        self._make_room(len(data))
        temporary = path.with_name(f".{path.name}.{os.getpid()}")
        with reported(self._folder.parent.name):
            self._folder.mkdir(parents=True, exist_ok=True)
            try:
                with temporary.open("wb") as stream:
                    stream.write(data)
                    stream.flush()
                    os.fsync(stream.fileno())
                temporary.replace(path)
                _sync(self._folder)
            finally:
                with suppress(OSError):
                    temporary.unlink(missing_ok=True)

    def _make_room(self, size: int) -> None:
        if self._held is None:
            with suppress(FileNotFoundError):
                self._held = sum(one.stat().st_size for one in os.scandir(self._folder))
        self._held, quota = (self._held or 0) + size, _quota()
        if self._held > quota:
            held, self._held = self._held / 2**30, self._held - size
            raise StorageError(
                f"this session would have {held:.2f} GB of files, more than the"
                f" {quota / 2**30:g} GB that it may; `physagent session vacuum` frees what nothing"
                " refers to, and PHYSAGENT_QUOTA sets another number of GB"
            )


def _quota() -> int:
    said = os.environ.get("PHYSAGENT_QUOTA", "")
    try:
        return int(float(said) * 2**30) if said else QUOTA
    except ValueError as error:
        raise InputError(f"PHYSAGENT_QUOTA is '{said}'; it has to be a number of GB") from error


def _sync(folder: Path) -> None:
    """Makes a new name in a folder survive a power cut, as its bytes do."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


MOMENT = 0.02
"""Seconds after which nobody who only asked is in the way of a lock any more."""


def is_held(path: Path) -> bool:
    """Whether some process has the lock of that file, this one included."""
    try:
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(file)
    return False


class Lock:
    """Held as long as the object is not released; `taken` says whether it is ours."""

    def __init__(self, path: Path) -> None:
        self.taken, self.holder = False, ""
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError:
            # A folder that cannot be written is only read.
            self._file = -1
            return
        if not self._take():
            self.holder = os.pread(self._file, 32, 0).decode("ascii", "replace").strip()
            self.release()
            return
        self.taken = True
        self._sign()

    def _take(self) -> bool:
        """Tries twice: who only asks whether it `is_held` is in the way for a moment."""
        for pause in (0.0, MOMENT):
            time.sleep(pause)
            with suppress(OSError):
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return True
        return False

    def _sign(self) -> None:
        """Writes who holds it, for the message; on a full disk the lock holds all the same."""
        try:
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, str(os.getpid()).encode(), 0)
        except OSError:
            return

    def release(self) -> None:
        """Lets go of it."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1
        self.taken = False
