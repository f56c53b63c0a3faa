"""Fetching the files of learned models: over HTTPS, resumed where it broke off, checked at the end.

The only room of reconstruction that opens a connection, and only when a person asks for it.
"""

import http.client
import os
import shutil
import urllib.error
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO
from urllib.parse import urlsplit

from physagent_studio.errors import InputError
from physagent_studio.reconstruction.learned.zoo import (
    ZooModel,
    condition,
    is_sound,
    models_folder,
    part_of,
    path_of,
)


@dataclass(frozen=True, slots=True)
class FetchSettings:
    """When a connection is given up."""

    silence_s: float = 30.0  # 5..120: without any byte a connection counts as broken
    max_attempts: int = 5  # count, 1..20: connections in a row that break without getting further
    block_bytes: int = 1 << 18  # 4096..1e7: between two reports of progress


FETCH = FetchSettings()

LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""Hosts that may be asked without encryption: nobody listens on the way."""

Progress = Callable[[int, int], None]
"""Told how many bytes are there, and of how many."""


def fetch(
    model: ZooModel, folder: Path | None = None, progress: Progress = lambda have, whole: None
) -> Path:
    """The model's file, fetched unless it is there. What an earlier call has fetched is kept.

    Raises InputError where there is no way to it, or what came is not the model.
    """
    path = _writable(path_of(model, folder or models_folder()), model.size)
    if condition(model, path.parent) == "ready":
        return path
    part, broken, reason = part_of(path), 0, ""
    furthest = _size(part)
    while _size(part) < model.size and broken < FETCH.max_attempts:
        try:
            _continue(model, part, progress)
        except (OSError, http.client.HTTPException) as error:
            reason = _reason(error)
            if isinstance(error, urllib.error.HTTPError) and error.code < 500:
                break
        broken = 0 if _size(part) > furthest else broken + 1
        furthest = max(furthest, _size(part))
    if _size(part) < model.size:
        raise InputError(
            f"{model.name} could not be fetched from {model.url} ({reason or 'it ends too early'});"
            f" the same command goes on from there, and `physagent models fetch {model.name}"
            " --from FILE` takes a copy from elsewhere"
        )
    return _accepted(model, part, path)


def take(model: ZooModel, source: Path, folder: Path | None = None) -> Path:
    """The model's file, copied from a person's. Raises InputError where that is not the model."""
    path = _writable(path_of(model, folder or models_folder()), model.size)
    try:
        if source.stat().st_size != model.size or not is_sound(model, source):
            raise InputError(f"{source} is not {model.file}: its size or SHA-256 is another")
        shutil.copyfile(source, part_of(path))
    except OSError as error:
        raise InputError(f"{source} cannot be copied to {path}: {error.strerror}") from error
    return _accepted(model, part_of(path), path)


def remove(model: ZooModel, folder: Path | None = None) -> bool:
    """Deletes the model's file, and what was fetched of it; whether there was anything."""
    path = path_of(model, folder)
    there = [one for one in (path, part_of(path)) if one.is_file()]
    for one in there:
        one.unlink()
    return bool(there)


class _Encrypted(urllib.request.HTTPRedirectHandler):
    """Follows a server to another place only where nobody can read or change what comes."""

    def redirect_request(
        self,
        req: urllib.request.Request,
        fp: IO[bytes],
        code: int,
        msg: str,
        headers: http.client.HTTPMessage,
        newurl: str,
    ) -> urllib.request.Request | None:
        _check_address(newurl)
        return super().redirect_request(req, fp, code, msg, headers, newurl)


def _check_address(url: str) -> None:
    parts = urlsplit(url)
    if parts.scheme != "https" and not (parts.scheme == "http" and parts.hostname in LOOPBACK):
        raise InputError(f"{parts.scheme}://{parts.hostname} is not encrypted and is not asked")


def _continue(model: ZooModel, part: Path, progress: Progress) -> None:
    """One connection: what it brings is added to the part; ends with it."""
    _check_address(model.url)
    have = _size(part)
    request = urllib.request.Request(model.url, headers={"Range": f"bytes={have}-"} if have else {})
    opener = urllib.request.build_opener(_Encrypted())
    with opener.open(request, timeout=FETCH.silence_s) as answer:
        goes_on = answer.status == 206 and _begins_at(answer.headers.get("Content-Range", ""), have)
        if answer.status == 206 and not goes_on:
            part.unlink(missing_ok=True)
            raise OSError("the server goes on in another place")
        # A server that begins anew is taken at its word.
        have = have if goes_on else 0
        with part.open("ab" if goes_on else "wb") as file:
            while block := answer.read1(min(FETCH.block_bytes, model.size + 1 - have)):
                file.write(block)
                have += len(block)
                progress(min(have, model.size), model.size)
                if have > model.size:
                    return  # it is another file: its hash will say so


def _begins_at(content_range: str, have: int) -> bool:
    """Whether an answer such as `bytes 100-199/200` begins where we have ended."""
    return have > 0 and content_range.startswith(f"bytes {have}-")


def _accepted(model: ZooModel, part: Path, path: Path) -> Path:
    """Puts the part in its place. Raises InputError where it is not the model, and drops it."""
    if not is_sound(model, part):
        part.unlink()
        raise InputError(
            f"what came for {model.name} is not that file (its SHA-256 is another); it was deleted"
        )
    os.replace(part, path)
    return path


def _writable(path: Path, size: int) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(path.parent).free + _size(part_of(path))
    except OSError as error:
        raise InputError(f"{path.parent} cannot be written: {error.strerror}") from error
    if free < size:
        raise InputError(f"{path.parent} has {free / 1e6:.0f} MB free; {size / 1e6:.0f} are needed")
    return path


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else 0


def _reason(error: Exception) -> str:
    if isinstance(error, urllib.error.HTTPError):
        return f"the server says {error.code} {error.reason}"
    if isinstance(error, TimeoutError):
        return f"the server was silent for {FETCH.silence_s:g} s"
    return str(getattr(error, "reason", "") or error) or type(error).__name__
