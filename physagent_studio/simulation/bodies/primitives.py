"""Shapes that MuJoCo knows by itself, and where they sit in a body."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_studio.program.base import IDENTITY


@dataclass(frozen=True, eq=False, slots=True)
class Primitive:
    """kind: sphere, ellipsoid, box, cylinder or capsule; size: MuJoCo's half sizes, m.

    place, turn: pose of the piece in the body frame, m and wxyz.
    """

    kind: str
    size: tuple[float, float, float]
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float, float] = IDENTITY
