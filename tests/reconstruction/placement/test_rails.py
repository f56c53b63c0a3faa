"""A pair of rails is two bars: a ball rolls between them, what is narrower falls through."""

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.knowledge import is_rails, support_kind
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.scene.boards import rails_of
from physagent_studio.program.scene.state import Slab, Sphere
from physagent_studio.reconstruction.placement.rails import standing
from physagent_studio.reconstruction.shapes.meshes import mesh_of, support_mesh, volume_and_centre
from physagent_studio.simulation import simulate

RAILS = Slab(position=(0, 0, 0.25), size=(3.0, 0.2, 0.1), rail=0.02)


def test_names():
    assert is_rails("steel_rails")
    assert is_rails("train_tracks")
    assert support_kind("rails") == "slab"
    assert not is_rails("track")


@pytest.mark.parametrize("size", [(3.0, 0.2, 0.1), (0.2, 3.0, 0.1)])
def test_two_bars_lie_along_the_long_sides(size):
    slab = RAILS.model_copy(update={"size": size})
    bars = rails_of(slab)
    assert len(bars) == 2
    mesh = support_mesh(slab, 1.0)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx(size)
    volume, _ = volume_and_centre(mesh.vertices, mesh.faces)
    assert volume == pytest.approx(2 * 3.0 * 0.02 * 0.1)
    assert len(rails_of(slab.model_copy(update={"rail": None}))) == 1


def test_a_ball_sinks_between_the_rails_and_rolls_along_them():
    shape = Sphere(radius=0.15)
    ball = thing("ball", shape, (-1.0, 0.03, 0.45), friction=0.8)
    x, y, z = standing(ball, mesh_of(shape), RAILS)
    # It touches the inner edges, 0.08 m to each side.
    assert (x, y) == pytest.approx((-1.0, 0.0), abs=1e-9)
    assert z == pytest.approx(0.3 + np.sqrt(0.15**2 - 0.08**2), abs=3e-3)
    ball = ball.model_copy(update={"position": (x, y, z)})
    go = SetVelocity(id="go", name="ball", velocity=(1.0, 0, 0))
    run = simulate(program([ball], [ground("rails", RAILS), ground()], [go], seconds=1.5))
    assert run.positions[-1, 0, 0] > -0.2
    assert np.abs(run.positions[:, 0, 1:] - (y, z)).max() < 6e-3


def test_a_small_ball_falls_through():
    ball = thing("ball", Sphere(radius=0.05), (0, 0, 0.5))
    run = simulate(program([ball], [ground("rails", RAILS), ground()], seconds=1.0))
    assert run.positions[-1, 0, 2] == pytest.approx(0.05, abs=2e-3)
