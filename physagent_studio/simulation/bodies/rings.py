"""A torus: a ring of capsules with a real hole, and the exact weight of the smooth body."""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_studio.program.rotations import about_up, multiply
from physagent_studio.simulation.bodies.primitives import Primitive

FEWEST, MOST = 12, 36
"""Capsules of a ring."""
SAG = 0.15
"""How far a straight piece may lie inside the round ring, as a share of the tube's radius."""
TREAD, EDGE = 0.2, 0.1
"""Half width of the band on which a ring rolls, and half thickness of the discs at its sides, as

shares of the tube's radius. Lens-shaped discs: MuJoCo's contact of a cylinder with a plane is off
by centimetres where their tilt is a rounding error.
"""


@dataclass(frozen=True, slots=True)
class Ring:
    """pieces: capsules, their joints on the ring. rims: discs that stand for the outline on flat

    ground, where a chain of straight pieces would rattle. volume: m³. moments: m², about the body
    axes over the volume. extent: m. shadows: m², silhouettes along the body axes.
    """

    pieces: tuple[Primitive, ...]
    rims: tuple[Primitive, ...]
    volume: float
    moments: tuple[float, float, float]
    extent: tuple[float, float, float]
    shadows: tuple[float, float, float]


def ring(radius: float, tube: float) -> Ring:
    """The ring about z whose tube of radius `tube` runs at `radius` from the middle, m."""
    tube = min(tube, radius)
    across = radius**2 / 2 + 5 / 8 * tube**2
    outer = radius + tube
    broad = 4 * radius * tube + math.pi * tube**2
    return Ring(
        pieces=_chain(radius, tube),
        rims=tuple(
            Primitive("ellipsoid", (outer, outer, EDGE * tube), (0.0, 0.0, side * TREAD * tube))
            for side in (-1, 1)
        ),
        volume=2 * math.pi**2 * radius * tube**2,
        moments=(across, across, radius**2 + 3 / 4 * tube**2),
        extent=(2 * outer, 2 * outer, 2 * tube),
        shadows=(broad, broad, math.pi * (outer**2 - (radius - tube) ** 2)),
    )


def _chain(radius: float, tube: float) -> tuple[Primitive, ...]:
    # The middle of a chord of the ring lies R (1 − cos π/n) inside it.
    turn = math.acos(max(1 - SAG * tube / radius, 0.0))
    count = min(max(math.ceil(math.pi / max(turn, 1e-6)), FEWEST), MOST)
    half = radius * math.sin(math.pi / count)
    middle = radius * math.cos(math.pi / count)
    # Turns a capsule's own axis, z, to y, the direction of the ring where it crosses x.
    lie = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
    out = []
    for number in range(count):
        angle = 2 * math.pi * number / count
        place = (middle * math.cos(angle), middle * math.sin(angle), 0.0)
        out.append(Primitive("capsule", (tube, half, 0.0), place, multiply(about_up(angle), lie)))
    return tuple(out)
