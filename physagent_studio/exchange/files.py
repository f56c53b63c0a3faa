"""Files that are whole or not there: written beside their place, then moved into it."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from physagent_studio.errors import InputError


@contextmanager
def written(path: Path) -> Iterator[Path]:
    """A place to write to; becomes `path` when the block ends well, and goes when it does not.

    Raises:
        InputError: the folder cannot be made or written, or the disk is full.
    """
    partial = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            raise InputError(f"{path} is a folder, so no file can be written there")
        yield partial
        os.replace(partial, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{path} cannot be written ({reason})") from error
    finally:
        if partial.parent.is_dir():
            partial.unlink(missing_ok=True)


def bytes_of(path: Path, most: int) -> bytes:
    """A file of at most so many bytes. Raises InputError."""
    try:
        if path.stat().st_size > most:
            raise InputError(f"{path} is larger than {most} bytes")
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error


def text_of(path: Path, most: int) -> str:
    """A UTF-8 text of at most so many bytes. Raises InputError."""
    try:
        return bytes_of(path, most).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no UTF-8 text") from error
