"""Turns a vector of the program, plain or by meaning, into numbers while it runs."""

import math

import numpy as np

from physagent_studio.program import Directed
from physagent_studio.program.base import DIRECTIONS
from physagent_studio.program.scene import forms
from physagent_studio.simulation.surfaces import FloatArray


def unit_of(
    vector: Directed, position: FloatArray, velocity: FloatArray, place: FloatArray | None
) -> FloatArray:
    """The world direction (3,) that a directed vector means now.

    position, velocity: of the target. place: where `toward` is. At rest, or at the place
    itself, a direction that depends on it is +x, as the peers have it.
    """
    if vector.direction is not None:
        raw = np.array(DIRECTIONS[vector.direction], float)
    elif vector.along is not None:
        raw = velocity if vector.along == "velocity" else -velocity
    else:
        assert place is not None
        raw = place - position
        if vector.horizontal:
            raw = raw * [1, 1, 0]
    length = float(np.linalg.norm(raw))
    unit = raw / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return _raised(turned(unit, vector.azimuth), vector.elevation)


def turned(unit: FloatArray, degrees: float) -> FloatArray:
    """A vector (3,) turned about the vertical."""
    if degrees == 0:
        return unit
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y, z = unit
    return np.array([cos * x - sin * y, sin * x + cos * y, z])


def _raised(unit: FloatArray, degrees: float) -> FloatArray:
    """Turns towards +z in the vertical plane of `unit`; a vertical one keeps its direction."""
    flat = math.hypot(unit[0], unit[1])
    if degrees == 0 or flat < 1e-9:
        return unit
    angle = math.atan2(unit[2], flat) + math.radians(degrees)
    heading = unit[:2] / flat
    return np.array([*(heading * math.cos(angle)), math.sin(angle)])


def support_centre(shape: forms.SupportShape, near: FloatArray | None = None) -> FloatArray:
    """A point (3,) of a support that `toward` aims at: its middle, or nearest to `near`.

    Half-spaces have no middle: the foot of the perpendicular from `near` stands for it.
    """
    origin = np.zeros(3) if near is None else near
    match shape:
        case forms.Floor(height=height):
            return np.array([origin[0], origin[1], height])
        case forms.Wall(point=point, yaw=yaw):
            normal = np.array([math.cos(yaw), math.sin(yaw), 0.0])
            return origin - normal * float(normal @ (origin - np.array(point)))
        case (
            forms.Slab(position=position)
            | forms.Vessel(position=position)
            | forms.MeshedSupport(position=position)
        ):
            return np.array(position, float)
        case forms.Ramp(toe=toe, yaw=yaw, run=run, rise=rise):
            ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0]) * run / 2
            return np.array(toe, float) + ahead + [0, 0, rise / 2]
