"""Contacts during a run: read from the engine sparingly, aggregated per control step and pair.

The engine's contact list is read at the first engine step of every control step, and in between
only where contacts have just been added and on the step after. An impact passes within one engine
step and adds a contact, so none is missed, while what rests costs one reading per control step. A
reading stands for all engine steps up to the next one, or to the end of its control step.
"""

from __future__ import annotations

from bisect import bisect_left
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physagent_studio.records import CONTACT_DTYPE
from physagent_studio.simulation.mj import Data, mj
from physagent_studio.simulation.model import Compiled
from physagent_studio.simulation.surfaces import FloatArray

IntArray = NDArray[np.int64]

MANY = 100
"""Contacts from which on a reading leaves out those within one object."""


class ContactLog:
    """Collects readings; `contacts()` turns them into the rollout's table.

    substeps: engine steps per control step. dt: engine step, s.
    """

    def __init__(self, compiled: Compiled, substeps: int, dt: float) -> None:
        model = compiled.model
        self._geom_bodies = compiled.geom_bodies
        self._flex_bodies = compiled.flex_bodies
        self._geom_owner = model.geom_bodyid
        self._count = model.nbody
        self._substeps = substeps
        self._dt = dt
        self._pyramid = model.opt.cone == mj.mjtCone.mjCONE_PYRAMIDAL
        self._flexible = len(compiled.flex_bodies) > 0
        self._ticks: list[int] = []
        self._counts: list[int] = []
        self._parts: list[tuple[Any, ...]] = []
        self._rows: list[FloatArray] = []

    def read(self, data: Data, tick: int) -> None:
        """Keeps the contacts of engine step `tick`; the arrays are views, hence the copies."""
        self._ticks.append(tick)
        count = data.ncon
        if count > MANY:
            count = self._read_many(data)
        elif count:
            contact = data.contact
            self._parts.append(
                (
                    contact.geom.copy(),
                    # Beyond the overlap that the pair started with, see `settle`.
                    contact.dist - contact.includemargin,
                    contact.pos.copy(),
                    contact.frame.copy(),
                    contact.efc_address.copy(),
                    contact.dim.copy() if self._pyramid else None,
                    contact.flex.copy() if self._flexible else None,
                )
            )
            self._rows.append(data.efc_force.copy())
        self._counts.append(count)

    def _read_many(self, data: Data) -> int:
        """A heap touches itself thousands of times: only what it does to others is kept."""
        contact = data.contact
        bodies = self._bodies(contact.geom, contact.flex)
        keep = bodies[:, 0] != bodies[:, 1]
        if keep.any():
            self._parts.append(
                (
                    contact.geom[keep],
                    (contact.dist - contact.includemargin)[keep],
                    contact.pos[keep],
                    contact.frame[keep],
                    contact.efc_address[keep],
                    contact.dim[keep] if self._pyramid else None,
                    contact.flex[keep] if self._flexible else None,
                )
            )
            self._rows.append(data.efc_force.copy())
        return int(keep.sum())

    def _bodies(self, geom: IntArray, flex: IntArray | None) -> IntArray:
        """(n, 2) index among objects-then-supports. flex: (n, 2) where there are any flexes."""
        bodies = self._geom_bodies[geom].astype(np.int64)
        if self._flexible and flex is not None:
            bodies = np.where(geom >= 0, bodies, self._flex_bodies[flex])
        return bodies

    def touching(self, since: int) -> set[tuple[int, int]]:
        """Pairs (a < b) that touch in the readings from engine step `since` on."""
        found: set[tuple[int, int]] = set()
        for part in self._recent(since):
            geom, address = part[0], part[4]
            bodies = np.sort(self._bodies(geom, part[-1])[address >= 0], axis=1)
            found.update((int(a), int(b)) for a, b in bodies if a != b)
        return found

    def _recent(self, since: int) -> list[tuple[Any, ...]]:
        """The readings with contacts from engine step `since` on."""
        first = bisect_left(self._ticks, since)
        count = sum(1 for n in self._counts[first:] if n)
        return self._parts[len(self._parts) - count :]

    def blows(self, since: int) -> FloatArray:
        """(nbody,) N·s of normal impulse on MuJoCo's bodies since engine step `since`.

        From other objects alone: what the parts of one object do to each other is left out.
        """
        parts = self._recent(since)
        total = np.zeros(self._count)
        if not parts:
            return total
        first = bisect_left(self._ticks, since)
        ticks = self._ticks[first:]
        ends = [*ticks[1:], ticks[0] // self._substeps * self._substeps + self._substeps]
        lasting = [
            (end - tick) * self._dt
            for tick, end, count in zip(ticks, ends, self._counts[first:], strict=True)
            if count
        ]
        rows = self._rows[len(self._rows) - len(parts) :]
        for part, forces, seconds in zip(parts, rows, lasting, strict=True):
            geom, address = part[0], part[4]
            bodies = self._bodies(geom, part[-1])
            active = (address >= 0) & (bodies[:, 0] != bodies[:, 1])
            impulse = forces[address[active]] * seconds
            for side in (0, 1):
                solid = geom[active, side] >= 0
                owner = self._geom_owner[geom[active, side][solid]]
                np.add.at(total, owner, impulse[solid])
        return total

    def contacts(self, last_tick: int) -> NDArray[np.void]:
        """`CONTACT_DTYPE` rows, sorted by step, then a, then b."""
        if not self._parts:
            return np.zeros(0, CONTACT_DTYPE)
        columns = zip(*self._parts, strict=True)
        geom, distance, point, frame, address, dims, flex = (
            None if column[0] is None else np.concatenate(column) for column in columns
        )
        assert geom is not None
        assert distance is not None
        assert point is not None
        assert frame is not None
        assert address is not None
        normal = frame[:, :3]
        force = self._normal_forces(address, dims)
        reading = np.repeat(np.arange(len(self._ticks)), self._counts)
        bodies = self._bodies(geom, flex)
        active = (address >= 0) & (bodies[:, 0] != bodies[:, 1])
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

    def _normal_forces(self, address: IntArray, dims: IntArray | None) -> FloatArray:
        """Normal force of each contact, N, 0 where it is not active."""
        force = np.zeros(len(address))
        starts = np.concatenate([[0], np.cumsum([len(rows) for rows in self._rows])[:-1]])
        counts = [count for count in self._counts if count]
        rows = np.concatenate(self._rows)
        active = address >= 0
        at = address + np.repeat(starts, counts)
        force[active] = rows[at[active]]
        if dims is not None:
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
