"""The workspace: a folder of sessions."""

from __future__ import annotations

import os
import re
import secrets
import shutil
import sqlite3
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import platformdirs

from physagent_studio.errors import InputError
from physagent_studio.records import Case, LoopState
from physagent_studio.session.session import Session


def default_workspace() -> Path:
    """`$PHYSAGENT_HOME`, else the user's data folder."""
    home = os.environ.get("PHYSAGENT_HOME")
    return Path(home) if home else Path(platformdirs.user_data_dir("physagent", appauthor=False))


@dataclass(frozen=True, slots=True)
class SessionInfo:
    """A line of the session list. modified: ISO 8601, UTC."""

    id: str
    title: str
    prompt: str
    rounds: int
    outcome: str
    modified: str


class Store:
    """All sessions below one folder."""

    def __init__(self, root: Path | None = None) -> None:
        self.root = (root or default_workspace()).expanduser()

    def create(self, case: Case, state: LoopState, *, title: str | None = None) -> Session:
        """A new session of that case; its id tells case, event and time."""
        parts = "-".join(part for part in (case.name, case.event) if part)
        stamp = datetime.now(UTC).strftime("%m%d-%H%M%S")
        name = re.sub(r"[^a-z0-9]+", "-", parts.lower()).strip("-")[:48] or "session"
        folder = self._sessions() / f"{name}-{stamp}-{secrets.token_hex(2)}"
        try:
            return Session.create(folder, case, title or parts.replace("_", " ") or name, state)
        except OSError as error:
            raise InputError(
                f"the workspace {self.root} cannot be written: {error.strerror}; "
                "choose another with --workspace or PHYSAGENT_HOME"
            ) from error
        except sqlite3.OperationalError as error:
            raise InputError(f"the workspace {self.root} cannot be written: {error}") from error

    def open(self, session_id: str) -> Session:
        """The session of that id, or of a unique beginning of one."""
        return Session(self._folder(session_id))

    def __contains__(self, session_id: str) -> bool:
        return (self._sessions() / session_id / "session.db").is_file()

    def list(self) -> tuple[SessionInfo, ...]:
        """All sessions, last changed first; unreadable ones are left out."""
        found = []
        for path in self._sessions().glob("*/session.db"):
            try:
                found.append(_info(path))
            except (sqlite3.DatabaseError, InputError):
                continue
        return tuple(sorted(found, key=lambda item: item.modified, reverse=True))

    def delete(self, session_id: str) -> None:
        """Removes a session and its files for good."""
        shutil.rmtree(self._folder(session_id))

    def duplicate(self, session_id: str) -> str:
        """Copies a session under a new id, which is returned."""
        source = self._folder(session_id)
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

    def _sessions(self) -> Path:
        return self.root / "sessions"

    def _folder(self, session_id: str) -> Path:
        if not re.fullmatch(r"[\w\-]+", session_id):
            raise InputError(f"'{session_id}' is not a session id")
        exact = self._sessions() / session_id
        if (exact / "session.db").is_file():
            return exact
        near = sorted(path.parent for path in self._sessions().glob(f"{session_id}*/session.db"))
        if len(near) == 1:
            return near[0]
        known = ", ".join(path.name for path in near[:5]) or "`physagent studio` lists them"
        raise InputError(f"there is no session '{session_id}' in {self.root} ({known})")


def _info(path: Path) -> SessionInfo:
    session = Session(path.parent)
    try:
        state = session.load()
        times = [item.stat().st_mtime for item in path.parent.glob("session.db*")]
        return SessionInfo(
            id=session.id,
            title=session.title,
            prompt=session.prompt,
            rounds=len(state.rounds),
            outcome=state.outcome,
            modified=datetime.fromtimestamp(max(times), UTC).isoformat(timespec="seconds"),
        )
    finally:
        session.close()
