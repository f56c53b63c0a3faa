"""Contacts during a run: read from the engine sparingly, aggregated per control step and pair.

The engine's contact list is read once every control step, and in between only where bodies have
come close that have not touched yet: where a contact begins to act and on the step after. An
impact passes within one engine step and adds a contact, so none is missed, while what rests,
slides or rolls costs one reading per control step. A reading stands for all engine steps up to
the next one, or to the end of its control step. Where an object touches one thing alone and no
action is at work, the impulse follows from what became of its momentum, see `momentum`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.records import CONTACT_DTYPE
from physagent_studio.simulation.contacts.readings import Mark, Readings
from physagent_studio.simulation.mj import Data, mj
from physagent_studio.simulation.model.model import Compiled
from physagent_studio.simulation.surfaces import FloatArray, IntArray

IntArray64 = NDArray[np.int64]

MANY = 100
"""Contacts from which on a reading leaves out those within one object."""


FAR = 1e3
"""m: distances above this do not matter."""


@dataclass(frozen=True, eq=False, slots=True)
class Touching:
    """Columns of contacts, one row per control step and pair, sorted; see `CONTACT_DTYPE`.

    acts: (n,) whether the readings saw the contact act, and not only the bodies be close.
    """

    step: IntArray64
    a: IntArray64
    b: IntArray64
    point: FloatArray
    normal: FloatArray
    impulse: FloatArray
    depth: FloatArray
    acts: NDArray[np.bool_]

    def table(self, until: int) -> NDArray[np.void]:
        """`CONTACT_DTYPE` rows of what acts before control step `until`."""
        keep = np.flatnonzero(self.acts & (self.step < until))
        table = np.zeros(len(keep), CONTACT_DTYPE)
        for name in CONTACT_DTYPE.names or ():
            table[name] = getattr(self, name)[keep]
        return table


_NONE = np.zeros(0, np.int64)
NOTHING = Touching(
    _NONE, _NONE, _NONE, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0), _NONE > 0
)


class ContactLog:
    """Collects readings; `contacts()` turns them into the rollout's table.

    substeps: engine steps per control step. dt: engine step, s. undisturbed: control steps on
    which no action was at work, began or ended.
    """

    def __init__(self, compiled: Compiled, substeps: int, dt: float) -> None:
        model = compiled.model
        self._geom_bodies = compiled.geom_bodies.astype(np.int64)
        self._flex_bodies = compiled.flex_bodies
        self._model = model
        self._ends = np.zeros(6)
        self._geom_owner = model.geom_bodyid
        self._count = model.nbody
        self._substeps = substeps
        self._dt = dt
        self._pyramid = model.opt.cone == mj.mjtCone.mjCONE_PYRAMIDAL
        self._flexible = len(compiled.flex_bodies) > 0
        self._view = compiled.contacts
        self._readings = Readings(compiled.contacts)
        self.undisturbed: list[int] = []

    def read(self, data: Data, count: int, tick: int, known: bool = False) -> None:
        """Keeps the contacts of the engine step just done, as those of engine step `tick`.

        count: how many there are. known: whether all their impulses will follow from momenta, so
        that forces are not needed.
        """
        if count > MANY:
            # A heap touches itself thousands of times: only what it does to others is kept.
            flex = np.asarray(data.contact.flex) if self._flexible else None
            bodies = self._bodies(self._view.geoms(), flex)
            self._readings.add_some(data, tick, bodies[:, 0] != bodies[:, 1])
        else:
            self._readings.add(data, count, tick, not known)

    def mark(self) -> Mark:
        """How much has been read so far, see `forget`."""
        return self._readings.mark()

    def forget(self, mark: Mark) -> None:
        """Takes back what has been read since `mark`."""
        self._readings.forget(mark)

    def part(self, data: Data, tick: int, pairs: frozenset[int]) -> None:
        """Keeps pairs that were close before engine step `tick` and have come apart since.

        Where they touched is not known any more: the nearest points stand for it.
        """
        model = self._model
        for pair in sorted(pairs):
            one, other = int(model.pair_geom1[pair]), int(model.pair_geom2[pair])
            gap = mj.mj_geomDistance(model, data, one, other, FAR, self._ends)
            across = self._ends[3:] - self._ends[:3]
            normal = across / max(float(np.linalg.norm(across)), 1e-12)
            middle = (self._ends[3:] + self._ends[:3]) / 2
            self._readings.add_apart(tick, (one, other), gap, middle, normal)

    def _bodies(self, geom: IntArray, flex: IntArray | None) -> IntArray64:
        """(n, 2) index among objects-then-supports. flex: (n, 2) where there are any flexes."""
        bodies = self._geom_bodies[geom]
        if self._flexible and flex is not None:
            bodies = np.where(geom >= 0, bodies, self._flex_bodies[flex])
        return bodies

    def _bodies_from(self, row: int) -> IntArray64:
        """The bodies of all contacts from a row on."""
        flex = self._readings.integers("flex", row, 2) if self._flexible else None
        return self._bodies(self._readings.integers("geom", row, 2), flex)

    def active_geoms(self, since: int) -> IntArray:
        """(n, 2) geoms of the contacts that act in the readings from engine step `since` on."""
        row = self._readings.since(since)[1]
        geoms = self._readings.integers("geom", row, 2)
        return geoms[self._readings.integers("efc_address", row) >= 0]

    def touching(self, since: int) -> set[tuple[int, int]]:
        """Pairs (a < b) that touch in the readings from engine step `since` on."""
        row = self._readings.since(since)[1]
        bodies = np.sort(self._bodies_from(row), axis=1)
        active = self._readings.integers("efc_address", row) >= 0
        return {(a, b) for a, b in bodies[active].tolist() if a != b}

    def blows(self, since: int) -> FloatArray:
        """(nbody,) N·s of normal impulse on MuJoCo's bodies in the control step of `since`.

        From other objects alone: what the parts of one object do to each other is left out.
        """
        first, row = self._readings.since(since)
        total = np.zeros(self._count)
        bodies, geom = self._bodies_from(row), self._readings.integers("geom", row, 2)
        active = self._readings.integers("efc_address", row) >= 0
        active &= bodies[:, 0] != bodies[:, 1]
        if not active.any():
            return total
        last = (since // self._substeps + 1) * self._substeps - 1
        impulse = self._normal_forces(first, row) * self._seconds(first, last)
        for side in (0, 1):
            solid = active & (geom[:, side] >= 0)
            np.add.at(total, self._geom_owner[geom[solid, side]], impulse[solid])
        return total

    def contacts(self, last_tick: int) -> Touching:
        """What was close until an engine step, aggregated per control step and pair."""
        if self._readings.empty:
            return NOTHING
        numbers = self._readings.numbers
        ticks = np.repeat(np.array(self._readings.ticks, np.int64), self._readings.counts)
        impulse = self._normal_forces(0, 0) * self._seconds(0, last_tick)
        # Beyond the overlap that the pair started with, see `settle`.
        depth = numbers("includemargin") - numbers("dist")
        return _aggregate(
            ticks // self._substeps,
            self._bodies_from(0),
            numbers("pos", 0, 3),
            numbers("frame", 0, 3),
            impulse,
            depth,
            self._readings.integers("efc_address") >= 0,
        )

    def _normal_forces(self, first: int, row: int) -> FloatArray:
        """Normal force of each contact from a reading and its row on, N, 0 if not active."""
        address = self._readings.integers("efc_address", row).astype(np.int64)
        counts = np.array(self._readings.counts[first:], np.int64)
        counts = counts[counts > 0]
        starts = self._readings.starts[len(self._readings.starts) - len(counts) :]
        at = address + np.repeat(np.array(starts, np.int64), counts)
        active = (address >= 0) & (at >= 0)
        rows = self._readings.forces
        force = np.zeros(len(address))
        force[active] = rows[at[active]]
        if self._pyramid:
            # A pyramid's edges share the normal: their sum is the normal force.
            dims = self._readings.integers("dim", row)
            for edge in range(1, 2 * (int(dims.max(initial=1)) - 1)):
                more = active & (edge < 2 * (dims - 1))
                force[more] += rows[at[more] + edge]
        return force

    def _seconds(self, first: int, last_tick: int) -> FloatArray:
        """For how long each contact from a reading on stands, s."""
        ticks = np.array([*self._readings.ticks[first:], last_tick + 1], np.int64)
        ends = (ticks[:-1] // self._substeps + 1) * self._substeps
        lasting = (np.minimum(ticks[1:], ends) - ticks[:-1]).astype(np.float64)
        return np.repeat(lasting, self._readings.counts[first:]) * self._dt


def _aggregate(
    step: IntArray64,
    bodies: IntArray64,
    point: FloatArray,
    normal: FloatArray,
    impulse: FloatArray,
    depth: FloatArray,
    acts: NDArray[np.bool_],
) -> Touching:
    """One row per control step and pair: impulses added, the deepest point kept."""
    one, other = bodies[:, 0], bodies[:, 1]
    key = (step << 32) | (np.minimum(one, other) << 16) | np.maximum(one, other)
    # Readings come in the order of time, so that little is left to sort.
    order = np.argsort(key, kind="stable")
    within = one == other
    if within.any():
        order = order[~within[order]]
    # A run that blows up leaves contacts that are no numbers.
    key, depth = key[order], np.nan_to_num(depth[order], nan=0.0)
    if not len(key):
        return NOTHING
    starts = np.flatnonzero(np.diff(key, prepend=-1))
    deepest = np.maximum.reduceat(depth, starts)
    hits = np.flatnonzero(depth == np.repeat(deepest, np.diff(starts, append=len(key))))
    first = order[hits[np.searchsorted(hits, starts)]]
    key = key[starts]
    low, high = (key >> 16) & 0xFFFF, key & 0xFFFF
    turned = np.where(one[first] > low, -1.0, 1.0)
    return Touching(
        key >> 32,
        low,
        high,
        point[first],
        normal[first] * turned[:, None],
        np.add.reduceat(impulse[order], starts),
        np.maximum(deepest, 0),
        np.logical_or.reduceat(acts[order], starts),
    )
