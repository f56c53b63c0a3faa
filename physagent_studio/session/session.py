"""One session: what was acknowledged is on the disk, and reopens as it was.

Rounds and the decision log are only ever added to; a row of `states` is one step of undo.
"""

from __future__ import annotations

import functools
import itertools
import json
import operator
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

from physagent_studio.errors import InputError, StorageError
from physagent_studio.program.scene.camera import Camera
from physagent_studio.records import Case, Image, LoopState, Mesh, Round, Scene, doubts_about
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.rollout_io import rollout_from_bytes, rollout_to_bytes
from physagent_studio.session import arrays
from physagent_studio.session.files import FileStore, Lock
from physagent_studio.session.schema import SCHEMA, TABLES, connect, linked, migrate, reported
from physagent_studio.session.stored_round import RoundReader

KEPT_ROLLOUTS = 8
MESH_SUFFIX = ".mesh.npz"


def now() -> str:
    """The present time, ISO 8601 in UTC."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


class Session:
    """An open session. Not thread-safe: it belongs to one worker.

    writing: wish to write; `read_only` says why it cannot be where another process writes it.
    """

    def __init__(self, folder: Path, *, writing: bool = True) -> None:
        path = folder / "session.db"
        if not path.is_file():
            raise InputError(f"there is no session in {folder}")
        self.folder = folder
        self.files = FileStore(folder / "files")
        self._lock = Lock(folder / "session.lock") if writing else None
        self.read_only = "" if self._lock and self._lock.taken else self._why_not()
        self._db = connect(path, writing=not self.read_only)
        self._reader = RoundReader(path)
        with ExitStack() as opening:
            opening.callback(self.close)
            self._version = migrate(self._db, folder.name, writing=not self.read_only)
            opening.pop_all()
        self._scenes: dict[str, Scene] = {}
        self._meshes: dict[str, Mesh] = {}
        self._known_rounds: dict[str, Round] = {}
        self._last: tuple[Round, ...] = ()
        self._rollouts: OrderedDict[str, Rollout] = OrderedDict()

    @classmethod
    def create(cls, folder: Path, case: Case, title: str, state: LoopState) -> Session:
        """Makes the folder and its first state."""
        folder.mkdir(parents=True)
        db = connect(folder / "session.db")
        with db:
            db.executescript(TABLES)
        files = FileStore(folder / "files")
        key = files.put(arrays.png(case.image), ".png") if case.image is not None else ""
        facts = {
            "schema": str(SCHEMA),
            "title": title,
            "created": now(),
            "image": key,
            "case": json.dumps(arrays.case_json(case)),
            "cursor": "1",
            "first": state.model_dump_json(exclude={"rounds"}),
        }
        with db:
            # In one: a session that a kill leaves here has a state, or is none.
            db.execute("BEGIN IMMEDIATE")
            db.executemany("INSERT INTO meta VALUES (?, ?)", facts.items())
            db.execute("INSERT INTO states VALUES (1, 'opened', ?)", (facts["first"],))
        db.close()
        session = cls(folder)
        if state.rounds:
            session.save(state)
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
        # By identity, in one pass of C: there may be ten thousand of them.
        moved = itertools.chain(map(operator.is_not, state.rounds, self._last), itertools.repeat(1))
        fresh = [
            one
            for one in itertools.compress(state.rounds, moved)
            if self._known_rounds.get(one.id) is not one
        ]
        with self._transaction():
            self._db.executemany(
                "INSERT INTO rounds VALUES (?, ?, ?, ?) "
                "ON CONFLICT (id) DO UPDATE SET payload = excluded.payload",
                [(one.id, one.number, one.model_dump_json(), one.parent) for one in fresh],
            )
            for one in fresh:
                self._add("round", one.author, {"round": one.id, "program": one.program.hash})
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
            self._db.execute("UPDATE answers SET used = 1 WHERE used = 0")
        # Only what is on the disk is known: a save that failed writes all of it again.
        self._known_rounds |= {one.id: one for one in fresh}
        self._last = state.rounds

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
            self._add(kind, author, payload)

    def _add(self, kind: str, author: str, payload: dict[str, Any]) -> None:
        row = (now(), kind, author, json.dumps(payload, sort_keys=True))
        last = self._db.execute("SELECT link FROM log ORDER BY seq DESC LIMIT 1").fetchone()
        link = linked((last[0] if last else None) or "", *row)
        self._db.execute(
            "INSERT INTO log (at, kind, author, payload, link) VALUES (?, ?, ?, ?, ?)",
            (*row, link),
        )

    def answer(self, key: str) -> dict[str, Any] | None:
        """What a model has answered to that question in the phase that is still under way."""
        row = self._db.execute(
            "SELECT payload FROM answers WHERE key = ? AND used = 0 ORDER BY seq DESC", (key,)
        ).fetchone()
        return None if row is None else json.loads(row[0])

    def answers(self) -> dict[str, dict[str, Any]]:
        """Everything that a model has answered in this session, by question."""
        rows = self._db.execute("SELECT key, payload FROM answers ORDER BY seq")
        return {key: json.loads(text) for key, text in rows} if self._version > 1 else {}

    def keep_answer(self, key: str, payload: dict[str, Any]) -> None:
        """Keeps an answer, so that a phase that is done again does not pay for it again."""
        with self._transaction():
            self._db.execute(
                "INSERT INTO answers (key, payload) VALUES (?, ?)", (key, json.dumps(payload))
            )

    def use_answers(self) -> None:
        """What was answered up to now has had its effect; the same question is asked anew."""
        with self._transaction():
            self._db.execute("UPDATE answers SET used = 1 WHERE used = 0")

    def log(self) -> tuple[tuple[str, str, str, dict[str, Any]], ...]:
        """The log: (time, kind, author, payload) in order."""
        rows = self._db.execute("SELECT at, kind, author, payload FROM log ORDER BY seq")
        return tuple((at, kind, author, json.loads(text)) for at, kind, author, text in rows)

    def last_of(self, kinds: tuple[str, ...]) -> tuple[str, dict[str, Any]] | None:
        """The newest entry of one of these kinds: (kind, payload)."""
        marks = ", ".join("?" * len(kinds))
        query = f"SELECT kind, payload FROM log WHERE kind IN ({marks}) ORDER BY seq DESC LIMIT 1"
        row = self._db.execute(query, kinds).fetchone()
        return None if row is None else (row[0], json.loads(row[1]))

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

    def is_doubted(self, key: str) -> bool:
        """Whether a mask or the camera of a stored scene is doubted; reads no picture of it."""
        facts = arrays.unpack_facts(self.files.get(key))
        camera, shape = facts["state"]["camera"], facts["mask_shape"]
        told = Camera.model_validate(camera) if camera else None
        height = shape[0] if shape and self.meta("image") else None
        return bool(doubts_about(facts.get("sureness", {}), told, height))

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
        self._reader.close()
        if self._lock is not None:
            self._lock.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_why: object) -> None:
        self.close()

    def _why_not(self) -> str:
        if self._lock is None:
            return f"session {self.folder.name} was only opened to be read"
        who = self._lock.holder
        by = f" by another process ({who})" if who else ""
        return f"session {self.folder.name} is open{by}; here it is only shown, nothing is changed"

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
        parent = "parent" if self._version > 1 else "json_extract(payload, '$.parent')"
        query = f"SELECT id, number, {parent} FROM rounds ORDER BY number, rowid"
        rows = self._db.execute(query).fetchall()
        for key, number, before in rows:
            if key not in self._known_rounds:
                self._known_rounds[key] = self._reader.stub(key, number, before)
        rounds = self._last = tuple(self._known_rounds[row[0]] for row in rows)
        return LoopState.model_validate_json(payload).model_copy(update={"rounds": rounds})

    @functools.cached_property
    def _image(self) -> Image | None:
        key = self.meta("image")
        return arrays.from_png(self.files.get(key)) if key else None

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        if self.read_only:
            raise StorageError(self.read_only)
        # The connection commits at the end, or rolls back whatever ends the work before.
        with reported(self.id), self._db:
            self._db.execute("BEGIN IMMEDIATE")
            yield
