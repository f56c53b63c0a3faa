"""Control steps that can be run at a stretch, because nothing of ours can act within them.

Between engine steps two things are ours: friction grips differently once a pair has come close
(`grip`), and impacts are written down (`touches`). Both wait for bodies that meet. So while no
two bodies can meet that do not touch already, a control step is left to the engine as a whole.
For how long that is follows from distances and speeds, as bounds: an object is a sphere about
its origin, a support a convex solid, and where that is too coarse the engine measures; every point
moves at most at the present speed and gains at most that of a fall. Within that time a run at a
stretch gives the same bits as step by step.
"""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.simulation.grip import Grip
from physagent_studio.simulation.mj import Data, mj
from physagent_studio.simulation.model import Compiled
from physagent_studio.simulation.reach import Meeting, Reach
from physagent_studio.simulation.surfaces import FloatArray
from physagent_studio.simulation.touches import ContactLog

LONGEST = 25
"""Control steps after which the distances are looked at again."""

MANY = 16
"""Meetings that are near from which on they are not measured one by one."""

SHORTEST = 4
"""Control steps below which looking at the distances costs more than it saves."""

PATIENCE = 8
"""Control steps that pass at most before a scene in which things are near is looked at again."""


class Calm:
    """Knows until which control step (exclusive) nothing new can meet.

    until, wait and patience are part of a snapshot: what is read of contacts depends on them.
    """

    def __init__(self, compiled: Compiled, gravity: FloatArray, step_seconds: float) -> None:
        self._model = compiled.model
        self.reach: Reach | None = compiled.reach
        self._haste = float(np.linalg.norm(gravity))
        self._step_seconds = step_seconds
        self.until = 0
        self._wait = 0
        self._patience = 0

    @property
    def state(self) -> tuple[int, int, int]:
        """What a snapshot keeps."""
        return self.until, self._wait, self._patience

    def restore(self, state: FloatArray) -> None:
        """Takes up where `state` was."""
        self.until, self._wait, self._patience = (int(value) for value in state)

    def end(self, step: int) -> None:
        """From `step` on engine steps are run one by one: something has happened."""
        self.until, self._wait, self._patience = step, 0, 0

    def look(self, step: int, data: Data, grip: Grip, log: ContactLog, since: int) -> None:
        """Decides before control step `step` how many steps can be run at a stretch.

        since: engine step from which on the log's readings tell which pairs touch.
        """
        if self._wait:
            self._wait -= 1
            if grip.awaits:
                grip.note(data, log, since)
            return
        steps = 0
        if grip.note(data, log, since) and self.reach is not None:
            steps = self._steps(self.reach, data, grip.engaged)
        self.until = step + steps
        self._patience = 0 if steps else min(2 * self._patience + 1, PATIENCE)
        self._wait = self._patience

    def _steps(self, reach: Reach, data: Data, engaged: frozenset[int]) -> int:
        speeds, haste = reach.speeds(data.qvel.tolist()), self._haste
        if not engaged.isdisjoint(reach.between):
            # Objects that touch each other may hand on their speed.
            speeds = [1.5 * max(speeds)] * len(speeds)
        least, best, near = SHORTEST * self._step_seconds, LONGEST * self._step_seconds, 0
        for meeting, bound in reach.gaps(data.qpos.tolist(), engaged):
            closing = speeds[meeting.one]
            if meeting.other >= 0:
                closing += speeds[meeting.other]
            if bound > (closing + haste * best) * best:
                continue
            seconds = self._seconds(bound, closing)
            if seconds < least:
                near += 1
                seconds = self._seconds(self._gap(data, meeting, engaged, closing), closing)
                if seconds < least or near > MANY:
                    return 0
            best = min(best, seconds)
        return int(best / self._step_seconds + 1e-9)

    def _seconds(self, gap: float, closing: float) -> float:
        """s until closing · t + haste · t² has used up the gap."""
        if gap <= 0:
            return 0.0
        root = math.sqrt(closing * closing + 4 * self._haste * gap)
        return 2 * gap / max(closing + root, 1e-9)

    def _gap(self, data: Data, meeting: Meeting, engaged: frozenset[int], closing: float) -> float:
        """m between two bodies, of what does not touch already; up to what can matter."""
        seconds = LONGEST * self._step_seconds
        gap = most = (closing + self._haste * seconds) * seconds
        for pair, one, other in meeting.geoms:
            if pair not in engaged:
                gap = min(gap, mj.mj_geomDistance(self._model, data, one, other, most, None))
        # Geoms are where they were before the last engine step.
        return gap - closing * self._model.opt.timestep if gap < most else most
