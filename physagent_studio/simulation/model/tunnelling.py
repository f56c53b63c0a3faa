"""How finely the engine must step so that nothing passes through anything."""

from __future__ import annotations

import math

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.preflight.mechanics import expected_speed
from physagent_studio.program.scene.materials import density_of
from physagent_studio.program.scene.stairs import treads_of
from physagent_studio.program.scene.state import MeshedSupport, Ramp, Slab, Vessel
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
        speed = expected_speed(program, item, mass)
        finest = min(finest, (sizes[index] + min(others)) / (SAFETY * max(speed, 1e-6)))
    return min(max(least, math.ceil(clip.step_seconds / finest - 1e-9)), MAX_SUBSTEPS)
