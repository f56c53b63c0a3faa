"""How finely the engine must step so that nothing passes through anything."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.program import Action, Directed, PhysicalProgram, duration_of
from physagent_studio.program.actions import (
    ApplyAngledForce,
    ApplyDisturbance,
    ApplyForce,
    SetVelocity,
)
from physagent_studio.program.scene.stairs import treads_of
from physagent_studio.program.scene.state import MeshedSupport, Ramp, Slab, Vessel
from physagent_studio.simulation.bodies.contact_law import density_of
from physagent_studio.simulation.bodies.solids import Solid

SAFETY = 3.0
"""Engine steps that a body takes at least to cross another body and its own extent."""

MAX_SUBSTEPS = 1000

LOOSE = 0.4
"""Share of the clip's substeps in scenes with deformables or grains."""


def substeps_for(program: PhysicalProgram, solids: tuple[Solid, ...]) -> int:
    """Engine steps per control step: the clip's own number, or more where things are fast.

    dt ≤ (extent of the moving body + thickness of what it may hit) / (3 · its fastest speed).
    Half-spaces cannot be passed.
    """
    scene, clip = program.scene, program.clip
    least = clip.substeps
    if any(item.body.kind not in ("rigid", "breakable") for item in scene.objects):
        # Elastic forces are integrated implicitly; 2.5 ms are as good and cost less.
        least = max(1, round(LOOSE * clip.substeps))
    finest = clip.step_seconds / least
    sizes = [float(solid.extent.min()) for solid in solids]
    walls = [min(s.shape.size) for s in scene.supports if isinstance(s.shape, Slab | MeshedSupport)]
    slabs = [s.shape for s in scene.supports if isinstance(s.shape, Slab)]
    walls += [slab.rail for slab in slabs if slab.rail is not None]
    walls += [s.shape.body.wall or 0.0 for s in scene.supports if isinstance(s.shape, Vessel)]
    ramps = [s.shape for s in scene.supports if isinstance(s.shape, Ramp)]
    walls += [tread.top for ramp in ramps for tread in treads_of(ramp)[:1]]
    for index, item in enumerate(scene.objects):
        others = [*sizes[:index], *sizes[index + 1 :], *walls]
        if not others:
            continue
        mass = density_of(item) * solids[index].mass.volume
        speed = _fastest(program, item.name, mass)
        finest = min(finest, (sizes[index] + min(others)) / (SAFETY * max(speed, 1e-6)))
    return min(max(least, math.ceil(clip.step_seconds / finest - 1e-9)), MAX_SUBSTEPS)


def _fastest(program: PhysicalProgram, name: str, mass: float) -> float:
    """A bound in m/s of the speed that falling and the actions can give to an object."""
    scene = program.scene
    gravity = float(np.linalg.norm(scene.gravity))
    speed = gravity * min(program.clip.seconds, _fall_seconds(program, name, gravity))
    for action in program.event.actions:
        if action.name == name and not action.muted:
            speed += _gain(action, mass, program.clip.step_seconds)
    return speed


def _fall_seconds(program: PhysicalProgram, name: str, gravity: float) -> float:
    """How long a fall to the lowest support takes; without one, the whole clip."""
    item = program.scene.object(name)
    floors = [
        float(getattr(s.shape, "height", math.inf))
        for s in program.scene.supports
        if s.shape is not None and s.shape.kind == "floor"
    ]
    if not floors or item is None or item.position is None or gravity <= 0:
        return program.clip.seconds
    return math.sqrt(2 * max(item.position[2] - min(floors), 0.0) / gravity)


def _gain(action: Action, mass: float, step_seconds: float) -> float:
    seconds = duration_of(action) * step_seconds
    match action:
        case SetVelocity(velocity=vector):
            return _size(vector)
        case ApplyForce(force=vector):
            if isinstance(vector, Directed) and vector.quantity == "target_speed":
                return abs(vector.magnitude)
            if isinstance(vector, Directed) and vector.quantity == "acceleration":
                return abs(vector.magnitude) * seconds
            return _size(vector) / mass * seconds
        case ApplyAngledForce(magnitude=size):
            return abs(size) / mass * seconds
        case ApplyDisturbance(model=model, amplitude=size):
            return size if model == "wind" else size / mass * seconds
        case _:
            return 0.0


def _size(vector: tuple[float, ...] | Directed) -> float:
    return abs(vector.magnitude) if isinstance(vector, Directed) else math.hypot(*vector)
