"""A session as one file: a zip archive of its rows as JSON and of its files as they are.

Nothing of a stranger's archive is trusted: names have to be hashes, files are stored and not
compressed, rows are validated and written into tables of our own, and every file is decoded once in
a limited process before anything of it is kept.
"""

import hashlib
import io
import json
import os
import secrets
import sqlite3
import zipfile
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from physagent_studio.errors import InputError
from physagent_studio.jobs import Limits, within
from physagent_studio.records import LoopState, Round
from physagent_studio.records.rollout_io import rollout_from_bytes
from physagent_studio.session import arrays
from physagent_studio.session.care import COLUMNS, KEY, check, referred, rows_of
from physagent_studio.session.files import FileStore
from physagent_studio.session.schema import SCHEMA, TABLES, connect
from physagent_studio.session.session import MESH_SUFFIX, Session

FORMAT = 1
ENDING = ".physagent"
ROWS, MANIFEST = "rows.json", "manifest.json"
MAX_ROWS = 256 * 2**20
"""Bytes of the rows; a session of ten thousand rounds has a hundred million."""
MAX_FILES = 20_000
MAX_FILE = 256 * 2**20
"""Bytes of one file; the largest scene of a photograph has forty million."""
MAX_DIRECTORY = 4 * 2**20
"""Bytes of the archive's own list; longer ones take seconds to read."""
_STAMP = (1980, 1, 1, 0, 0, 0)


def export(session: Session, path: Path) -> Path:
    """Writes the session to one file, whole or not at all; returns where it is."""
    path = path if path.suffix else path.with_suffix(ENDING)
    partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with zipfile.ZipFile(partial, "w") as archive:
            manifest = {"format": FORMAT, "schema": SCHEMA, "session": session.id}
            _put(archive, MANIFEST, json.dumps(manifest).encode(), zipfile.ZIP_STORED)
            _put(archive, ROWS, rows_of(session).encode(), zipfile.ZIP_DEFLATED)
            for key in sorted(referred(session._db) & session.files.keys()):
                _put(archive, f"files/{key}", session.files.get(key), zipfile.ZIP_STORED)
        os.replace(partial, path)
    except OSError as error:
        raise InputError(f"{path} cannot be written ({error.strerror or error})") from error
    finally:
        partial.unlink(missing_ok=True)
    return path


def _put(archive: zipfile.ZipFile, name: str, data: bytes, method: int) -> None:
    archive.writestr(zipfile.ZipInfo(name, _STAMP), data, method)


def unpack(path: Path, folder: Path) -> None:
    """Makes the session of an archive in a new folder.

    Raises:
        InputError: it is none, is too large, was changed, or holds what no session has.
    """
    size = _checked_size(path)
    limits = Limits(0.8 + 4e-7 * size, 192 * 2**20 + 12 * min(size, MAX_FILE))
    folder.mkdir(parents=True)
    failed = f"{path.name} cannot be read as a session"
    within(limits, failed, _unpacked, str(path), str(folder))
    if problems := check(folder):
        raise InputError(f"{path.name} is no whole session: {problems[0]}")


def _checked_size(path: Path) -> int:
    try:
        size = path.stat().st_size
        with path.open("rb") as stream:
            stream.seek(max(0, size - 65_557))
            tail = stream.read()
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    at = tail.rfind(b"PK\5\6")
    if at < 0 or len(tail) < at + 22:
        raise InputError(f"{path.name} is no session archive")
    if int.from_bytes(tail[at + 12 : at + 16], "little") > MAX_DIRECTORY:
        raise InputError(f"{path.name} lists more files than a session has")
    return size


def _unpacked(source: str, target: str) -> None:
    """The task: reads, validates and writes; whatever fails leaves a folder to be removed."""
    try:
        with zipfile.ZipFile(source) as archive:
            entries = _entries(archive)
            manifest = _json(archive, MANIFEST)
            found = manifest.get("format"), manifest.get("schema")
            if found != (FORMAT, SCHEMA):
                raise InputError(
                    f"the archive is of format {found[0]} with tables {found[1]}; this version "
                    f"reads format {FORMAT} with tables {SCHEMA}"
                )
            rows = _json(archive, ROWS)
            files = FileStore(Path(target) / "files")
            for entry in entries:
                data = archive.read(entry)
                _check_file(entry.filename.removeprefix("files/"), data)
                files.put(data, "".join(entry.filename.partition(".")[1:]))
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError) as error:
        raise InputError(f"the archive is damaged: {error}") from error
    _write(rows, Path(target) / "session.db")


def _entries(archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """The files of an archive, after all that its list says was found to be a session's."""
    found = []
    for entry in archive.infolist():
        if entry.filename == ROWS and entry.file_size <= MAX_ROWS:
            continue
        if entry.filename == MANIFEST and entry.file_size <= 65_536:
            continue
        folder, _, key = entry.filename.rpartition("/")
        if folder != "files" or not KEY.fullmatch(key) or entry.file_size > MAX_FILE:
            raise InputError(f"'{entry.filename[:80]}' has no place in a session")
        if entry.compress_type != zipfile.ZIP_STORED:
            raise InputError(f"'{key[:12]}…' is compressed once more, as no session's file is")
        found.append(entry)
    if len(found) > MAX_FILES:
        raise InputError(f"the archive has {len(found)} files; at most {MAX_FILES} are read")
    return found


def _json(archive: zipfile.ZipFile, name: str) -> dict[str, Any]:
    try:
        data = json.loads(archive.read(name))
    except (KeyError, ValueError, RecursionError) as error:
        raise InputError(f"the archive has no {name} that can be read") from error
    if not isinstance(data, dict):
        raise InputError(f"the {name} of the archive is not what it should be")
    return data


def _check_file(key: str, data: bytes) -> None:
    """That a file is what its name says, and can be decoded."""
    stem, _, ending = key.partition(".")
    if hashlib.sha256(data).hexdigest() != stem:
        raise InputError(f"the file {stem[:12]}… was changed after it was written")
    try:
        if ending == "png":
            arrays.from_png(data)
        elif ending == "npz" or key.endswith(MESH_SUFFIX):
            _check_arrays(data)
        else:
            raise InputError(f"a session has no files of the kind '{ending}'")
    except (ValueError, KeyError, TypeError, AssertionError, OSError, zipfile.BadZipFile) as error:
        raise InputError(f"the file {stem[:12]}… is damaged: {error}") from error


def _check_arrays(data: bytes) -> None:
    with zipfile.ZipFile(io.BytesIO(data)) as inner:
        names = {one.filename for one in inner.infolist()}
    if "meta.npy" in names:
        rollout_from_bytes(data)
        return
    _, meta = arrays.unpack(data)
    if "frames" in meta:
        arrays.unpack_frames(data)
    elif "state" in meta:
        arrays.unpack_scene(data, None)


def _write(rows: dict[str, Any], path: Path) -> None:
    """The rows in tables of our own; an `InputError` where one is not what its table holds."""
    db = connect(path)
    db.executescript(TABLES)
    try:
        db.execute("BEGIN")
        for table, columns in COLUMNS.items():
            marks = ", ".join("?" * len(columns))
            for row in rows.get(table, ()):
                if len(row) != len(columns) or any(isinstance(v, list | dict) for v in row):
                    raise InputError(f"a row of '{table}' in the archive has another form")
                db.execute(f"INSERT INTO {table} VALUES ({marks})", row)
        for (text,) in db.execute("SELECT payload FROM rounds"):
            Round.model_validate_json(text)
        for (text,) in db.execute("SELECT payload FROM states"):
            LoopState.model_validate_json(text)
        db.execute("COMMIT")
    except (ValidationError, TypeError, ValueError, OverflowError) as error:
        raise InputError(f"the rows of the archive are not those of a session: {error}") from error
    except sqlite3.Error as error:
        raise InputError(f"the rows of the archive contradict each other: {error}") from error
    finally:
        db.close()
