"""Contacts during a run: read from the engine sparingly, aggregated per control step and pair.

The engine's contact list is read at the first engine step of every control step, and in between
only where the number of contacts has just changed and on the step after. An impact passes within
one engine step and changes that number, so none is missed, while what rests costs one reading
per control step. A reading stands for all engine steps up to the next one, or to the end of its
control step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from physagent_studio.records import CONTACT_DTYPE
from physagent_studio.simulation.mj import Data, Model, mj
from physagent_studio.simulation.surfaces import FloatArray

IntArray = NDArray[np.int64]


class ContactLog:
    """Collects readings; `contacts()` turns them into the rollout's table.

    substeps: engine steps per control step. dt: engine step, s. geom_bodies: (ngeom,) index
    among objects-then-supports.
    """

    def __init__(
        self, model: Model, geom_bodies: NDArray[np.int16], substeps: int, dt: float
    ) -> None:
        self._geom_bodies = geom_bodies
        self._substeps = substeps
        self._dt = dt
        self._pyramid = model.opt.cone == mj.mjtCone.mjCONE_PYRAMIDAL
        self._ticks: list[int] = []
        self._counts: list[int] = []
        self._parts: list[tuple[Any, ...]] = []
        self._rows: list[FloatArray] = []

    def read(self, data: Data, tick: int) -> None:
        """Keeps the contacts of engine step `tick`; the arrays are views, hence the copies."""
        self._ticks.append(tick)
        self._counts.append(data.ncon)
        if data.ncon == 0:
            return
        contact = data.contact
        self._parts.append(
            (
                contact.geom.copy(),
                # Beyond the overlap that the pair started with, see `settle`.
                contact.dist - contact.includemargin,
                contact.pos.copy(),
                contact.frame[:, :3].copy(),
                contact.efc_address.copy(),
                contact.dim.copy(),
            )
        )
        self._rows.append(data.efc_force.copy())

    def touching(self, since: int) -> set[tuple[int, int]]:
        """Pairs (a < b) that touch in the readings from engine step `since` on."""
        found: set[tuple[int, int]] = set()
        part = len(self._parts)
        for tick, count in zip(reversed(self._ticks), reversed(self._counts), strict=True):
            if tick < since:
                break
            if count:
                part -= 1
                geom, _, _, _, address, _ = self._parts[part]
                bodies = np.sort(self._geom_bodies[geom[address >= 0]], axis=1)
                found.update((int(a), int(b)) for a, b in bodies)
        return found

    def contacts(self, last_tick: int) -> NDArray[np.void]:
        """`CONTACT_DTYPE` rows, sorted by step, then a, then b."""
        if not self._parts:
            return np.zeros(0, CONTACT_DTYPE)
        geom, distance, point, normal, address, dims = (
            np.concatenate(column) for column in zip(*self._parts, strict=True)
        )
        force = self._normal_forces(address, dims)
        reading = np.repeat(np.arange(len(self._ticks)), self._counts)
        bodies = self._geom_bodies[geom].astype(np.int64)
        active = address >= 0
        swap = bodies[:, 0] > bodies[:, 1]
        normal = np.where(swap[:, None], -normal, normal)
        bodies.sort(axis=1)
        weight = self._weights(last_tick)[reading] * self._dt
        ticks = np.array(self._ticks, np.int64)[reading]
        return _aggregate(
            (ticks // self._substeps)[active],
            bodies[active],
            point[active],
            normal[active],
            (force * weight)[active],
            np.maximum(-distance, 0)[active],
        )

    def _normal_forces(self, address: IntArray, dims: IntArray) -> FloatArray:
        """Normal force of each contact, N, 0 where it is not active."""
        force = np.zeros(len(address))
        starts = np.concatenate([[0], np.cumsum([len(rows) for rows in self._rows])[:-1]])
        counts = [count for count in self._counts if count]
        rows = np.concatenate(self._rows)
        active = address >= 0
        at = address + np.repeat(starts, counts)
        force[active] = rows[at[active]]
        if self._pyramid:
            # A pyramid's edges share the normal: their sum is the normal force.
            for edge in range(1, 2 * (int(dims.max()) - 1)):
                more = active & (edge < 2 * (dims - 1))
                force[more] += rows[at[more] + edge]
        return force

    def _weights(self, last_tick: int) -> IntArray:
        """For how many engine steps each reading stands."""
        ticks = np.array([*self._ticks, last_tick + 1], np.int64)
        ends = (ticks[:-1] // self._substeps + 1) * self._substeps
        return np.minimum(ticks[1:], ends) - ticks[:-1]


def _aggregate(
    step: IntArray,
    bodies: IntArray,
    point: FloatArray,
    normal: FloatArray,
    impulse: FloatArray,
    depth: FloatArray,
) -> NDArray[np.void]:
    """One row per control step and pair: impulses added, the deepest point kept."""
    # The deepest contact comes first within its group.
    order = np.lexsort((-depth, bodies[:, 1], bodies[:, 0], step))
    step, bodies, impulse = step[order], bodies[order], impulse[order]
    key = np.column_stack([step, bodies])
    first = np.ones(len(key), bool)
    first[1:] = (key[1:] != key[:-1]).any(axis=1)
    starts = np.flatnonzero(first)
    table = np.zeros(len(starts), CONTACT_DTYPE)
    table["step"] = step[starts]
    table["a"], table["b"] = bodies[starts].T
    table["point"] = point[order][starts]
    table["normal"] = normal[order][starts]
    table["impulse"] = np.add.reduceat(impulse, starts)
    table["depth"] = depth[order][starts]
    return table
