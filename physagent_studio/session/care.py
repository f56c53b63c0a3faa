"""Looking after sessions: whether one is whole, making it so, and letting go of what it left."""

import json
import re
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from physagent_studio.errors import InputError, StorageError
from physagent_studio.records import LoopState, Round
from physagent_studio.session.files import FileStore
from physagent_studio.session.schema import TABLES, connect, linked
from physagent_studio.session.session import MESH_SUFFIX, Session, now

KEY = re.compile(r"[0-9a-f]{64}(?:\.[a-z0-9.]{1,12})?")
COLUMNS = {
    "meta": ("key", "value"),
    "rounds": ("id", "number", "payload", "parent"),
    "states": ("seq", "label", "payload"),
    "log": ("seq", "at", "kind", "author", "payload", "link"),
    "answers": ("seq", "key", "used", "payload"),
}
"""The tables of a session with their columns, in an order in which they can be written."""


def referred(db: sqlite3.Connection) -> set[str]:
    """Every key that some row names; a bare one is an asset, the form of a thing."""
    found: set[str] = set()
    for table, column in (("meta", "value"), ("rounds", "payload"), ("states", "payload")):
        for (text,) in db.execute(f"SELECT {column} FROM {table}"):
            found |= set(KEY.findall(text))
    return found | {key + MESH_SUFFIX for key in found if "." not in key}


def check(folder: Path) -> list[str]:
    """What is wrong with a session, in sentences; an empty list where nothing is."""
    session = Session(folder, writing=False)
    try:
        return [*_faults(session), *_lost_files(session)]
    except sqlite3.DatabaseError as error:
        return [f"the database is damaged: {error}"]
    finally:
        session.close()


def _faults(session: Session) -> Iterator[str]:
    db = session._db
    (said,) = db.execute("PRAGMA integrity_check").fetchone()
    if said != "ok":
        yield f"the database is damaged: {said}"
    known = dict(db.execute("SELECT id, payload FROM rounds"))
    for key, text in known.items():
        if (one := _valid(Round, text)) is None:
            yield f"round {key} cannot be read"
        elif isinstance(one, Round) and one.parent is not None and one.parent not in known:
            yield f"round {key} grew from {one.parent}, which is not there"
    states = dict(db.execute("SELECT seq, payload FROM states"))
    if session._cursor not in states:
        yield "the present state is not there"
    for seq, text in states.items():
        state = _valid(LoopState, text)
        if state is None:
            yield f"state {seq} cannot be read"
        elif isinstance(state, LoopState) and state.head is not None and state.head not in known:
            yield f"state {seq} is at round {state.head}, which is not there"
    yield from _broken_chain(db) if session._version > 1 else ()


def _broken_chain(db: sqlite3.Connection) -> Iterator[str]:
    before = ""
    for seq, *row, link in db.execute("SELECT seq, at, kind, author, payload, link FROM log"):
        if link is not None and link != linked(before, *row):
            yield f"entry {seq} of the log, or the one before it, was changed"
        before = link or ""


def _lost_files(session: Session) -> Iterator[str]:
    there = session.files.keys()
    for key in sorted(referred(session._db)):
        if "." in key and key not in there and not key.endswith(MESH_SUFFIX):
            yield f"the file {key[:12]}… is not there"
    for key in sorted(there):
        try:
            session.files.get(key)
        except InputError as error:
            yield str(error)


def _valid(kind: type[Round] | type[LoopState], text: str) -> Round | LoopState | None:
    try:
        return kind.model_validate_json(text)
    except ValidationError:
        return None


def repair(folder: Path) -> list[str]:
    """Makes a session whole again, as far as it can be read; says what was done.

    The damaged database stays beside the new one, under another name.
    """
    problems = check(folder)
    _own(folder)
    for left in (folder / "files").glob(".*"):
        left.unlink()
    if not problems:
        return []
    path = folder / "session.db"
    fresh = folder / "repaired.db"
    fresh.unlink(missing_ok=True)
    db = connect(fresh)
    db.executescript(TABLES)
    there = FileStore(folder / "files")
    done = list(_carried_over(path, db, there))
    db.close()
    stamp = now().replace(":", "").replace(".", "")
    for ending in ("", "-wal", "-shm"):
        old = path.with_name(path.name + ending)
        if old.exists():
            old.replace(path.with_name(f"damaged-{stamp}.db{ending}"))
    fresh.replace(path)
    for ending in ("-wal", "-shm"):
        fresh.with_name(fresh.name + ending).unlink(missing_ok=True)
    session = Session(folder)
    session.record("repair", "physagent", {"problems": problems, "done": done})
    session.close()
    return done


def _carried_over(path: Path, fresh: sqlite3.Connection, files: FileStore) -> Iterator[str]:
    """Copies every row that can be read and stands for something."""
    old = connect(path, writing=False)
    rounds: set[str] = set()
    states: list[int] = []
    for table, columns in COLUMNS.items():
        for row in _rows(old, table, columns):
            kept = list(row)
            if table == "rounds":
                whole = _whole_round(str(row[2]), files)
                if whole is None:
                    yield f"round {row[0]} was left out"
                    continue
                kept[2] = whole
                rounds.add(str(row[0]))
            if table == "states":
                state = _valid(LoopState, str(row[2]))
                if not isinstance(state, LoopState) or state.head not in {None, *rounds}:
                    yield f"state {row[0]} was left out"
                    continue
                states.append(int(str(row[0])))
            if table == "log":
                kept[-1] = None  # Its links are of a log that nobody can vouch for any more.
            marks = ", ".join("?" * len(columns))
            fresh.execute(f"INSERT OR IGNORE INTO {table} VALUES ({marks})", kept)
    old.close()
    if not states:
        raise StorageError("no state of this session can be read; nothing was changed")
    cursor = int(fresh.execute("SELECT value FROM meta WHERE key = 'cursor'").fetchone()[0])
    if cursor not in states:
        best = max((one for one in states if one <= cursor), default=states[0])
        fresh.execute("UPDATE meta SET value = ? WHERE key = 'cursor'", (str(best),))
        yield f"went back to state {best}"


def _rows(
    db: sqlite3.Connection, table: str, columns: tuple[str, ...]
) -> Iterator[tuple[object, ...]]:
    """The rows of a table up to the first that cannot be read, then from the other end."""
    seen: set[object] = set()
    for order in ("ASC", "DESC"):
        try:
            for row in db.execute(f"SELECT {', '.join(columns)} FROM {table} ORDER BY 1 {order}"):
                if row[0] in seen:
                    break
                seen.add(row[0])
                yield row
        except sqlite3.DatabaseError:
            continue


def _whole_round(text: str, files: FileStore) -> str | None:
    """A round without the files that are gone; it can be run again. None where nothing is left."""
    one = _valid(Round, text)
    if not isinstance(one, Round):
        return None
    gone = {
        name: None
        for name in ("scene", "rollout", "frames")
        if (key := getattr(one, name)) is not None and not _is_whole(files, key)
    }
    return one.model_copy(update=gone).model_dump_json() if gone else text


def _is_whole(files: FileStore, key: str) -> bool:
    try:
        files.get(key)
    except InputError:
        return False
    return True


def vacuum(folder: Path) -> tuple[int, int]:
    """Removes the files that nothing refers to and packs the database: (files, bytes) freed."""
    with _own(folder, keep=True) as session:
        kept, count, size = referred(session._db), 0, 0
        for path in (folder / "files").glob("*"):
            if path.name not in kept:
                count, size = count + 1, size + path.stat().st_size
                path.unlink()
        before = (folder / "session.db").stat().st_size
        session._db.execute("VACUUM")
        session._db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        return count, size + max(before - (folder / "session.db").stat().st_size, 0)


def _own(folder: Path, *, keep: bool = False) -> Session:
    """The session, to be changed; a `StorageError` where another process writes it."""
    session = Session(folder)
    if session.read_only:
        said = session.read_only
        session.close()
        raise StorageError(said)
    if not keep:
        session.close()
    return session


def audit(folder: Path) -> list[dict[str, Any]]:
    """The log of a session: who did what and when, with the hashes of programs."""
    with Session(folder, writing=False) as session:
        return [
            {("decided" if key == "kind" else key): value for key, value in payload.items()}
            | {"at": at, "kind": kind, "author": author}
            for at, kind, author, payload in session.log()
        ]


def rows_of(session: Session) -> str:
    """All tables of a session as JSON."""
    db = session._db
    tables = {
        table: [list(row) for row in db.execute(f"SELECT {', '.join(columns)} FROM {table}")]
        for table, columns in COLUMNS.items()
    }
    return json.dumps(tables)
