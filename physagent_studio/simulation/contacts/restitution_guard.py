"""No impact gives energy away, and no blow makes what it shoves hop.

MuJoCo's friction is associated: what slips after an impact also moves apart, by μ times the slip
that is left over. On one plane that is a small hop. In a wedge, where a body is caught between two
slopes or a ring by a cone, what moves apart on one side slips on the other, and a rebound grows
by 1 / (1 − μ / tan α): a ring of wood let fall onto a cone was thrown back with seven times its
energy. With rest as the aim of every contact, along it as across, no step can gain energy, so
that is how such a control step is run again. A wedge does hold what falls into it.

For the same reason what stands on rough ground and is struck from the side leaves the ground at μ
times the speed that it takes on: a cone that a truck knocks away at 2.5 m/s flew 0.3 m high. The
blow is over long before the ground's friction has done anything, so where something would hop
higher than a little like that, the control step is run again with less of this friction.
"""

import math

import numpy as np

from physagent_studio.simulation.mj import Data, mj
from physagent_studio.simulation.model.model import Compiled, Handle
from physagent_studio.simulation.surfaces import FloatArray, IntArray

GAIN = 0.05
"""Share of the kinetic energy that a control step may gain: what the contact springs scatter."""

LEAST = 1e-3
"""m²/s² of kinetic energy per kg below which nothing is seen to move."""

HOP = 0.03
"""Share of its own size by which what is struck may hop."""

STATE = mj.mjtState.mjSTATE_INTEGRATION.value


class Liveliness:
    """Watches the energy of control steps in which bodies may meet, and what parts in them.

    watches: whether all bodies are rigid, else there is nothing to do.
    """

    def __init__(self, compiled: Compiled, dt: float) -> None:
        self._model, self._data, self._compiled = compiled.model, compiled.data, compiled
        damping = compiled.model.pair_solref[:, 1]
        self._lively = np.flatnonzero(damping < -1.01 / dt)
        self._dead = -1.0 / dt
        self.watches = compiled.reach is not None
        reach = compiled.reach
        self._places = [at for _, at, _, _ in reach.objects] if reach is not None else []
        self._things = int(compiled.geom_bodies.max(initial=0)) + 1
        # m/s with which a thing parts that rises so much; supports are as large as can be.
        self._parting = np.full(self._things, np.inf)
        pull = float(np.linalg.norm(self._model.opt.gravity))
        for index, (_, _, radius, _) in enumerate(reach.objects if reach is not None else ()):
            self._parting[index] = math.sqrt(2 * pull * HOP * 2 * radius) if pull else math.inf
        self._speeds = np.empty((0, 3))
        self._then: Data | None = None
        self._state = np.empty(mj.mj_stateSize(self._model, STATE) if self.watches else 0)
        moving = [handle.body for handle in compiled.handles if isinstance(handle, Handle)]
        self._least = LEAST * float(self._model.body_mass[moving].sum())
        # The engine's own memory, which stays where it is.
        self._both = self._data.energy
        self._energy = self._limit = 0.0

    def mark(self) -> None:
        """Notes the state before a control step."""
        mj.mj_getState(self._model, self._data, self._state, STATE)
        potential, kinetic = self._energies()
        self._energy = potential + kinetic
        self._limit = GAIN * kinetic + self._least
        self._speeds = self._linear()

    def has_gained(self) -> bool:
        """Whether the control step since `mark` has gained more energy than it may."""
        return sum(self._energies()) > self._energy + self._limit

    def hopping(self) -> tuple[IntArray, FloatArray]:
        """Pairs that lay close at `mark` and part too fast since, and the share of their friction
        with which they would not."""
        now = self._linear()
        if np.abs(now - self._speeds).max(initial=0.0) < self._parting.min(initial=np.inf):
            return np.empty(0, np.int32), np.empty(0)
        normals, geoms = self._lay()
        bodies = self._compiled.geom_bodies[geoms]
        before, after = (
            np.einsum("nk,nk->n", (speeds[bodies[:, 1]] - speeds[bodies[:, 0]]), normals)
            for speeds in (self._speeds, now)
        )
        pairs = self._compiled.pair_table[geoms[:, 0], geoms[:, 1]]
        slip = np.linalg.norm(
            now[bodies[:, 1]] - now[bodies[:, 0]] - after[:, None] * normals, axis=1
        )
        most = self._parting[bodies].min(axis=1)
        # What slips parts at μ times that; far slower, and it slipped before, and friction held it.
        owed = 0.5 * self._model.pair_friction[pairs, 0] * slip
        hops = (pairs >= 0) & (np.abs(before) < most) & (after > np.maximum(most, owed))
        found, first = np.unique(pairs[hops], return_index=True)
        return found, (most / np.maximum(after, 1e-9))[hops][first]

    def slippery(self, pairs: IntArray, share: FloatArray) -> FloatArray:
        """Puts the engine back to `mark`, these pairs with a share of their friction; what they
        had, to put back later."""
        mj.mj_setState(self._model, self._data, self._state, STATE)
        kept = self._model.pair_friction[pairs].copy()
        self._model.pair_friction[pairs] = kept * share[:, None]
        return kept

    def rough(self, pairs: IntArray, kept: FloatArray) -> None:
        """Gives pairs their friction back."""
        self._model.pair_friction[pairs] = kept

    def _lay(self) -> tuple[FloatArray, IntArray]:
        """(n, 3) normals and (n, 2) geoms of the contacts at `mark`; the engine has later ones."""
        then = self._then = self._then or mj.MjData(self._model)
        mj.mj_setState(self._model, then, self._state, STATE)
        mj.mj_fwdPosition(self._model, then)
        contact = then.contact
        return np.array(contact.frame).reshape(-1, 9)[:, :3], np.array(contact.geom).reshape(-1, 2)

    def _linear(self) -> FloatArray:
        """(things, 3) m/s; supports stand still."""
        out = np.zeros((self._things, 3))
        for index, at in enumerate(self._places):
            out[index] = self._data.qvel[at : at + 3]
        return out

    def take_back(self) -> np.ndarray:
        """Puts the engine back to `mark` with no pair that rebounds; what to `give_back` later."""
        mj.mj_setState(self._model, self._data, self._state, STATE)
        kept = self._model.pair_solref[self._lively, 1]
        self._model.pair_solref[self._lively, 1] = self._dead
        return kept

    def give_back(self, kept: np.ndarray) -> None:
        """Lets pairs rebound again."""
        self._model.pair_solref[self._lively, 1] = kept

    def _energies(self) -> list[float]:
        """Potential and kinetic, J; places are those of the engine step before, like `xpos`."""
        mj.mj_energyPos(self._model, self._data)
        mj.mj_energyVel(self._model, self._data)
        return self._both.tolist()
