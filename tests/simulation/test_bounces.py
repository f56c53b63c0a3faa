"""What rocks grips hard and what slides gently; see also the bench's figure `bounces`."""

from __future__ import annotations

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.bodies import SHAPES, tumbling
from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.program.actions import SetAngularVelocity, SetVelocity
from physagent_studio.program.scene.state import Box, Frustum, Ramp, Sphere, Torus
from physagent_studio.simulation import Simulator, simulate


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


def wedged(kind, restitution, friction):
    """A ring over a cone or a ball, and what falls between two ramps."""
    surface = {"restitution": restitution, "friction": friction}
    ring = thing("it", Torus(radius=0.06, tube=0.01), (0, 0, 0.3), **surface)
    if kind == "cone":
        post = Frustum(bottom_radius=0.15, top_radius=0.0, height=0.2)
        return program([ring, thing("post", post, (0, 0, 0.05), **surface)], [ground(**surface)])
    if kind == "ball":
        post = thing("post", Sphere(radius=0.07), (0, 0, 0.07), **surface)
        return program([ring, post], [ground(**surface)])
    shape = Sphere(radius=0.05) if kind == "valley" else Box(size=(0.1, 0.1, 0.1))
    run = 0.5 if friction > 0.5 else 0.2
    ramps = [
        ground(
            f"ramp{yaw:.0f}", Ramp(toe=(0, 0, 0), yaw=yaw, run=run, rise=0.5, width=1), **surface
        )
        for number, yaw in enumerate((0, math.pi))
    ]
    return program([thing("it", shape, (0, 0, 0.75), **surface)], [ground(**surface), *ramps])


@pytest.mark.parametrize("kind", ["cone", "ball", "valley", "box"])
@pytest.mark.parametrize(("restitution", "friction"), [(0.3, 0.7), (0.6, 0.2), (0.6, 0.7)])
def test_what_falls_into_a_wedge_is_not_thrown_back(kind, restitution, friction):
    clip = wedged(kind, restitution, friction)
    rollout = simulate(clip)
    whole = (rollout.kinetic + rollout.potential).sum(axis=1)
    # Without a look at the energy some of these gain up to seven times of what they had.
    assert whole.max() < 1.06 * whole[0]
    again = Simulator().resimulate(clip, {}, rollout, 100)
    assert np.array_equal(again.positions, rollout.positions)
    assert np.array_equal(again.contacts, rollout.contacts)


@pytest.mark.parametrize("friction", [0.3, 0.9])
@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_what_is_struck_from_the_side_stays_on_rough_ground(friction, restitution):
    surface = {"friction": friction, "restitution": restitution}
    box = thing("box", Box(size=(0.2, 0.2, 0.2)), (0, 0, 0.1), **surface)
    cart = thing("cart", Box(size=(0.4, 0.2, 0.2)), (-0.6, 0, 0.1), friction=0.1, density=3000)
    go = SetVelocity(id="go", name="cart", velocity=(3, 0, 0))
    clip = program([box, cart], [ground(**surface)], [go], seconds=2.0)
    rollout = Simulator().simulate(clip)
    # It hopped by 0.1 to 0.7 m, at μ times the speed that it takes on, and flew up to 4.8 m.
    assert np.ptp(rollout.positions[:, 0, 2]) < 0.1
    assert 0.5 < rollout.positions[-1, 0, 0] < 3
    again = Simulator().resimulate(clip, {}, rollout, 20)
    assert np.array_equal(again.positions, rollout.positions)
