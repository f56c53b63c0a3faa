"""What can be opened from the browser: the bundled cases and the sessions of the workspace.

A browser names an entry by its key, never by a path.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import yaml

from physagent_studio.assets import assets_dir
from physagent_studio.errors import InputError, StudioError
from physagent_studio.session import Store
from physagent_studio.workbench import Snapshot, commands

FRESH_SECONDS = 2.0


class Library:
    """Lists cases and sessions; called by the studio's one thread."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._cases = _bundled()
        self._listed: tuple[float, Any, dict[str, Any]] | None = None

    def listing(self, snapshot: Snapshot) -> dict[str, Any]:
        """All entries; read again at most every other second, or when the session changed."""
        key = (snapshot.session_id, len(snapshot.state.rounds), snapshot.state.outcome)
        now = time.monotonic()
        if self._listed and self._listed[1] == key and now - self._listed[0] < FRESH_SECONDS:
            return self._listed[2]
        value = {
            "cases": [
                {"key": f"case:{name}", "name": name.replace("_", " "), "events": events}
                for name, (_, events) in self._cases.items()
            ],
            "sessions": [
                {
                    "key": f"session:{one.id}",
                    "title": one.title,
                    "prompt": one.prompt,
                    "rounds": one.rounds,
                    "outcome": one.outcome,
                    "modified": one.modified,
                    "open": one.id == snapshot.session_id,
                }
                for one in self._store.list()[:200]
            ],
        }
        self._listed = (now, key, value)
        return value

    def opening(self, key: str, event: str) -> commands.Command:
        """The command that opens an entry."""
        kind, _, name = key.partition(":")
        if kind == "case" and name in self._cases:
            folder, events = self._cases[name]
            chosen = event or (events[0]["name"] if events else None)
            return commands.OpenCase(folder, chosen)
        if kind == "session" and name in self._store:
            return commands.OpenSession(name)
        raise InputError(f"'{key}' is not in the list of cases and sessions")


def _bundled() -> dict[str, tuple[Path, list[dict[str, str]]]]:
    """Cases that ship with the package: name → folder and events."""
    try:
        folder = assets_dir()
    except StudioError:
        return {}
    found = {}
    for path in sorted(folder.glob("*/case.yaml")):
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        events = data.get("events") or {} if isinstance(data, dict) else {}
        found[path.parent.name] = (
            path.parent,
            [{"name": str(key), "prompt": str(text)} for key, text in events.items()],
        )
    return found
