"""What keeps its balance stays as upright as it is, and turns about its own up as before."""

from __future__ import annotations

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.program import SceneObject
from physagent_studio.program.actions import ApplyForce, SetAngularVelocity
from physagent_studio.program.rotations import about_axis, matrix_of
from physagent_studio.program.scene.state import Box
from physagent_studio.records import Rollout
from physagent_studio.simulation import Simulator, simulate

LEAN = about_axis((0.0, 1.0, 0.0), math.radians(12.0))


def post(balances: bool | None = True, lean: bool = False) -> SceneObject:
    """A post of .3 × .3 × 1.5 m, or one that leans beyond its foot."""
    turn = LEAN if lean else (1.0, 0.0, 0.0, 0.0)
    low = 0.75 * math.cos(math.radians(12.0)) + 0.15 * math.sin(math.radians(12.0))
    body = thing("post", Box(size=(0.3, 0.3, 1.5)), (0.0, 0.0, low if lean else 0.75))
    return body.model_copy(update={"rotation": turn, "balances": balances})


def tilt(rollout: Rollout) -> float:
    """Degrees between its up at first and at last."""
    first, last = (matrix_of(rollout.rotations[k, 0].tolist()) for k in (0, -1))
    return math.degrees(math.acos(min(float(first[:, 2] @ last[:, 2]), 1.0)))


def push(newtons: float) -> ApplyForce:
    return ApplyForce(
        id="push", name="post", force=(newtons, 0.0, 0.0), point=(0.0, 0.0, 0.7), start_step=4,
        duration=60,
    )  # fmt: skip


@pytest.mark.parametrize(("balances", "stands"), [(True, True), (None, False)])
def test_it_is_not_pushed_over(balances: bool | None, stands: bool) -> None:
    moving = program([post(balances)], [ground()], [push(400.0)])
    rollout = simulate(moving, {})
    assert (tilt(rollout) < 2.0) == stands
    # It goes along the ground all the same.
    assert rollout.positions[-1, 0, 0] > 0.1


@pytest.mark.parametrize(("balances", "stands"), [(True, True), (None, False)])
def test_what_leans_does_not_fall_by_itself(balances: bool | None, stands: bool) -> None:
    rollout = simulate(program([post(balances, lean=True)], [ground()], []), {})
    assert (tilt(rollout) < 2.0) == stands


def test_it_turns_on_the_spot_and_stops() -> None:
    turning = SetAngularVelocity(
        id="turn", name="post", angular_velocity=(0.0, 0.0, 2.0), start_step=4, duration=50
    )
    rollout = simulate(program([post()], [ground()], [turning]), {})
    ahead = matrix_of(rollout.rotations[-1, 0].tolist())[:, 0]
    turned = math.degrees(math.atan2(ahead[1], ahead[0]))
    assert turned == pytest.approx(math.degrees(2.0 * 0.5), abs=12.0)
    assert np.abs(rollout.angular[-1, 0]).max() < 0.05


def test_a_run_is_the_same_after_another_and_resumed() -> None:
    """The model that is kept for one does not serve for the other, and a run is gone on with."""
    simulator = Simulator()
    still, pushed = (program([post()], [ground()], [push(n)]) for n in (300.0, 400.0))
    before = simulator.simulate(still, {})
    simulator.simulate(program([post(None)], [ground()], [push(300.0)]), {})
    again = simulator.simulate(still, {})
    assert np.array_equal(before.rotations, again.rotations)
    resumed = simulator.resimulate(pushed, {}, before, 4)
    assert np.array_equal(resumed.positions, simulate(pushed, {}).positions)
