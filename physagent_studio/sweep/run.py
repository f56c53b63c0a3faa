"""The task of a sweep, a complete program in and its checks and the key of its rollout out; and
what is known of a sweep on the disk, one line for each run, named by what went into it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pydantic import ConfigDict, ValidationError

from physagent_studio.arrays import FloatArray
from physagent_studio.contract import measure
from physagent_studio.contract.view import Drawn
from physagent_studio.errors import InputError
from physagent_studio.jobs import Limits, hearing
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.base import Frozen
from physagent_studio.records import Check, Mesh, Rollout
from physagent_studio.session.files import Lock

if TYPE_CHECKING:
    from physagent_studio.simulation import Simulator


LIMITS = Limits(600.0, 2 * 2**30)
"""Grains are the slowest, at a minute a run."""
SETTLED_STEPS = 2
"""Control steps within which what stands comes to rest on what carries it: no event of the clip."""


class Ran(Frozen):
    """What one run came to. rollout: a hash of all that moved, equal where the bits are.

    touches: first contact of each pair, s. problem: why there was no run, or why it ended early; it
    does not hold then. lost: its worker broke down every time, so that another sweep tries it
    again. objects and path: (frames, objects, 3) where things were, world, m; not on the disk.
    """

    model_config = ConfigDict(arbitrary_types_allowed=True)

    rollout: str = ""
    checks: tuple[Check, ...] = ()
    touches: tuple[tuple[str, float], ...] = ()
    problem: str = ""
    lost: bool = False
    objects: tuple[str, ...] = ()
    path: FloatArray | None = None

    @property
    def holds(self) -> bool:
        """Whether all that is demanded holds."""
        return not self.problem and not self.failing

    @property
    def failing(self) -> tuple[Check, ...]:
        """What is demanded and does not hold, worst first."""
        failing = (check for check in self.checks if check.demanded and not check.ok)
        return tuple(sorted(failing, key=lambda check: check.margin))


def ran(
    program: PhysicalProgram, meshes: Mapping[str, Mesh], drawn: Mapping[str, Drawn] | None
) -> Ran:
    """Runs a program and measures its contract; pure, so it may run anywhere and again."""
    rollout = _simulator().simulate(program, meshes, cancelled=hearing()[0])
    return Ran(
        rollout=key_of(rollout),
        checks=measure(program, rollout, drawn),
        touches=_touches(rollout),
        problem=rollout.blown_up.text if rollout.blown_up else "",
        objects=rollout.objects,
        path=rollout.positions[rollout.frame_steps()],
    )


@lru_cache(maxsize=1)
def _simulator() -> Simulator:
    """The one of this process; the room is imported where a run is made, for it is heavy."""
    from physagent_studio.simulation import Simulator

    return Simulator()


def key_of(rollout: Rollout) -> str:
    """SHA-256 over poses, velocities and contacts: two rollouts have it where their bits agree."""
    digest = hashlib.sha256(repr((rollout.bodies, rollout.step_seconds)).encode())
    moved = (rollout.positions, rollout.rotations, rollout.velocities, rollout.angular)
    for array in (*moved, rollout.contacts):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _touches(rollout: Rollout) -> tuple[tuple[str, float], ...]:
    """The first contact of each pair that did not touch at the start, earliest first."""
    rows = rollout.contacts
    pairs, first = np.unique(np.column_stack([rows["a"], rows["b"]]), axis=0, return_index=True)
    steps = zip(rows["step"][first].tolist(), pairs.tolist(), strict=True)
    return tuple(
        (f"{rollout.bodies[a]} {rollout.bodies[b]}", step * rollout.step_seconds)
        for step, (a, b) in sorted(steps)
        if step > SETTLED_STEPS
    )


class Store:
    """The runs of a folder by key. One process writes it; what `add` returned from is kept.

    Only places are held in memory. A line that a kill has cut off is dropped, and run again.
    """

    def __init__(self, folder: Path) -> None:
        """Raises InputError where the folder cannot be written, or another sweep is at it."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = Lock(folder / ".lock")
            if not self._lock.taken:
                raise InputError(f"another sweep (process {self._lock.holder}) writes to {folder}")
            self._file = (folder / "runs.jsonl").open("a+b")
            self._places = self._read()
        except OSError as error:
            raise InputError(f"{folder} cannot be written: {error.strerror}") from error

    def _read(self) -> dict[str, tuple[int, int]]:
        """(offset, bytes) of each whole line that another sweep need not try again."""
        places, at = dict[str, tuple[int, int]](), 0
        self._file.seek(0)
        for line in self._file:
            try:
                found = json.loads(line)
                if not Ran.model_validate(found["ran"]).lost:
                    places[found["key"]] = (at, len(line))
            except (ValueError, KeyError, TypeError, ValidationError):
                break
            at += len(line)
        self._file.truncate(at)
        return places

    def __contains__(self, key: str) -> bool:
        return key in self._places

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, key: str) -> Ran:
        at, size = self._places[key]
        line = os.pread(self._file.fileno(), size, at)
        return Ran.model_validate(json.loads(line)["ran"])

    def add(self, key: str, ran: Ran) -> None:
        """Keeps a run; raises InputError where the disk does not take it."""
        found = {"key": key, "ran": ran.model_dump(mode="json", exclude={"path", "objects"})}
        line = json.dumps(found, separators=(",", ":")).encode() + b"\n"
        try:
            self._places[key] = (self._file.seek(0, os.SEEK_END), len(line))
            self._file.write(line)
            self._file.flush()
        except OSError as error:
            raise InputError(f"a run cannot be kept: {error.strerror}") from error

    def close(self) -> None:
        """Lets another sweep write here."""
        self._file.close()
        self._lock.release()
