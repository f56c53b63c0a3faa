"""The workspace: a folder of sessions."""

import os
import re
import secrets
import shutil
import sqlite3
import time
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from physagent_studio.assets import data_folder
from physagent_studio.errors import InputError
from physagent_studio.records import Case, LoopState
from physagent_studio.session import archive
from physagent_studio.session.files import is_held
from physagent_studio.session.session import Session
from physagent_studio.session.standing import is_in_doubt, standing

KEPT_IN_TRASH = 7 * 86_400.0
"""Seconds for which a discarded session can be brought back."""


@dataclass(frozen=True, slots=True)
class SessionInfo:
    """A line of the session list.

    outcome: of its loop; of one that has not ended, how it is `standing`. modified: ISO 8601, UTC.
    image: key of the photo, "" without. in_doubt: it is realised only as far as it is tested.
    """

    id: str
    title: str
    prompt: str
    rounds: int
    outcome: str
    modified: str
    image: str = ""
    in_doubt: bool = False


class Store:
    """All sessions below one folder."""

    def __init__(self, root: Path | None = None) -> None:
        self.root = (root or data_folder()).expanduser()
        self._known: dict[Path, tuple[tuple[int, ...], SessionInfo]] = {}

    def create(self, case: Case, state: LoopState, *, title: str | None = None) -> Session:
        """A new session of that case; its id tells title, or case and event, and time."""
        parts = title or "-".join(part for part in (case.name, case.event) if part)
        called = ": ".join(part for part in (case.name, case.event) if part).replace("_", " ")
        stamp = datetime.now(UTC).strftime("%m%d-%H%M%S")
        name = re.sub(r"[^a-z0-9]+", "-", parts.lower()).strip("-")[:48].strip("-") or "session"
        folder = self._sessions() / f"{name}-{stamp}-{secrets.token_hex(2)}"
        try:
            return Session.create(folder, case, title or called or name, state)
        except OSError as error:
            raise InputError(
                f"the workspace {self.root} cannot be written: {error.strerror}; "
                "choose another with --workspace or PHYSAGENT_HOME"
            ) from error
        except sqlite3.OperationalError as error:
            raise InputError(f"the workspace {self.root} cannot be written: {error}") from error

    def open(self, session_id: str, *, writing: bool = True) -> Session:
        """The session of that id, or of a unique beginning of one."""
        return Session(self.folder_of(session_id), writing=writing)

    def __contains__(self, session_id: str) -> bool:
        return (self._sessions() / session_id / "session.db").is_file()

    def list(self) -> tuple[SessionInfo, ...]:
        """All sessions, last changed first; unreadable ones are left out."""
        found = []
        for path in self._sessions().glob("*/session.db"):
            try:
                found.append(self._info(path))
            except (sqlite3.DatabaseError, InputError, FileNotFoundError):
                continue
        return tuple(sorted(found, key=lambda item: item.modified, reverse=True))

    def discard(self, session_id: str) -> str:
        """Takes a session out of the list; for a week `restore` brings it back. Returns its id."""
        source = self.folder_of(session_id)
        self._empty_trash()
        self._trash().mkdir(parents=True, exist_ok=True)
        target = self._trash() / source.name
        source.replace(target)
        os.utime(target)
        return source.name

    def restore(self, session_id: str) -> None:
        """Brings a discarded session back; an `InputError` where it is gone for good."""
        source = self._trash() / session_id
        if not re.fullmatch(r"[\w\-]+", session_id) or not (source / "session.db").is_file():
            raise InputError(f"the session '{session_id}' is gone for good")
        if (self._sessions() / session_id).exists():
            raise InputError(f"there is another session '{session_id}' in its place")
        source.replace(self._sessions() / session_id)

    def photo(self, session_id: str) -> bytes | None:
        """The session's photo as it was stored, PNG; None for a session without one."""
        with self.open(session_id, writing=False) as session:
            key = session.meta("image")
            return session.files.get(key) if key else None

    def duplicate(self, session_id: str) -> str:
        """Copies a session under a new id, which is returned."""
        source = self.folder_of(session_id)
        target = source.with_name(f"{source.name}-{secrets.token_hex(2)}")
        target.mkdir()
        (target / "files").mkdir()
        for path in (source / "files").glob("[!.]*"):
            os.link(path, target / "files" / path.name)
        # SQLite's own backup sees a consistent state even while the source is being written.
        with (
            sqlite3.connect(source / "session.db") as old,
            sqlite3.connect(target / "session.db") as new,
        ):
            old.backup(new)
        return target.name

    def import_from(self, path: Path) -> str:
        """Takes in a session that was exported to one file, under a new id, which is returned."""
        stem = re.sub(r"[^a-z0-9]+", "-", path.stem.lower()).strip("-")[:48].strip("-")
        name = f"{stem or 'session'}-{secrets.token_hex(2)}"
        partial = self.root / "imports" / secrets.token_hex(8)
        try:
            archive.unpack(path, partial)
            self._sessions().mkdir(parents=True, exist_ok=True)
            partial.replace(self._sessions() / name)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
        return name

    def _info(self, path: Path) -> SessionInfo:
        """A line of the list, read again only when the session or who holds it has changed."""
        stats = [item.stat() for item in (path, path.with_name("session.db-wal")) if item.exists()]
        # Reading makes a journal as well, but an empty one.
        stats = [one for one in stats if one.st_size]
        if not stats:
            raise InputError(f"the session {path.parent.name} is only being made")
        held = is_held(path.with_name("session.lock"))
        stamp = (held, *(number for one in stats for number in (one.st_mtime_ns, one.st_size)))
        if path not in self._known or self._known[path][0] != stamp:
            changed = max(one.st_mtime for one in stats)
            self._known[path] = (stamp, _info(path, changed, held))
        return self._known[path][1]

    def _empty_trash(self) -> None:
        oldest = time.time() - KEPT_IN_TRASH
        for path in self._trash().glob("*/session.db"):
            if path.parent.stat().st_mtime < oldest:
                shutil.rmtree(path.parent, ignore_errors=True)

    def _trash(self) -> Path:
        return self.root / "trash"

    def _sessions(self) -> Path:
        return self.root / "sessions"

    def folder_of(self, session_id: str) -> Path:
        """Where a session lies; an `InputError` where there is none of that id."""
        if not re.fullmatch(r"[\w\-]+", session_id):
            raise InputError(f"'{session_id}' is not a session id")
        exact = self._sessions() / session_id
        if (exact / "session.db").is_file():
            return exact
        near = sorted(path.parent for path in self._sessions().glob(f"{session_id}*/session.db"))
        if len(near) == 1:
            return near[0]
        known = ", ".join(path.name for path in near[:5]) or "`physagent sessions` lists them"
        raise InputError(f"there is no session '{session_id}' in {self.root} ({known})")


def _info(path: Path, changed: float, held: bool) -> SessionInfo:
    with Session(path.parent, writing=False) as session:
        rounds, outcome = session.summary()
        return SessionInfo(
            id=session.id,
            title=session.title,
            prompt=session.prompt,
            rounds=rounds,
            outcome=standing(session, held) if outcome == "running" else outcome,
            modified=datetime.fromtimestamp(changed, UTC).isoformat(timespec="seconds"),
            image=session.meta("image") or "",
            in_doubt=outcome == "realised" and is_in_doubt(session),
        )
