"""Reads what earlier rounds left in the session's files, without going through the worker.

Files are immutable and named by their content, so that reading beside the worker is safe.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import replace

import numpy as np

from physagent_studio.errors import StudioError
from physagent_studio.program.rotations import angle_between
from physagent_studio.program.scene.camera import Camera
from physagent_studio.records import Rollout, Round
from physagent_studio.records.rollout_io import rollout_from_bytes
from physagent_studio.session import FileStore, Store
from physagent_studio.studio.library import Output, outputs_of
from physagent_studio.workbench import Snapshot

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
