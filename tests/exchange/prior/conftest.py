"""A small scene in which a ball moves beside a crate."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Rollout, Scene
from physagent_studio.rendering.compositor import initial_poses
from tests.rendering.scenes import FLOOR, ball, crate, rollout_of, scene_of

FRAMES = 4
Parts = tuple[Scene, Rollout, PhysicalProgram]


@pytest.fixture
def parts() -> Parts:
    first, first_mesh = ball()
    second, second_mesh = crate()
    scene = scene_of([first, second], {"ball": first_mesh, "crate": second_mesh}, [FLOOR])
    positions, rotations = initial_poses(scene)
    moved = np.repeat(positions[None], FRAMES, 0)
    moved[:, 0, 0] += np.linspace(0, 0.4, FRAMES)
    rollout = rollout_of(("ball", "crate"), moved, np.repeat(rotations[None], FRAMES, 0))
    return scene, rollout, PhysicalProgram(scene=scene.state)
