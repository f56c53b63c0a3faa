"""Whether a reconstructed scene stays as the photograph shows it while nothing is done to it."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.aloft import AIR, in_air
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.records.scene import Scene
from physagent_studio.simulation import simulate

SECONDS = 2.0
FAR = 0.02
"""How far a thing may move and still be at rest, m."""
TURNED = math.radians(5)


def movers(scene: Scene) -> tuple[str, ...]:
    """Names of objects that move or turn by themselves within two seconds.

    What the picture shows in the air is left out: it falls, and may fall on what stands.
    """
    grounded = _grounded(scene)
    program = PhysicalProgram(scene=scene.state.model_copy(update={"objects": grounded}))
    rollout = simulate(program, scene.meshes)
    last = min(round(SECONDS / program.clip.step_seconds), len(rollout.positions) - 1)
    moved = np.linalg.norm(rollout.positions[last] - rollout.positions[0], axis=1)
    same = np.abs((rollout.rotations[last] * rollout.rotations[0]).sum(-1)).clip(0, 1)
    turned = 2 * np.arccos(same)
    blown = rollout.blown_up is not None
    return tuple(
        item.name
        for k, item in enumerate(grounded)
        if blown or moved[k] > FAR or turned[k] > TURNED
    )


def _grounded(scene: Scene) -> tuple[SceneObject, ...]:
    """The objects but those in the air, and what stands on such a one."""
    kept = scene.state.objects
    falling = {item.name for item in kept if in_air(item)} | {AIR}
    while any(item.support in falling for item in kept):
        falling |= {item.name for item in kept if item.support in falling}
        kept = tuple(item for item in kept if item.name not in falling)
    return kept


def standing(scene: Scene) -> int:
    """How many objects stand on something."""
    return sum(not in_air(item) for item in scene.state.objects)
