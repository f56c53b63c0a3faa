"""Impulses of contacts from what became of the momentum.

Readings tell what a contact does at single engine steps; a body that rolls over its edges is hit
and let go many times in between. But the momentum that an object gains over a control step, less
that of its weight, is exactly what its contacts gave it. Where it touches one thing alone, that
is the impulse of this contact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.simulation.surfaces import FloatArray
from physagent_studio.simulation.trace import Trace
from physagent_studio.simulation.world import World

LEAST = 0.01
"""Impulses below this share of the weight's are no contact, if the reading saw none."""


def balanced(
    world: World,
    trace: Trace,
    table: NDArray[np.void],
    acts: NDArray[np.bool_],
    velocities: FloatArray,
) -> NDArray[np.void]:
    """The contact table with impulses from momenta where they follow from them.

    table: `CONTACT_DTYPE`, one row per control step and pair that was close. acts: (len(table),)
    whether the readings saw the contact act; rows that neither act nor have an impulse are
    dropped. velocities: (T, N, 3) m/s, of the centres of mass, as the engine has them.
    """
    if world.compiled.reach is None or not len(table):
        return table[acts]
    step, one, sign = _alone(trace, table, velocities.shape[1])
    known = np.flatnonzero(sign)
    step, one, sign = step[known], one[known], sign[known]
    masses = np.array([part.mass for part in world.parts])
    fall = np.array(world.program.scene.gravity) * world.step_seconds
    gained = velocities[step + 1, one] - velocities[step, one] - fall
    speed = sign * np.einsum("ij,ij->i", gained, table["normal"][known])
    table["impulse"][known] = masses[one] * np.maximum(speed, 0)
    acts[known] |= speed > LEAST * float(np.linalg.norm(fall)) + 1e-9
    return table[acts]


def _alone(
    trace: Trace, table: NDArray[np.void], count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]:
    """For each row its step, an object that touches nothing else on that step, and the sign of
    the normal that points at it; sign 0 where there is none.
    """
    rows, width = trace.rows - 1, count + 1
    quiet = np.zeros(rows, bool)
    steps = np.array(trace.log.undisturbed, np.int64)
    quiet[steps[steps < rows]] = True
    step, a, b = (table[name].astype(np.int64) for name in ("step", "a", "b"))
    # All supports count as one, which is never alone.
    at_a, at_b = step * width + a, step * width + np.minimum(b, count)
    partners = np.bincount(at_a, minlength=rows * width)
    partners += np.bincount(at_b, minlength=len(partners))
    only_a, only_b = partners[at_a] == 1, (partners[at_b] == 1) & (b < count)
    sign = np.where(only_a, -1.0, np.where(only_b, 1.0, 0.0))
    return step, np.where(only_a, a, b), sign * quiet[step]
