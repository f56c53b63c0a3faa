"""Control steps that can be run at a stretch, because nothing of ours can act within them.

Between engine steps two things are ours: friction grips differently once a pair has come close
(`grip`), and impacts are written down (`touches`). Both wait for bodies that meet. So while no
two bodies can meet that do not touch already, a control step is left to the engine as a whole.
For how long that is follows from distances and speeds, as bounds: an object is a sphere about
its origin, a support a convex solid, every point moves at most at the present speed and gains at
most that of a fall. Where that is too coarse the engine measures the gap, and what counts is how
fast a plane across it is used up. Within that time a run at a stretch gives the same bits as step
by step.
"""

import math

import numpy as np

from physagent_studio.simulation.contacts.friction import Grip
from physagent_studio.simulation.contacts.touches import ContactLog
from physagent_studio.simulation.mj import Data, mj
from physagent_studio.simulation.model.clearances import Meeting, Reach
from physagent_studio.simulation.model.model import MEETING, Compiled
from physagent_studio.simulation.surfaces import FloatArray

LONGEST = 25
"""Control steps after which the distances are looked at again."""

MANY = 16
"""Meetings that are near from which on they are not measured one by one."""

SLACK = 1e-4
"""m by which spheres around geoms may be nearer than the engine measures, and a share of speeds:
room for rounding."""

PATIENCE = 3
"""Control steps that pass at most before a scene in which things are near is looked at again."""


class Calm:
    """Knows until which control step (exclusive) nothing new can meet.

    until, wait and patience are part of a snapshot: what is read of contacts depends on them.
    """

    def __init__(self, compiled: Compiled, gravity: FloatArray, step_seconds: float) -> None:
        self._model = compiled.model
        self.reach: Reach | None = compiled.reach
        self._haste = float(np.linalg.norm(gravity))
        # What touches stays gentle where it cannot part and meet again with an impact.
        self._gentle = MEETING - self._haste * step_seconds
        self._step_seconds = step_seconds
        self._dt = float(compiled.model.opt.timestep)
        self._ends = np.zeros(6)
        # Half-spaces have none.
        self._radii = [radius or math.inf for radius in compiled.model.geom_rbound.tolist()]
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

    def look(
        self, step: int, data: Data, grip: Grip, log: ContactLog, since: int, gain: float
    ) -> None:
        """Decides before control step `step` how many steps can be run at a stretch.

        since: engine step from which on the log's readings tell which pairs touch. gain: m/s²
        that actions may give beside gravity.
        """
        if self._wait:
            self._wait -= 1
            if grip.awaits:
                grip.note(log, since)
            return
        steps = 0
        if grip.note(log, since) and self.reach is not None:
            steps = self._steps(self.reach, data, grip, self._haste + gain)
        self.until = step + steps
        self._patience = 0 if steps else min(self._patience + 1, PATIENCE)
        self._wait = self._patience

    def _steps(self, reach: Reach, data: Data, grip: Grip, haste: float) -> int:
        rates, engaged = data.qvel.tolist(), grip.engaged
        if not grip.alone and reach.rocks(engaged, rates, self._gentle):
            return 0
        spheres = reach.spheres(data.qpos.tolist(), rates)
        if not engaged.isdisjoint(reach.between):
            # Objects that touch each other may hand on their speed.
            most = 1.5 * max(speed for *_, speed in spheres)
            spheres = [(*ball, most) for *ball, _ in spheres]
        step, best, near = self._step_seconds, LONGEST * self._step_seconds, 0
        for meeting in reach.meetings:
            x, y, z, radius, closing = spheres[meeting.one]
            if meeting.other < 0:
                bound = max([a * x + b * y + c * z - d for a, b, c, d in meeting.planes]) - radius
            else:
                u, v, w, size, speed = spheres[meeting.other]
                x, y, z = x - u, y - v, z - w
                bound = math.sqrt(x * x + y * y + z * z) - size - radius
                closing += speed
            if bound > (closing + haste * best) * best or meeting.pairs <= engaged:
                continue
            seconds = time_to_meet(bound, closing, haste)
            if seconds < 2 * step:
                near += 1
                seconds = self._measured(data, reach, meeting, engaged, closing, haste)
                if seconds < step or near > MANY:
                    return 0
            if seconds < best:
                best = seconds
        return int(best / step + 1e-9)

    def _measured(
        self,
        data: Data,
        reach: Reach,
        meeting: Meeting,
        engaged: frozenset[int],
        closing: float,
        haste: float,
    ) -> float:
        """s until two bodies can meet that are near, of what does not touch already."""
        best = LONGEST * self._step_seconds
        most = (closing + haste * best) * best
        fastest, rates = (1 + SLACK) * closing, data.qvel.tolist()
        for least, one, other in self._nearest_first(data, meeting, engaged):
            # No plane is used up faster than bodies come closer: what is farther meets later.
            most = min(most, (fastest + haste * best) * best + fastest * self._dt)
            if least >= most:
                break
            gap = mj.mj_geomDistance(self._model, data, one, other, most, self._ends)
            if gap < most:
                speed = reach.approach(meeting, rates, self._ends.tolist())
                # Geoms are where they were before the last engine step.
                gap -= speed * self._dt
                best = min(best, time_to_meet(gap, speed, haste))
        return best

    def _nearest_first(
        self, data: Data, meeting: Meeting, engaged: frozenset[int]
    ) -> list[tuple[float, int, int]]:
        """Pairs of geoms that do not touch already, with how far apart they are at least, m."""
        pairs = [(one, other) for pair, one, other in meeting.geoms if pair not in engaged]
        if len(pairs) < 2:
            return [(-math.inf, one, other) for one, other in pairs]
        places, radii = data.geom_xpos.tolist(), self._radii
        return sorted(
            (math.dist(places[one], places[other]) - radii[one] - radii[other] - SLACK, one, other)
            for one, other in pairs
        )


def time_to_meet(gap: float, closing: float, haste: float) -> float:
    """s until closing · t + haste · t² has used up a gap."""
    if gap <= 0:
        return 0.0
    return 2 * gap / max(closing + math.sqrt(closing * closing + 4 * haste * gap), 1e-9)
