"""No impact goes unseen, whatever else lifts or lands in the same engine step."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.program.text.document import load_program
from physagent_studio.simulation import simulate

PUSHED = """
scene:
  objects:
    - {{name: ball, shape: {{kind: sphere, radius: 0.1}}, position: [-0.8, 1.5, 0.1],
       support: floor, material: rubber}}
    - {{name: box, shape: {{kind: box, size: [0.2, 0.2, 0.3]}}, position: [{x}, 1.5, 0.15],
       support: floor, material: wood}}
  supports:
    - {{name: floor, shape: {{kind: floor}}}}
event:
  actions:
    - {{operator: ApplyForce, id: push, name: ball, start_step: 10, duration: 20,
       force: {{magnitude: {speed}, toward: box, quantity: target_speed}}}}
"""


@pytest.mark.parametrize("speed", [0.8, 1.5, 2.2])
@pytest.mark.parametrize("x", [0.0, 0.003, 0.0071, 0.0113, 0.0172])
def test_what_moves_a_box_has_touched_it(speed: float, x: float) -> None:
    rollout = simulate(load_program(PUSHED.format(speed=speed, x=x)))
    ball, box = rollout.bodies.index("ball"), rollout.bodies.index("box")
    moving = np.abs(rollout.velocities[:, rollout.objects.index("box"), 0]) > 1e-3
    assert moving.any(), "the ball arrives"
    table = rollout.contacts
    hits = table[(table["a"] == ball) & (table["b"] == box)]
    assert len(hits)
    assert abs(int(hits["step"][0]) - int(np.argmax(moving))) <= 1
    after = int(hits["step"][0]) + 2
    momentum = rollout.masses * np.abs(rollout.velocities[after, :, 0])
    gained = momentum[rollout.objects.index("box")]
    # The floor takes some of it back by friction.
    assert 0.9 * gained < hits["impulse"][0] < 1.6 * gained
