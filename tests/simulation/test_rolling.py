"""Rolling resistance: round things come to rest as they do outside."""

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.contract import measure
from physagent_studio.program import SceneObject, Support
from physagent_studio.program.actions import SetAngularVelocity, SetVelocity
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene.state import Box, Cylinder, Floor, Ramp, Sphere
from physagent_studio.simulation import simulate


def test_a_ball_on_a_lawn_comes_to_rest_and_a_slope_steeper_than_its_resistance_moves_it():
    lawn = Support(name="lawn", shape=Floor(), material="grass")
    ball = SceneObject(
        name="ball", shape=Sphere(radius=0.11), position=(0, 0, 0.11), material="leather"
    )
    kick = SetVelocity(id="kick", name="ball", velocity=(2, 0, 0))
    rollout = simulate(program([ball], [lawn], [kick], seconds=6.0))
    assert np.linalg.norm(rollout.velocities[-1, 0]) < 1e-3
    # Slides until it rolls at 5/7 of its speed, then is slowed by 5/7 c g with c = .09 + .01.
    rolling = 10 / 7
    slides = (4 - rolling**2) / (2 * 9.81 * np.sqrt(0.6 * 0.5))
    exact = slides + rolling**2 * 1.4 / (2 * 0.1 * 9.81)
    assert rollout.positions[-1, 0, 0] == pytest.approx(exact, rel=0.05)
    for rise, moves in ((0.05, False), (0.13, True)):
        slope = Support(
            name="slope",
            shape=Ramp(toe=(-2, 0, 0), yaw=0, run=4, rise=4 * rise, width=2),
            material="grass",
        )
        lean = np.arctan(rise)
        place = (-0.11 * np.sin(lean), 0.0, 2 * rise + 0.11 * np.cos(lean))
        still = ball.model_copy(update={"position": place})
        path = simulate(program([still], [slope], seconds=2.0)).positions[:, 0]
        assert (np.linalg.norm(path[-1] - path[0]) > 0.05) == moves


def test_a_spinning_top_of_a_ball_comes_to_rest_too():
    ball = thing("ball", Sphere(radius=0.1), (0, 0, 0.1), rolling=0.02)
    spin = SetAngularVelocity(id="spin", name="ball", angular_velocity=(0, 0, 2))
    rollout = simulate(program([ball], [ground(rolling=0.02)], [spin], seconds=2.0))
    # The torque c m g r slows it by c g / 0.4 r.
    slowing = 0.04 * 9.81 / (0.4 * 0.1)
    assert rollout.angular[11, 0, 2] == pytest.approx(2 - 0.1 * slowing, abs=0.05)
    assert abs(rollout.angular[-1, 0, 2]) < 1e-3


def test_what_does_not_roll_knows_no_rolling_resistance():
    box = thing("box", Box(size=(0.2, 0.2, 0.1)), (0, 0, 0.05))
    go = SetVelocity(id="go", name="box", velocity=(1, 0, 0))
    ends = [
        simulate(program([box.model_copy(update={"rolling": c})], [ground(rolling=c)], [go]))
        for c in (0.0, 0.5)
    ]
    assert np.array_equal(ends[0].positions, ends[1].positions)


@pytest.mark.parametrize(
    "shape", [Cylinder(radius=0.06, height=0.15), Cylinder(radius=0.06, height=0.04)]
)
def test_a_can_that_rolls_over_edges_does_not_sink_into_them(shape):
    lying = about_axis((1, 0, 0), np.pi / 2)
    can = thing("can", shape, (0.7, 0, 0.66), rotation=lying)
    stairs = ground("stairs", Ramp(toe=(0, 0, 0), yaw=0, run=0.75, rise=0.6, width=1, steps=4))
    go = SetVelocity(id="go", name="can", velocity=(-0.4, 0, 0))
    clip = program([can], [ground(), stairs], [go], seconds=2.0)
    rollout = simulate(clip)
    assert rollout.positions[-1, 0, 2] == pytest.approx(0.06, abs=1e-3)
    assert rollout.penetration.max() < 2.5e-3
    assert all(check.ok for check in measure(clip, rollout))
