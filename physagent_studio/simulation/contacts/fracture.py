"""Joints of breakable objects that let go, and the contacts between pieces that begin then."""

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.bodies import Breakable
from physagent_studio.records.rollout import Release
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.mj import Data
from physagent_studio.simulation.model.model import Compiled
from physagent_studio.simulation.surfaces import FloatArray

APART = -10.0
"""m: contact margin of two pieces that are still one; no overlap reaches it."""


class Fracture:
    """Watches the blows that pieces take and releases their welds.

    The state of a joint is `eq_active`, a part of every snapshot; the contacts between pieces
    follow from it.
    """

    def __init__(self, program: PhysicalProgram, compiled: Compiled) -> None:
        self._model = compiled.model
        self._clouds: list[tuple[int, str, Cloud, float]] = []
        for index, item in enumerate(program.scene.objects):
            handle = compiled.handles[index]
            if isinstance(item.body, Breakable) and isinstance(handle, Cloud):
                limit = item.body.release_impulse
                self._clouds.append((index, item.name, handle, limit))
        bodies = self._model.geom_bodyid
        self._pairs = np.column_stack(
            [bodies[self._model.pair_geom1], bodies[self._model.pair_geom2]]
        )
        self._inner = compiled.pair_bodies[:, 0] == compiled.pair_bodies[:, 1]

    @property
    def watches(self) -> bool:
        """Whether anything can break."""
        return bool(self._clouds)

    def follow(self, data: Data) -> None:
        """Lets those pieces of one object touch that have come loose from their neighbours."""
        for _, _, cloud, _ in self._clouds:
            intact = np.asarray(data.eq_active)[cloud.joints].astype(bool)
            loose = np.unique(cloud.joined[~intact])
            held = {tuple(sorted(pair)) for pair in cloud.bodies[cloud.joined[intact]].tolist()}
            bodies = cloud.bodies[loose]
            for pair in np.flatnonzero(self._inner):
                one, other = self._pairs[pair].tolist()
                if one not in cloud.bodies:
                    continue
                either = one in bodies or other in bodies
                meet = either and (min(one, other), max(one, other)) not in held
                self._model.pair_margin[pair] = 0.0 if meet else APART

    def release(self, data: Data, blows: FloatArray, step: int) -> list[Release]:
        """Releases the joints whose pieces took more than their limit.

        blows: (nbody,) N·s of normal impulse from outside the object in the step just done.
        """
        found = []
        for _, name, cloud, limit in self._clouds:
            intact = np.asarray(data.eq_active)[cloud.joints].astype(bool)
            taken = _run_through(blows[cloud.bodies], cloud.joined[intact], limit)
            hit = taken[cloud.joined].max(axis=1, initial=0.0)
            for number in np.flatnonzero(intact & (hit > limit)).tolist():
                data.eq_active[cloud.joints[number]] = 0
                a, b = cloud.joined[number].tolist()
                found.append(Release(step, name, f"{a}-{b}", float(hit[number])))
        if found:
            self.follow(data)
        return found


def _run_through(blows: FloatArray, joined: np.ndarray, limit: float) -> FloatArray:
    """(P,) N·s that reach each piece: what a joint cannot take runs on to the piece behind it.

    blows: (P,) N·s from outside. joined: (J, 2) pieces whose joint holds. limit: of a joint.
    """
    taken = np.array(blows, float)
    for _ in range(len(taken)):
        before = taken.copy()
        for a, b in joined.tolist():
            taken[a], taken[b] = max(taken[a], taken[b] - limit), max(taken[b], taken[a] - limit)
        if np.array_equal(before, taken):
            break
    return taken
