"""The materials table, and how two surfaces meet."""

import math
from dataclasses import dataclass

from physagent_studio.knowledge import Material as Material
from physagent_studio.knowledge import materials
from physagent_studio.program.scene.state import SceneObject, Support

MATERIALS: dict[str, Material] = materials()
"""The rows of `materials.yaml`, which says in its head what the figures are and where from."""


@dataclass(frozen=True, slots=True)
class Touch:
    """What a surface brings to a contact: Coulomb friction, restitution, rolling resistance."""

    friction: float
    restitution: float
    rolling: float = 0.0


def touch_of(item: SceneObject | Support) -> Touch:
    """The surface of an object or support: its own numbers, else its material's."""
    row = MATERIALS[item.material]
    return Touch(
        row.friction if item.friction is None else item.friction,
        row.restitution if item.restitution is None else item.restitution,
        row.rolling if item.rolling is None else item.rolling,
    )


def density_of(item: SceneObject) -> float:
    """kg/m³: its own number, else its material's."""
    return MATERIALS[item.material].density if item.density is None else item.density


def combine(first: Touch, second: Touch) -> Touch:
    """Geometric means: a slippery or a dead surface governs, equal ones keep their value.

    What rolling costs either of them adds up.
    """
    return Touch(
        math.sqrt(first.friction * second.friction),
        math.sqrt(first.restitution * second.restitution),
        first.rolling + second.rolling,
    )
