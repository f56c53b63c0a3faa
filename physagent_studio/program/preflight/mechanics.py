"""Volumes, masses, friction and speeds of a program before it runs, from closed forms."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from physagent_studio.program import actions
from physagent_studio.program.base import DIRECTIONS
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene import forms
from physagent_studio.program.scene.boards import open_box
from physagent_studio.program.scene.bodies import Cloth, Rope
from physagent_studio.program.scene.materials import combine, density_of, touch_of
from physagent_studio.program.scene.shapes import Placed, outline_of, place_object, place_support
from physagent_studio.program.scene.state import SceneObject, SceneState, Support


def mass_of(item: SceneObject) -> float | None:
    """Mass in kg, or None while the shape is open. Sheets and ropes weigh what they are thick."""
    if item.shape is None:
        return None
    density = density_of(item)
    if not isinstance(item.body, Cloth | Rope):
        return density * volume_of(item.shape)
    long, wide, _ = sorted((float(side) for side in outline_of(item.shape).size), reverse=True)
    thick = item.body.thickness
    if isinstance(item.body, Cloth):
        return density * (long * wide * thick)
    return density * (math.pi / 4 * thick**2 * long)


def friction_between(first: SceneObject | Support, second: SceneObject | Support) -> float:
    """Coulomb coefficient of a pair: the geometric mean of both."""
    return combine(touch_of(first), touch_of(second)).friction


def gravity_of(scene: SceneState) -> float:
    """Strength of gravity, m/s²."""
    return float(np.linalg.norm(scene.gravity))


def standing(scene: SceneState) -> dict[str, Placed]:
    """Every resolved body at its start, by name, objects first."""
    placed: dict[str, Placed] = {}
    for item in scene.objects:
        if item.shape is not None and item.position is not None:
            placed[item.name] = place_object(item.shape, [item.position], [item.rotation])
    for support in scene.supports:
        if support.shape is not None:
            placed[support.name] = place_support(support.shape)
    return placed


def vector_of(vector: Sequence[float] | actions.Directed) -> tuple[float, float, float] | None:
    """A plain vector, or a named direction's; None where only the run can tell."""
    if not isinstance(vector, actions.Directed):
        x, y, z = vector
        return (float(x), float(y), float(z))
    if vector.direction is None or vector.elevation or vector.azimuth:
        return None
    x, y, z = DIRECTIONS[vector.direction]
    return (x * vector.magnitude, y * vector.magnitude, z * vector.magnitude)


def size_of(vector: Any) -> float:
    """Length of a plain or directed vector."""
    return abs(vector.magnitude) if isinstance(vector, actions.Directed) else math.hypot(*vector)


def speed_gain(action: actions.Action, mass: float, step_seconds: float) -> float:
    """Greatest speed in m/s that an action can give by itself."""
    seconds = actions.duration_of(action) * step_seconds
    match action:
        case actions.SetVelocity(velocity=vector):
            return size_of(vector)
        case actions.ApplyForce(force=vector):
            if isinstance(vector, actions.Directed) and vector.quantity == "target_speed":
                return abs(vector.magnitude)
            if isinstance(vector, actions.Directed) and vector.quantity == "acceleration":
                return abs(vector.magnitude) * seconds
            return size_of(vector) / mass * seconds
        case actions.ApplyAngledForce(magnitude=magnitude):
            return abs(magnitude) / mass * seconds
        case actions.ApplyDisturbance(model="wind", amplitude=amplitude):
            return amplitude
        case actions.ApplyDisturbance(amplitude=amplitude):
            return amplitude / mass * seconds
    return 0.0


def expected_speed(program: PhysicalProgram, item: SceneObject, mass: float | None = None) -> float:
    """A bound of the object's speed in m/s: what it can fall plus what the actions give it.

    mass: kg, where it is known better than from the outline.
    """
    mass, gravity = mass or mass_of(item), gravity_of(program.scene)
    if mass is None or item.position is None:
        return 0.0
    floors = [s.shape.height for s in program.scene.supports if s.shape and s.shape.kind == "floor"]
    height = max(item.position[2] - min(floors), 0.0) if floors else math.inf
    # Without gravity there is no fall, from however high.
    fall = min(math.sqrt(2 * gravity * height), gravity * program.clip.seconds) if gravity else 0.0
    gains = (
        speed_gain(action, mass, program.clip.step_seconds)
        for action in program.event.actions
        if action.name == item.name and not action.muted
    )
    return fall + sum(gains)


Profile = tuple[tuple[float, float], ...]


def volume_of(shape: forms.Shape) -> float:
    """Volume in m³; of an inflated mask or a mesh the estimate that its size allows."""
    match shape:
        case forms.Sphere():
            return 4 / 3 * math.pi * shape.radius**3
        case forms.Ellipsoid():
            return 4 / 3 * math.pi * math.prod(shape.radii)
        case forms.Box():
            if shape.wall is None:
                return math.prod(shape.size)
            return sum(math.prod(edges) for _, edges in open_box(shape.size, shape.wall))
        case forms.Cylinder():
            return math.pi * shape.radius**2 * shape.height
        case forms.Capsule():
            straight = max(shape.height - 2 * shape.radius, 0.0)
            return math.pi * shape.radius**2 * (straight + 4 / 3 * shape.radius)
        case forms.Torus():
            return 2 * math.pi**2 * shape.radius * shape.tube**2
        case forms.Frustum():
            ends = ((0.0, shape.bottom_radius), (shape.height, shape.top_radius))
            return _turned(ends, shape.wall)
        case forms.Revolved():
            return _turned(shape.profile, shape.wall)
        case forms.Inflated():
            return math.pi / 6 * math.prod(shape.size)
        case forms.Meshed():
            return 0.5 * math.prod(shape.size)


def _turned(profile: Profile, wall: float | None) -> float:
    """Of a solid of revolution (z, radius), without the hollow that walls leave."""
    z, radius = np.array(sorted(profile), float).T
    whole = _between(z, radius)
    if wall is None:
        return whole
    bottom = min(float(z[0]) + wall, float(z[-1]))
    heights = np.concatenate([[bottom], z[z > bottom]])
    return whole - _between(heights, np.maximum(np.interp(heights, z, radius) - wall, 0.0))


def _between(z: np.ndarray, radius: np.ndarray) -> float:
    """Frusta between the rows of a profile."""
    parts = np.diff(z) * (radius[1:] ** 2 + radius[1:] * radius[:-1] + radius[:-1] ** 2) / 3
    return abs(float(math.pi * parts.sum()))
