"""Vectors by meaning and friction of sliding things, seen without a clip where that is enough."""

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.program import Directed
from physagent_studio.program.actions import ApplyDisturbance, SetVelocity
from physagent_studio.program.scene.state import Box, Slab
from physagent_studio.simulation import simulate
from physagent_studio.simulation.actions.disturbance import Drag, disturbance
from physagent_studio.simulation.actions.vectors import unit_of

CALM = Drag(1.0, np.eye(3), np.array([1.0, 2.0, 3.0]))


def test_drag_sees_the_silhouette_that_faces_the_wind():
    for axis, area in enumerate((1.0, 2.0, 3.0)):
        force = CALM.force(np.eye(3)[axis] * 4)
        assert force == pytest.approx(np.eye(3)[axis] * 0.5 * 1.204 * area * 16)
    assert not CALM.force(np.zeros(3)).any()


@pytest.mark.parametrize("model", ["gust", "bump", "side", "shake", "jitter"])
def test_disturbances_are_bounded_by_their_amplitude_in_size(model):
    action = ApplyDisturbance(id="d", name="x", model=model, amplitude=3, seed=4, duration=50)
    times = np.linspace(0, 0.5, 200)
    sizes = [np.linalg.norm(disturbance(action, t, 0.5, np.zeros(3), CALM)) for t in times.tolist()]
    assert 0.5 < max(sizes) < 3 * (2.5 if model == "jitter" else 1.001)


def test_toward_drops_height_unless_told_not_to():
    here, there, rest = np.zeros(3), np.array([3.0, 0, 4.0]), np.zeros(3)
    flat = Directed(magnitude=1, toward="x")
    steep = Directed(magnitude=1, toward="x", horizontal=False)
    assert unit_of(flat, here, rest, there) == pytest.approx([1, 0, 0])
    assert unit_of(steep, here, rest, there) == pytest.approx([0.6, 0, 0.8])
    assert unit_of(flat, here, rest, here) == pytest.approx([1, 0, 0])


@pytest.mark.parametrize("friction", [0.2, 0.5, 0.9])
def test_a_sliding_box_does_not_hop(friction):
    box = thing("box", Box(size=(0.2, 0.2, 0.1)), (0, 0, 0.05), friction=friction)
    go = SetVelocity(id="go", name="box", velocity=(2, 0, 0))
    rollout = simulate(program([box], [ground(friction=friction)], [go], seconds=1.2))
    assert rollout.positions[:, 0, 2].max() < 0.0515


def test_a_thing_pushed_over_the_edge_falls():
    table = ground("table", Slab(position=(0, 0, 0.5), size=(1, 1, 0.1)))
    box = thing("box", Box(size=(0.1, 0.1, 0.1)), (0.3, 0, 0.6))
    go = SetVelocity(id="go", name="box", velocity=(2, 0, 0))
    rollout = simulate(program([box], [ground(), table], [go], seconds=1.6))
    assert rollout.positions[-1, 0, 0] > 0.5
    assert rollout.positions[-1, 0, 2] < 0.1
