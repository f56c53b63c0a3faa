"""No impact gives energy away: where one would, bodies meet without rebound.

MuJoCo's friction is associated: what slips after an impact also moves apart, by μ times the slip
that is left over. On one plane that is a small hop. In a wedge, where a body is caught between two
slopes or a ring by a cone, what moves apart on one side slips on the other, and a rebound grows
by 1 / (1 − μ / tan α): a ring of wood let fall onto a cone was thrown back with seven times its
energy. With rest as the aim of every contact, along it as across, no step can gain energy, so
that is how such a control step is run again. A wedge does hold what falls into it.
"""

import numpy as np

from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.model.model import Compiled, Handle

GAIN = 0.05
"""Share of the kinetic energy that a control step may gain: what the contact springs scatter."""

LEAST = 1e-3
"""m²/s² of kinetic energy per kg below which nothing is seen to move."""

STATE = mj.mjtState.mjSTATE_INTEGRATION.value


class Liveliness:
    """Watches the energy of control steps in which bodies may meet.

    watches: whether some pair rebounds and all bodies are rigid, else there is nothing to do.
    """

    def __init__(self, compiled: Compiled, dt: float) -> None:
        self._model, self._data = compiled.model, compiled.data
        damping = compiled.model.pair_solref[:, 1]
        self._lively = np.flatnonzero(damping < -1.01 / dt)
        self._dead = -1.0 / dt
        self.watches = compiled.reach is not None and len(self._lively) > 0
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

    def has_gained(self) -> bool:
        """Whether the control step since `mark` has gained more energy than it may."""
        return sum(self._energies()) > self._energy + self._limit

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
