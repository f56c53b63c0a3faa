"""The tables of a session, how older ones become these, and what a failing disk is called."""

import hashlib
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from physagent_studio.errors import InputError, StorageError

SCHEMA = 2
BUSY_SECONDS = 10.0
"""How long a transaction waits for another process that is reading or listing."""
TABLES = """
CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS rounds (
    id TEXT PRIMARY KEY, number INTEGER, payload TEXT NOT NULL, parent TEXT);
CREATE TABLE IF NOT EXISTS states (
    seq INTEGER PRIMARY KEY AUTOINCREMENT, label TEXT NOT NULL, payload TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS log (
    seq INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, kind TEXT NOT NULL,
    author TEXT NOT NULL, payload TEXT NOT NULL, link TEXT);
CREATE TABLE IF NOT EXISTS answers (
    seq INTEGER PRIMARY KEY AUTOINCREMENT, key TEXT NOT NULL, used INTEGER NOT NULL DEFAULT 0,
    payload TEXT NOT NULL);
CREATE TRIGGER IF NOT EXISTS log_is_not_changed BEFORE UPDATE ON log
    BEGIN SELECT RAISE(ABORT, 'the log is only added to'); END;
CREATE TRIGGER IF NOT EXISTS log_is_not_cut BEFORE DELETE ON log
    BEGIN SELECT RAISE(ABORT, 'the log is only added to'); END;
"""
_FROM = {
    1: """
ALTER TABLE rounds ADD COLUMN parent TEXT;
ALTER TABLE log ADD COLUMN link TEXT;
UPDATE rounds SET parent = json_extract(payload, '$.parent');
"""
}
"""What has to be done to the tables of each older version, to be of the next."""
_WORDS = {
    "full": "the disk is full",
    "No space left": "the disk is full",
    "disk I/O": "the disk gave an error",
    "Input/output": "the disk gave an error",
    "readonly": "it cannot be written",
    "unable to open": "it cannot be opened",
    "locked": "another process holds it",
}


def connect(path: Path, *, writing: bool = True) -> sqlite3.Connection:
    """The database, durable: a transaction that has ended survives a kill and a power cut."""
    db = sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=BUSY_SECONDS)
    if writing:
        db.execute("PRAGMA journal_mode = WAL")
        db.execute("PRAGMA synchronous = FULL")
    else:
        db.execute("PRAGMA query_only = 1")
    return db


def migrate(db: sqlite3.Connection, name: str, *, writing: bool) -> int:
    """Brings the tables to the present version, all or nothing; returns the version they have.

    Raises:
        InputError: a newer version of this program has made them, or they are none of it.
    """
    row = db.execute("SELECT value FROM meta WHERE key = 'schema'").fetchone()
    version = int(row[0]) if row else 0
    if not 1 <= version <= SCHEMA:
        raise InputError(f"session {name} has format {version}; this version reads 1 … {SCHEMA}")
    if version == SCHEMA or not writing:
        return version
    steps = "".join(_FROM[number] for number in range(version, SCHEMA))
    done = f"UPDATE meta SET value = '{SCHEMA}' WHERE key = 'schema';"
    with reported(name):
        db.executescript(f"BEGIN IMMEDIATE;{steps}{TABLES}{done}COMMIT;")
    return SCHEMA


@contextmanager
def reported(name: str) -> Iterator[None]:
    """What SQLite or the disk says becomes a `StorageError` in a sentence."""
    try:
        yield
    except (sqlite3.OperationalError, OSError) as error:
        said = str(error)
        why = next((words for key, words in _WORDS.items() if key in said), said)
        raise StorageError(
            f"session {name} could not be written: {why}. Everything up to the step before is"
            " kept; make room or free it, and try again"
        ) from error


def linked(before: str, *parts: str) -> str:
    """The link of a log's entry to the one before, so that a change of either shows."""
    return hashlib.sha256("\n".join((before, *parts)).encode()).hexdigest()
