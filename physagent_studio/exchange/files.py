"""Files that are whole or not there: written beside their place, then moved into it."""

from __future__ import annotations

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
