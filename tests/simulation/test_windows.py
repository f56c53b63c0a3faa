"""Every operator at the edges of its window, every disturbance, every start with its time-out."""

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program
from physagent_studio.program import After, Directed, OnContact
from physagent_studio.program.actions import (
    ApplyAngledForce,
    ApplyDisturbance,
    ApplyForce,
    ApplyTorque,
    FixObject,
    SetAngularVelocity,
    SetOrientation,
    SetPosition,
    SetVelocity,
    When,
)
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.statements import Moves
from physagent_studio.simulation import simulate
from physagent_studio.simulation.actions.disturbance import DEFAULT_FREQUENCY
from tests.simulation.free_ball import MASS, RADIUS, ball, free, span

STEPS = 40
GO = SetVelocity(id="go", name="ball", velocity=(1, 2, 0))
SPIN = SetAngularVelocity(id="spin", name="ball", angular_velocity=(0, 0, 3))
LASTING = {
    "SetAngularVelocity": (SetAngularVelocity, {"angular_velocity": (5, 0, 0)}),
    "ApplyForce": (ApplyForce, {"force": (0, 3, 1)}),
    "ApplyForce at a point": (ApplyForce, {"force": (0, 3, 1), "point": (0.1, 0, 0)}),
    "ApplyForce to a speed": (
        ApplyForce,
        {"force": Directed(magnitude=4, direction="up", quantity="target_speed")},
    ),
    "ApplyTorque": (ApplyTorque, {"torque": (0.01, 0, 0)}),
    "ApplyAngledForce": (ApplyAngledForce, {"magnitude": 2, "angle": 60}),
    "FixObject": (FixObject, {}),
    **{
        f"ApplyDisturbance {model}": (
            ApplyDisturbance,
            {"model": model, "amplitude": 4, "direction": "up", "seed": 3},
        )
        for model in ("wind", "gust", "bump", "side", "shake", "jitter")
    },
}
AT_ONCE = {
    "SetVelocity": (SetVelocity, {"velocity": (0, 0, 4)}),
    "SetPosition": (SetPosition, {"position": (4, 5, 6)}),
    "SetOrientation": (SetOrientation, {"rotation": about_axis((1, 0, 0), 1.0)}),
}


def run(*actions):
    return free(*actions, seconds=STEPS / 100)


def state(rollout):
    """(T, 13) everything that moves."""
    columns = (rollout.positions, rollout.rotations, rollout.velocities, rollout.angular)
    return np.concatenate([column[:, 0] for column in columns], axis=1)


def rates(rollout):
    return np.concatenate([rollout.velocities[:, 0], rollout.angular[:, 0]], axis=1)


@pytest.mark.parametrize(("start", "duration"), [(0, 1), (0, STEPS), (7, 12), (39, 1), (20, 20)])
@pytest.mark.parametrize("name", LASTING)
def test_it_acts_within_its_window_and_only_there(name, start, duration):
    kind, arguments = LASTING[name]
    action = kind(id="it", name="ball", start_step=start, duration=duration, **arguments)
    # The spin is held over its own step, and would speak against what begins with it.
    before = (GO, SPIN) if start else (GO,)
    free, rollout = run(*before), run(*before, action)
    assert np.array_equal(state(rollout)[: start + 1], state(free)[: start + 1])
    assert not np.allclose(rates(rollout)[start + 1], rates(free)[start + 1], atol=1e-9)
    after = rates(rollout)[start + duration :]
    assert after == pytest.approx(np.tile(after[0], (len(after), 1)), abs=1e-9)
    window = span(rollout, "it")
    assert (window.start, window.end) == (start, start + duration)


@pytest.mark.parametrize("start", [0, 7, 39])
@pytest.mark.parametrize("name", AT_ONCE)
def test_it_acts_on_its_step_and_never_again(name, start):
    kind, arguments = AT_ONCE[name]
    action = kind(id="it", name="ball", start_step=start, **arguments)
    # The spin is held over its own step, and would speak against what begins with it.
    before = (GO, SPIN) if start else (GO,)
    free, rollout = run(*before), run(*before, action)
    assert np.array_equal(state(rollout)[: start + 1], state(free)[: start + 1])
    after = rates(rollout)[start + 1 :]
    assert after == pytest.approx(np.tile(after[0], (len(after), 1)), abs=1e-9)
    if name == "SetVelocity":
        assert after[0, :3] == pytest.approx([0, 0, 4])
        return
    assert not after[:, :3].any()
    if name == "SetPosition":
        assert rollout.positions[start + 1, 0] == pytest.approx([4, 5, 6])
    else:
        assert rollout.rotations[start + 1, 0] == pytest.approx(about_axis((1, 0, 0), 1.0))


@pytest.mark.parametrize("model", ["side", "shake", "jitter"])
def test_a_disturbance_is_the_integral_of_its_closed_form(model):
    action = ApplyDisturbance(
        id="it", name="ball", model=model, amplitude=3, seed=5, start_step=5, duration=30
    )
    rollout = run(action)
    draw = np.random.default_rng(5)
    base = DEFAULT_FREQUENCY[model]
    if model == "side":
        rates, phases, scale = np.array([[base], [0], [0]]), np.zeros((3, 1)), np.array([1, 0, 0])
    elif model == "shake":
        phases = draw.uniform(0, 2 * math.pi, 3)[:, None]
        rates, scale = base * np.array([[1.0], [1.13], [0.87]]), np.full(3, 1 / math.sqrt(3))
    else:
        rates = base * draw.uniform(0.3, 1.7, (3, 8))
        phases, scale = draw.uniform(0, 2 * math.pi, (3, 8)), np.full(3, 1 / math.sqrt(24))
    for step in (1, 9, 30):
        seconds, turns = step * 0.01, 2 * math.pi * rates
        waves = (np.cos(phases) - np.cos(turns * seconds + phases)) / np.maximum(turns, 1e-9)
        exact = 3 / MASS * scale * waves.sum(1)
        assert rollout.velocities[5 + step, 0] == pytest.approx(exact, abs=2e-4)


def test_wind_against_the_motion_brakes_by_its_drag():
    wind = ApplyDisturbance(
        id="it", name="ball", model="wind", amplitude=5, direction="left", start_step=10, duration=1
    )
    rollout = run(SetVelocity(id="go", name="ball", velocity=(5, 0, 0)), wind)
    drag = 0.5 * 1.204 * 0.47 * math.pi * RADIUS**2 * 10**2
    lost = rollout.velocities[10, 0, 0] - rollout.velocities[11, 0, 0]
    assert lost == pytest.approx(drag * 0.01 / MASS, rel=5e-3)


KICK = {"id": "kick", "name": "ball", "velocity": (0, 3, 0)}


def dropped(when):
    kick = SetVelocity(**KICK, when=when)
    rollout = simulate(program([ball(position=(0, 0, 0.6))], [ground()], [kick], seconds=0.8))
    return span(rollout, "kick").start, rollout


def test_a_start_on_contact_times_out():
    start, rollout = dropped(OnContact(a="ball", b="floor", delay=2))
    assert start is not None
    assert start == int(rollout.contacts["step"][0]) + 3
    assert dropped(OnContact(a="ball", b="floor", delay=2, timeout=start))[0] == start
    late, rollout = dropped(OnContact(a="ball", b="floor", delay=2, timeout=start - 1))
    assert late is None
    assert not rollout.velocities[:, 0, 1].any()


def test_a_start_on_a_statement_times_out():
    def started(timeout):
        far = Moves(id="m", subject="ball", distance=0.1, direction="right")
        kick = SetVelocity(**KICK, when=When(statement=far, delay=1, timeout=timeout))
        rollout = run(SetVelocity(id="go", name="ball", velocity=(1, 0, 0)), kick)
        return span(rollout, "kick").start

    # Looked at once a frame: step 12 is the first frame with 0.1 m behind it.
    assert started(None) == 13
    assert started(13) == 13
    assert started(12) is None


def test_a_start_after_an_action_times_out():
    def started(timeout):
        push = ApplyForce(id="push", name="ball", force=(1, 0, 0), start_step=3, duration=10)
        kick = SetVelocity(**KICK, when=After(action="push", delay=4, timeout=timeout))
        return span(run(push, kick), "kick").start

    assert started(None) == 17
    assert started(17) == 17
    assert started(16) is None
