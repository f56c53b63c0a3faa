"""Impulses of contacts from what became of the momentum.

Readings tell what a contact does at single engine steps; a body that rolls over its edges is hit
and let go many times in between. But the momentum that an object gains over a control step, less
that of its weight, is exactly what its contacts gave it. Where it touches one thing alone, that
is the impulse of this contact.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.contacts.touches import Touching
from physagent_studio.simulation.stepping.trace import Trace
from physagent_studio.simulation.surfaces import FloatArray

LEAST = 0.01
"""Impulses below this share of the weight's are no contact, if the reading saw none."""


def balanced(world: World, trace: Trace, touching: Touching, velocities: FloatArray) -> Touching:
    """The contacts with impulses from momenta where they follow from them.

    Rows of things that are close and have an impulse act, whatever the readings say. velocities:
    (T, N, 3) m/s, of the centres of mass, as the engine has them.
    """
    if world.compiled.reach is None or not len(touching.step):
        return touching
    one, sign = _alone(trace, touching, velocities.shape[1])
    known = np.flatnonzero(sign)
    step, one, sign = touching.step[known], one[known], sign[known]
    masses = np.array([part.mass for part in world.parts])
    fall = np.array(world.program.scene.gravity) * world.step_seconds
    gained = velocities[step + 1, one] - velocities[step, one] - fall * world.falls[one, None]
    speed = sign * np.einsum("ij,ij->i", gained, touching.normal[known])
    impulse, acts = touching.impulse.copy(), touching.acts.copy()
    impulse[known] = masses[one] * np.maximum(speed, 0)
    acts[known] |= speed > LEAST * float(np.linalg.norm(fall)) + 1e-9
    return replace(touching, impulse=impulse, acts=acts)


def _alone(trace: Trace, touching: Touching, count: int) -> tuple[NDArray[np.int64], FloatArray]:
    """For each row an object that touches nothing else on that step, and the sign of the normal
    that points at it; sign 0 where there is none.
    """
    rows, width = trace.rows - 1, count + 1
    # After a blow-up there are readings beyond the rows that are kept.
    quiet = np.zeros(max(rows, int(touching.step[-1]) + 1), bool)
    steps = np.array(trace.log.undisturbed, np.int64)
    quiet[steps[steps < rows]] = True
    step, a, b = touching.step, touching.a, touching.b
    # All supports count as one, which is never alone.
    at_a, at_b = step * width + a, step * width + np.minimum(b, count)
    partners = np.bincount(np.concatenate([at_a, at_b]))
    only_a, only_b = partners[at_a] == 1, (partners[at_b] == 1) & (b < count)
    sign = np.where(only_a, -1.0, np.where(only_b, 1.0, 0.0))
    return np.where(only_a, a, b), sign * quiet[step]
