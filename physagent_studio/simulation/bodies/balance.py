"""What keeps its balance: people and animals, whose muscles hold them upright.

A rigid body would fall over where its outline does not stand by itself, as that of somebody who
runs. Such a body resists being tilted as if it were far heavier to turn about level axes; about
the upright one it turns, and along the ground it moves, as before.
"""

from dataclasses import replace

import numpy as np

from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.simulation.bodies.solids import Solid

STIFFNESS = 2000.0
"""Times its own resistance to being turned: by its weight alone it tilts by less than a degree
within a clip."""

STEADYING_S = 0.05
"""s, in which it stops turning on the spot, by itself: what makes it turn is its feet."""


def balanced(solid: Solid, item: SceneObject) -> Solid:
    """The solid with an inertia that keeps it as upright as it is, where the object balances."""
    if not item.balances:
        return solid
    own = solid.mass.inertia
    up = matrix_of(list(item.rotation)).T @ (0.0, 0.0, 1.0)
    level = np.eye(3) - np.outer(up, up)
    about_up = float(up @ own @ up)
    inertia = about_up * np.outer(up, up) + STIFFNESS * float(np.trace(own)) / 2 * level
    return replace(solid, mass=replace(solid.mass, inertia=inertia))
