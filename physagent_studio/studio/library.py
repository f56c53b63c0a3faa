"""What can be opened from the browser, the bundled cases and the sessions of the workspace, and
what earlier rounds left in the files of a session, read without going through the worker.

A browser names an entry by its key, never by a path. Files are immutable and named by their
content, so that reading beside the worker is safe.
"""

import math
import re
import time
from collections import OrderedDict
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from physagent_studio.assets import assets_dir
from physagent_studio.errors import InputError, StudioError
from physagent_studio.program.rotations import angle_between
from physagent_studio.program.scene.camera import Camera
from physagent_studio.records import Rollout, Round
from physagent_studio.records.rollout_io import rollout_from_bytes
from physagent_studio.session import FileStore, Store
from physagent_studio.session.standing import IN_DOUBT
from physagent_studio.session.store import SessionInfo
from physagent_studio.workbench import Snapshot, commands

FRESH_SECONDS = 2.0
LISTED = 200
OUTPUTS = {
    ".mp4": ("video", "video/mp4", False),
    ".html": ("replay", "text/html", True),
    ".viser": ("recording", "application/octet-stream", True),
}
"""Suffix → what a file made of a session is, its type, and whether the browser saves it."""


@dataclass(frozen=True, slots=True)
class Example:
    """A bundled case: its folder, its photo and its events (name, sentence)."""

    folder: Path
    photo: Path | None
    events: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Output:
    """A file that was made of a session, for the round of that id."""

    path: Path
    kind: str
    mime: str
    save: bool
    round: str


class Library:
    """Lists cases and sessions; called by the studio's one thread, `photo_of` by any."""

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
        value = {"cases": self._examples(), "sessions": self._sessions(snapshot.session_id)}
        self._listed = (now, key, value)
        return value

    def forget(self) -> None:
        """The next listing reads everything again."""
        self._listed = None

    def _examples(self) -> list[dict[str, Any]]:
        return [
            {
                "key": f"case:{name}",
                "name": name.replace("_", " "),
                "face": f"face/case/{name}.jpg" if one.photo else "",
                "events": [{"name": event, "prompt": text} for event, text in one.events],
            }
            for name, one in self._cases.items()
        ]

    def _sessions(self, opened: str | None) -> list[dict[str, Any]]:
        return [
            {
                "key": f"session:{one.id}",
                "title": one.title,
                "prompt": one.prompt,
                "rounds": one.rounds,
                "outcome": one.outcome,
                "inDoubt": IN_DOUBT if one.in_doubt else "",
                "modified": one.modified,
                "face": _face_of(one),
                "open": one.id == opened,
            }
            for one in self._store.list()[:LISTED]
        ]

    def opening(self, key: str, event: str) -> commands.Command:
        """The command that opens an entry."""
        kind, _, name = key.partition(":")
        if kind == "case" and name in self._cases:
            one = self._cases[name]
            chosen = event or (one.events[0][0] if one.events else None)
            return commands.OpenCase(one.folder, chosen)
        if kind == "session" and name in self._store:
            return commands.OpenSession(name)
        raise InputError(f"'{key}' is not in the list of cases and sessions")

    def session_of(self, key: str) -> str:
        """The id of a listed session."""
        kind, _, name = key.partition(":")
        if kind != "session" or not re.fullmatch(r"[\w-]+", name) or name not in self._store:
            raise InputError(f"'{key}' is not in the list of sessions")
        return name

    def photo_of(self, name: str) -> Path | None:
        """The photo of a bundled case."""
        one = self._cases.get(name)
        return one.photo if one else None


def _face_of(one: SessionInfo) -> str:
    """Where the picture of a session is; that of a session without a photo changes with it."""
    if one.image:
        return f"face/session/{one.id}.jpg"
    return f"face/scene/{one.id}/{re.sub(r'[^0-9]', '', one.modified)[:20]}.jpg"


def outputs_of(store: Store, session_id: str | None) -> list[Output]:
    """The files that were made of a session, newest first."""
    folder = store.root / "exports"
    if session_id is None or not folder.is_dir():
        return []
    found = []
    for path in folder.glob(f"{session_id}--*"):
        kind, mime, save = OUTPUTS.get(path.suffix, ("", "", True))
        if kind:
            found.append(Output(path, kind, mime, save, path.stem.rpartition("--")[2]))
    return sorted(found, key=lambda one: one.path.stat().st_mtime, reverse=True)


def output_path(store: Store, session_id: str | None, round_id: str | None, suffix: str) -> Path:
    """Where a file of that kind goes; its folder is made."""
    folder = store.root / "exports"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{session_id or 'clip'}--{round_id or 'draft'}{suffix}"


def _bundled() -> dict[str, Example]:
    """Cases that ship with the package, by name; the demo first."""
    try:
        folder = assets_dir()
    except StudioError:
        return {}
    found = {}
    cases = sorted(folder.glob("*/case.yaml"))
    for path in sorted(cases, key=lambda one: one.parent.name != "demo"):
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        data = data if isinstance(data, dict) else {}
        photo = path.parent / str(data.get("image", ""))
        events = data.get("events") or {}
        found[path.parent.name] = Example(
            path.parent,
            photo if photo.is_file() else None,
            tuple((str(key), str(text)) for key, text in events.items()),
        )
    return found


KEPT = 6
SAME_PLACE, SAME_TURN, SAME_FOCAL = 0.05, 0.03, 0.05
"""How far apart cameras may be: shares of the height and the focal length, and radians."""


class Archive:
    """Rollouts by key; called from one thread."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._rollouts: OrderedDict[str, Rollout] = OrderedDict()

    def rollout(self, snapshot: Snapshot, item: Round | None) -> Rollout | None:
        """What a round's program did; None where it did not run or the file is gone."""
        if item is None or item.rollout is None:
            return None
        key = f"{snapshot.session_id}/{item.rollout}"
        if key not in self._rollouts:
            data = self._read(snapshot.session_id, item.rollout)
            if data is None:
                return None
            self._rollouts[key] = rollout_from_bytes(data)
            while len(self._rollouts) > KEPT:
                self._rollouts.popitem(last=False)
        self._rollouts.move_to_end(key)
        return self._rollouts[key]

    def outputs(self, snapshot: Snapshot) -> list[Output]:
        """Videos and replays that were made of the open session."""
        return outputs_of(self._store, snapshot.session_id)

    def _read(self, session_id: str | None, key: str) -> bytes | None:
        if session_id is None or session_id not in self._store:
            return None
        files = FileStore(self._store.root / "sessions" / session_id / "files")
        try:
            return files.get(key)
        except StudioError:
            return None


def fits(snapshot: Snapshot, item: Round | None) -> bool:
    """Whether what a round did can be drawn in the scene on view.

    Another size of things or another horizon moves everything: its ghosts would stand anywhere.
    """
    if item is None:
        return True
    return in_one_world(snapshot.program.scene.camera, item.program.scene.camera)


def with_ghosts(snapshot: Snapshot) -> Snapshot:
    """The snapshot without the proposal's rollout where that was not run in the scene on view."""
    if snapshot.preview_rollout is None or fits(snapshot, snapshot.state.current):
        return snapshot
    return replace(snapshot, preview_rollout=None)


def in_one_world(one: Camera | None, other: Camera | None) -> bool:
    """Whether what was placed by two cameras of a photo stands in the same place in both."""
    if one is None or other is None:
        return one is other
    far = math.dist(one.position, other.position)
    turned = float(angle_between(np.array(one.rotation), np.array(other.rotation)))
    alike = abs(one.focal - other.focal) < SAME_FOCAL * one.focal
    return alike and far <= SAME_PLACE * abs(one.position[2]) and turned < SAME_TURN


def earlier_round(snapshot: Snapshot, wanted: str | None) -> Round | None:
    """The round to compare with: the one asked for, else the parent of the one on view."""
    rounds = {one.id: one for one in snapshot.state.rounds}
    if wanted in rounds:
        return rounds[wanted]
    shown = rounds.get(snapshot.shown_round or "")
    if shown is None:
        return None
    if snapshot.has_draft:
        return shown
    return rounds.get(shown.parent or "")
