"""A ball in empty space: what actions do to it follows from mechanics alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from physagent_studio.benchmark.physics.scenes import STILL, Vector, program, thing
from physagent_studio.program import Action, SceneObject
from physagent_studio.program.scene.state import Sphere
from physagent_studio.records import ActionSpan, Rollout
from physagent_studio.simulation import simulate

RADIUS = 0.1
MASS = 500 * 4 / 3 * math.pi * RADIUS**3


def ball(name: str = "ball", position: Vector = (0, 0, 1), **numbers: Any) -> SceneObject:
    """A ball of `MASS`, unless numbers say otherwise."""
    return thing(name, Sphere(radius=RADIUS), position, **numbers)


def free(
    *actions: Action, objects: Sequence[SceneObject] = (), seconds: float = 0.8, substeps: int = 10
) -> Rollout:
    """A run without gravity or supports; of one ball unless other objects are given."""
    return simulate(
        program(
            objects or [ball()], actions=actions, gravity=STILL, seconds=seconds, substeps=substeps
        )
    )


def span(rollout: Rollout, action_id: str) -> ActionSpan:
    """When an action acted."""
    return next(item for item in rollout.spans if item.id == action_id)
