"""How two materials meet: our rule for friction and restitution, in MuJoCo's terms."""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_studio.program import MATERIALS, SceneObject, Support

IMPEDANCE = (0.99, 0.99, 0.001, 0.5, 2.0)
"""Nearly hard contact (`solimp`): 99 % of the demanded deceleration at any depth."""

STIFFNESS = 0.15
"""√k · dt of the contact spring: larger lifts rebounds at random, smaller sinks under load."""

EXCESS = 0.021
"""What the spring adds to the restitution of a lively contact on average; it is taken off."""

LIVELIEST = 0.97
"""Restitution above this could gain energy by the spring's scatter."""


@dataclass(frozen=True, slots=True)
class Touch:
    """What a surface brings to a contact: Coulomb friction, restitution, rolling resistance."""

    friction: float
    restitution: float
    rolling: float = 0.0


def touch_of(item: SceneObject | Support) -> Touch:
    """The surface of an object or support: its own numbers, else its material's."""
    row = MATERIALS.get(item.material, MATERIALS["plastic"])
    friction = row.friction if item.friction is None else item.friction
    restitution = row.restitution if item.restitution is None else item.restitution
    rolling = row.rolling if item.rolling is None else item.rolling
    return Touch(friction, restitution, rolling)


def density_of(item: SceneObject) -> float:
    """kg/m³: its own number, else its material's."""
    if item.density is not None:
        return item.density
    return MATERIALS.get(item.material, MATERIALS["plastic"]).density


def combine(first: Touch, second: Touch) -> Touch:
    """Geometric means: a slippery or a dead surface governs, equal ones keep their value.

    What rolling costs either of them adds up.
    """
    return Touch(
        math.sqrt(first.friction * second.friction),
        math.sqrt(first.restitution * second.restitution),
        first.rolling + second.rolling,
    )


def reference(restitution: float, dt: float, slow_depth: float = 0.0) -> tuple[float, float]:
    """MuJoCo's direct `solref` (−stiffness, −damping) that bounces with `restitution`.

    The damper alone reverses the approach speed within one engine step: a = −(1 + e) v / dt.
    slow_depth: an overlap in m that must come apart slowly (0.1 m/s), not be shot out.
    """
    lively = min(restitution, LIVELIEST)
    # A dead contact loses the excess while it comes apart, a lively one keeps it.
    damping = (1 + lively - EXCESS * lively / (lively + 0.3)) / dt
    stiffness = (STIFFNESS / dt) ** 2
    if slow_depth > 0:
        stiffness = min(stiffness, 0.1 * damping / slow_depth)
    return -stiffness, -damping
