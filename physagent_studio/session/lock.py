"""One writer for each session: a lock of the kernel, which a process cannot keep beyond its end."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path


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
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.holder = os.pread(self._file, 32, 0).decode("ascii", "replace").strip()
            self.release()
            return
        self.taken = True
        self._sign()

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
