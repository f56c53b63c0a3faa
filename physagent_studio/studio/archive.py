"""Reads what earlier rounds left in the session's files, without going through the worker.

Files are immutable and named by their content, so that reading beside the worker is safe.
"""

from __future__ import annotations

from collections import OrderedDict

from physagent_studio.errors import StudioError
from physagent_studio.records import Rollout, Round
from physagent_studio.records.rollout_io import rollout_from_bytes
from physagent_studio.session import FileStore, Store
from physagent_studio.studio.library import Output, outputs_of
from physagent_studio.workbench import Snapshot

KEPT = 6


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
