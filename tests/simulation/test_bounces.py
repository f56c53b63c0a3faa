"""No bounce gives more than came in, whatever the shape and however it turns."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.benchmark.physics_scenes import ground, program, thing
from physagent_studio.program.actions import SetAngularVelocity, SetVelocity
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene import Box, Capsule, Cylinder, Ellipsoid
from physagent_studio.simulation import Simulator

SHAPES = {
    "box": Box(size=(0.1, 0.15, 0.2)),
    "plate": Box(size=(0.2, 0.2, 0.02)),
    "can": Cylinder(radius=0.05, height=0.15),
    "disc": Cylinder(radius=0.1, height=0.03),
    "egg": Ellipsoid(radii=(0.12, 0.04, 0.04)),
    "pill": Capsule(radius=0.04, height=0.2),
}
ELASTIC_STEPS = 6
"""Control steps for which a contact may hold energy that the books do not show."""


def tumbling(shape, restitution, seed):
    """A thing thrown and spun at random from 0.6 m above a floor of the same restitution."""
    draw = np.random.default_rng(seed)
    turned = about_axis(tuple(draw.normal(size=3).tolist()), float(draw.uniform(0, 3)))
    item = thing("it", shape, (0, 0, 0.6), rotation=turned, restitution=restitution, friction=0.5)
    spin = tuple((5 * draw.normal(size=3)).tolist())
    actions = [
        SetVelocity(id="throw", name="it", velocity=(1, 0, 0)),
        SetAngularVelocity(id="spin", name="it", angular_velocity=spin),
    ]
    floor = ground(restitution=restitution, friction=0.5)
    return program([item], [floor], actions, seconds=2.0)


def gained(rollout):
    """J that appear beyond the level of the moment before, over all control steps."""
    total = (rollout.kinetic + rollout.potential).sum(axis=1)[2:]
    before = np.lib.stride_tricks.sliding_window_view(total, ELASTIC_STEPS).max(axis=1)[:-1]
    return float(np.maximum(total[ELASTIC_STEPS:] - before, 0).sum())


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("restitution", [0.5, 0.7])
def test_what_tumbles_gains_no_energy_in_a_bounce(name, restitution):
    simulator = Simulator()
    for seed in range(4):
        rollout = simulator.simulate(tumbling(SHAPES[name], restitution, seed))
        start = rollout.kinetic[2, 0] + rollout.masses[0] * 9.81 * 0.6
        assert gained(rollout) < 0.01 * start, seed


def test_what_slides_and_spins_flat_does_not_hop():
    box = thing("box", Box(size=(0.4, 0.3, 0.1)), (0, 0, 0.05), friction=0.4)
    actions = [
        SetVelocity(id="push", name="box", velocity=(2, 0, 0)),
        SetAngularVelocity(id="spin", name="box", angular_velocity=(0, 0, 6)),
    ]
    rollout = Simulator().simulate(program([box], [ground(friction=0.4)], actions, seconds=1.0))
    assert rollout.positions[:, 0, 2].max() < 0.052
    assert rollout.positions[-1, 0, 0] > 0.4


def test_a_run_that_goes_on_while_something_rocks_has_the_same_bits():
    clip = tumbling(SHAPES["can"], 0.5, 1)
    simulator = Simulator()
    whole = simulator.simulate(clip)
    for frame in range(8, 30, 4):
        again = simulator.resimulate(clip, {}, whole, frame * whole.steps_per_frame)
        assert np.array_equal(again.positions, whole.positions), frame
        assert again.contacts.tobytes() == whole.contacts.tobytes(), frame
