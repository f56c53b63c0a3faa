"""What rocks grips hard and what slides gently; see also the bench's figure `bounces`."""

from __future__ import annotations

import numpy as np

from physagent_studio.benchmark.physics_bounces import SHAPES, tumbling
from physagent_studio.benchmark.physics_scenes import ground, program, thing
from physagent_studio.program.actions import SetAngularVelocity, SetVelocity
from physagent_studio.program.scene import Box
from physagent_studio.simulation import Simulator


def test_what_slides_and_spins_flat_does_not_hop():
    box = thing("box", Box(size=(0.4, 0.3, 0.1)), (0, 0, 0.05), friction=0.4)
    for spin in (0, 3, 6):
        actions = [
            SetVelocity(id="push", name="box", velocity=(2, 0, 0)),
            SetAngularVelocity(id="spin", name="box", angular_velocity=(0, 0, spin)),
        ]
        clip = program([box], [ground(friction=0.4)], actions, seconds=1.0)
        rollout = Simulator().simulate(clip)
        assert rollout.positions[:, 0, 2].max() < 0.051
        assert rollout.positions[-1, 0, 0] > 0.4


def test_a_run_that_goes_on_while_something_rocks_has_the_same_bits():
    clip = tumbling(SHAPES["can"], 0.5, 1)
    simulator = Simulator()
    whole = simulator.simulate(clip)
    for frame in range(8, 30, 4):
        again = simulator.resimulate(clip, {}, whole, frame * whole.steps_per_frame)
        assert np.array_equal(again.positions, whole.positions), frame
        assert again.contacts.tobytes() == whole.contacts.tobytes(), frame
