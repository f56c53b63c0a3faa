"""The materials table: density, friction, restitution, rolling; by name, with sources."""

from __future__ import annotations

from physagent_studio.knowledge import Material as Material
from physagent_studio.knowledge import materials

MATERIALS: dict[str, Material] = materials()
"""The rows of `materials.yaml`, which says in its head what the figures are and where from."""


def material(name: str) -> Material:
    """The row of that name; the program's validation has made sure that it exists."""
    return MATERIALS[name]
