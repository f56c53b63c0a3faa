"""One session: what was acknowledged is on the disk, and reopens as it was.

Rounds and the decision log are only ever added to; a row of `states` is one step of undo.
"""

from __future__ import annotations

import functools
import json
import sqlite3
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from physagent_studio.errors import InputError
from physagent_studio.records import Case, Image, LoopState, Mesh, Round, Scene
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.rollout_io import rollout_from_bytes, rollout_to_bytes
from physagent_studio.session import arrays
from physagent_studio.session.files import FileStore

SCHEMA = 1
KEPT_ROLLOUTS = 8
MESH_SUFFIX = ".mesh.npz"
_TABLES = """
CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS rounds (id TEXT PRIMARY KEY, number INTEGER, payload TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS states (
    seq INTEGER PRIMARY KEY AUTOINCREMENT, label TEXT NOT NULL, payload TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS log (
    seq INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, kind TEXT NOT NULL,
    author TEXT NOT NULL, payload TEXT NOT NULL);
"""


def now() -> str:
    """The present time, ISO 8601 in UTC."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


class Session:
    """An open session. Not thread-safe: it belongs to one worker."""

    def __init__(self, folder: Path) -> None:
        if not (folder / "session.db").is_file():
            raise InputError(f"there is no session in {folder}")
        self.folder = folder
        self.files = FileStore(folder / "files")
        self._db = _connect(folder / "session.db")
        version = int(self.meta("schema") or 0)
        if version != SCHEMA:
            self._db.close()
            raise InputError(
                f"session {folder.name} has format {version}; this version reads format {SCHEMA}"
            )
        self._scenes: dict[str, Scene] = {}
        self._meshes: dict[str, Mesh] = {}
        self._known_rounds: dict[str, Round] = {}
        self._rollouts: OrderedDict[str, Rollout] = OrderedDict()

    @classmethod
    def create(cls, folder: Path, case: Case, title: str, state: LoopState) -> Session:
        """Makes the folder and its first state."""
        folder.mkdir(parents=True)
        db = _connect(folder / "session.db")
        with db:
            db.executescript(_TABLES)
        files = FileStore(folder / "files")
        key = files.put(arrays.png(case.image), ".png") if case.image is not None else ""
        facts = {
            "schema": str(SCHEMA),
            "title": title,
            "created": now(),
            "image": key,
            "case": json.dumps(arrays.case_json(case)),
            "cursor": "0",
        }
        with db:
            db.execute("BEGIN IMMEDIATE")
            db.executemany("INSERT INTO meta VALUES (?, ?)", facts.items())
        db.close()
        session = cls(folder)
        session.save(state, checkpoint="opened")
        return session

    @property
    def id(self) -> str:
        """The session's id, its folder's name."""
        return self.folder.name

    @property
    def title(self) -> str:
        """What the session is called in lists."""
        return self.meta("title") or self.id

    def rename(self, title: str) -> None:
        """Gives it another title."""
        with self._transaction():
            self._set_meta("title", title)

    @property
    def case(self) -> Case:
        """The case it was opened with."""
        return arrays.case_from_json(json.loads(self.meta("case") or "{}"), self._image)

    @property
    def prompt(self) -> str:
        """The case's sentence, without reading its picture."""
        return json.loads(self.meta("case") or "{}").get("prompt", "")

    def replace_case(self, case: Case) -> None:
        """Changes prompt, clicks or landmarks; the picture stays."""
        with self._transaction():
            self._set_meta("case", json.dumps(arrays.case_json(case)))

    # --- state -------------------------------------------------------------------------------

    def load(self) -> LoopState:
        """The state at the cursor, with all rounds."""
        row = self._db.execute(
            "SELECT payload FROM states WHERE seq = ?", (self._cursor,)
        ).fetchone()
        if row is None:
            raise InputError(f"session {self.id} has no state at its cursor")
        return self._with_rounds(row[0])

    def summary(self) -> tuple[int, str]:
        """How many rounds there are and how the loop stands, without reading them."""
        (rounds,) = self._db.execute("SELECT COUNT(*) FROM rounds").fetchone()
        row = self._db.execute(
            "SELECT payload FROM states WHERE seq = ?", (self._cursor,)
        ).fetchone()
        return int(rounds), str(json.loads(row[0])["outcome"]) if row else "running"

    def save(self, state: LoopState, *, checkpoint: str | None = None) -> None:
        """Acknowledges a state: when this returns, it survives a kill.

        checkpoint: a label starts a new step of undo; None replaces the present one.
        """
        payload = state.model_dump_json(exclude={"rounds"})
        with self._transaction():
            for item in state.rounds:
                if self._known_rounds.get(item.id) is not item:
                    self._db.execute(
                        "INSERT INTO rounds VALUES (?, ?, ?) "
                        "ON CONFLICT (id) DO UPDATE SET payload = excluded.payload",
                        (item.id, item.number, item.model_dump_json()),
                    )
                    self._known_rounds[item.id] = item
            if checkpoint is None:
                self._db.execute(
                    "UPDATE states SET payload = ? WHERE seq = ?", (payload, self._cursor)
                )
            else:
                self._db.execute("DELETE FROM states WHERE seq > ?", (self._cursor,))
                cursor = self._db.execute(
                    "INSERT INTO states (label, payload) VALUES (?, ?)", (checkpoint, payload)
                )
                self._set_meta("cursor", str(cursor.lastrowid))

    def undo(self) -> LoopState | None:
        """Moves one step back; None at the beginning. Rounds stay in the tree."""
        return self._move("SELECT MAX(seq) FROM states WHERE seq < ?")

    def redo(self) -> LoopState | None:
        """Moves one step forward again; None at the end."""
        return self._move("SELECT MIN(seq) FROM states WHERE seq > ?")

    @property
    def can_undo(self) -> bool:
        """Whether there is a step back."""
        return self._neighbour("SELECT MAX(seq) FROM states WHERE seq < ?") is not None

    @property
    def can_redo(self) -> bool:
        """Whether there is a step forward."""
        return self._neighbour("SELECT MIN(seq) FROM states WHERE seq > ?") is not None

    def record(self, kind: str, author: str, payload: dict[str, Any]) -> None:
        """Adds to the append-only log of decisions and other acts."""
        with self._transaction():
            self._db.execute(
                "INSERT INTO log (at, kind, author, payload) VALUES (?, ?, ?, ?)",
                (now(), kind, author, json.dumps(payload, sort_keys=True)),
            )

    def log(self) -> tuple[tuple[str, str, str, dict[str, Any]], ...]:
        """The log: (time, kind, author, payload) in order."""
        rows = self._db.execute("SELECT at, kind, author, payload FROM log ORDER BY seq")
        return tuple((at, kind, author, json.loads(text)) for at, kind, author, text in rows)

    def log_after(self, seq: int, kind: str) -> tuple[tuple[int, dict[str, Any]], ...]:
        """Entries of one kind with a number above `seq`: (number, payload) in order."""
        rows = self._db.execute(
            "SELECT seq, payload FROM log WHERE seq > ? AND kind = ? ORDER BY seq", (seq, kind)
        )
        return tuple((number, json.loads(text)) for number, text in rows)

    # --- files -------------------------------------------------------------------------------

    def put_rollout(self, rollout: Rollout) -> str:
        """Stores a rollout and returns its key."""
        return self.files.put(rollout_to_bytes(rollout), ".npz")

    def rollout(self, key: str) -> Rollout:
        """A stored rollout; the last few stay in memory."""
        if key not in self._rollouts:
            self._rollouts[key] = rollout_from_bytes(self.files.get(key))
            while len(self._rollouts) > KEPT_ROLLOUTS:
                self._rollouts.popitem(last=False)
        self._rollouts.move_to_end(key)
        return self._rollouts[key]

    def put_scene(self, scene: Scene) -> str:
        """Stores a scene and returns its key."""
        known = next((key for key, item in self._scenes.items() if item is scene), None)
        key = known or self.files.put(arrays.pack_scene(scene), ".npz")
        self._scenes[key] = scene
        return key

    def scene(self, key: str) -> Scene:
        """A stored scene."""
        if key not in self._scenes:
            self._scenes[key] = arrays.unpack_scene(self.files.get(key), self._image)
        return self._scenes[key]

    def put_mesh(self, mesh: Mesh) -> str:
        """Stores the form of an object and returns its asset, as `Meshed.asset` names it."""
        asset = self.files.put(arrays.pack_mesh(mesh), MESH_SUFFIX).removesuffix(MESH_SUFFIX)
        self._meshes[asset] = mesh
        return asset

    def mesh(self, asset: str) -> Mesh | None:
        """The stored mesh of an asset; None where it came from elsewhere."""
        if asset not in self._meshes and asset + MESH_SUFFIX in self.files:
            self._meshes[asset] = arrays.unpack_mesh(self.files.get(asset + MESH_SUFFIX))
        return self._meshes.get(asset)

    def put_frames(self, frames: tuple[Image, ...]) -> str:
        """Stores evidence frames and returns their key."""
        return self.files.put(arrays.pack_frames(frames), ".npz")

    def frames(self, key: str) -> tuple[Image, ...]:
        """Stored evidence frames, RGB."""
        return arrays.unpack_frames(self.files.get(key))

    def meta(self, key: str) -> str | None:
        """A stored fact about the session."""
        row = self._db.execute("SELECT value FROM meta WHERE key = ?", (key,)).fetchone()
        return None if row is None else row[0]

    def note(self, key: str, value: str) -> None:
        """Keeps a fact about the session that `meta` reads."""
        with self._transaction():
            self._set_meta(key, value)

    def close(self) -> None:
        """Closes the database; everything acknowledged is on the disk already."""
        self._db.close()

    # --- inside ------------------------------------------------------------------------------

    @property
    def _cursor(self) -> int:
        return int(self.meta("cursor") or 0)

    def _set_meta(self, key: str, value: str) -> None:
        self._db.execute(
            "INSERT INTO meta VALUES (?, ?) ON CONFLICT (key) DO UPDATE SET value = excluded.value",
            (key, value),
        )

    def _neighbour(self, query: str) -> int | None:
        return self._db.execute(query, (self._cursor,)).fetchone()[0]

    def _move(self, query: str) -> LoopState | None:
        seq = self._neighbour(query)
        if seq is None:
            return None
        with self._transaction():
            self._set_meta("cursor", str(seq))
        return self.load()

    def _with_rounds(self, payload: str) -> LoopState:
        rows = self._db.execute("SELECT id, payload FROM rounds ORDER BY number, rowid").fetchall()
        for key, text in rows:
            if key not in self._known_rounds:
                self._known_rounds[key] = Round.model_validate_json(text)
        rounds = tuple(self._known_rounds[key] for key, _ in rows)
        return LoopState.model_validate_json(payload).model_copy(update={"rounds": rounds})

    @functools.cached_property
    def _image(self) -> Image | None:
        key = self.meta("image")
        return arrays.from_png(self.files.get(key)) if key else None

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        # The connection commits at the end, or rolls back whatever ends the work before.
        with self._db:
            self._db.execute("BEGIN IMMEDIATE")
            yield


def _connect(path: Path) -> sqlite3.Connection:
    db = sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=10)
    db.execute("PRAGMA journal_mode = WAL")
    db.execute("PRAGMA synchronous = FULL")
    return db
