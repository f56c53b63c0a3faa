"""Every operator against its analytic effect, at the edges of its window too."""

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import STILL, ground, program, thing
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
from physagent_studio.program.rotations import about_axis, angle_between, matrices_of, matrix_of
from physagent_studio.program.scene.state import Box, Landmark
from physagent_studio.program.statements import Moves
from physagent_studio.simulation import simulate
from tests.simulation.free_ball import MASS, RADIUS, ball, free, span


def test_nothing_happens_without_gravity_or_actions():
    rollout = free()
    assert (rollout.positions == rollout.positions[0]).all()
    assert not rollout.velocities.any()
    assert rollout.warnings == ()


def test_set_velocity_acts_from_its_step_on():
    rollout = free(SetVelocity(id="go", name="ball", velocity=(1, 2, -3), start_step=10))
    assert not rollout.velocities[:11].any()
    assert rollout.velocities[11:, 0] == pytest.approx(np.tile([1, 2, -3], (70, 1)))
    moved = rollout.positions[40, 0] - rollout.positions[0, 0]
    assert moved == pytest.approx(np.array([1, 2, -3]) * 0.3, abs=1e-12)
    assert span(rollout, "go").work == pytest.approx(0.5 * MASS * 14)
    assert (span(rollout, "go").start, span(rollout, "go").end) == (10, 11)


def test_set_velocity_under_gravity_follows_the_parabola():
    throw = SetVelocity(id="throw", name="ball", velocity=(1, 0, 5), start_step=7)
    hold = FixObject(id="hold", name="ball", duration=7)
    rollout = simulate(program([ball(position=(0, 0, 9))], actions=[hold, throw], seconds=0.8))
    time = np.arange(74) * 0.01
    assert rollout.positions[7:, 0, 2] == pytest.approx(9 + 5 * time - 4.905 * time**2, abs=1e-7)
    assert rollout.velocities[8:, 0, 2] == pytest.approx(5 - 9.81 * time[1:], abs=1e-9)


def test_a_dropped_object_falls_as_galileo_says():
    rollout = simulate(program([ball(position=(0, 0, 50))], seconds=3.2))
    time = np.arange(rollout.steps + 1) * 0.01
    assert rollout.positions[:, 0, 2] == pytest.approx(50 - 4.905 * time**2, abs=1e-8)
    energy = (rollout.kinetic + rollout.potential).sum(1)
    assert energy == pytest.approx(np.full(len(energy), energy[0]), abs=1e-8)


def test_force_gives_its_impulse_within_its_window():
    push = ApplyForce(id="push", name="ball", force=(3, 0, 1), start_step=10, duration=20)
    rollout = free(push)
    gained = np.array([3, 0, 1]) * 0.2 / MASS
    assert not rollout.velocities[:11].any()
    assert rollout.velocities[20, 0] == pytest.approx(gained / 2)
    assert rollout.velocities[30:, 0] == pytest.approx(np.tile(gained, (51, 1)))
    assert span(rollout, "push").work == pytest.approx(0.5 * MASS * gained @ gained, rel=0.01)


def test_force_that_reaches_the_end_of_the_clip():
    push = ApplyForce(id="push", name="ball", force=(1, 0, 0), start_step=79, duration=1)
    rollout = free(push)
    assert rollout.velocities[-2, 0, 0] == 0
    assert rollout.velocities[-1, 0, 0] == pytest.approx(0.01 / MASS)
    assert span(rollout, "push").end == 80


def test_two_forces_add_up():
    rollout = free(
        ApplyForce(id="a", name="ball", force=(1, 0, 0), duration=10),
        ApplyForce(id="b", name="ball", force=(0, 1, 0), start_step=5, duration=10),
    )
    assert rollout.velocities[-1, 0] == pytest.approx(np.array([0.1, 0.1, 0]) / MASS)


@pytest.mark.parametrize("frame", ["body", "world"])
def test_force_at_a_point_turns_the_body(frame):
    turn = about_axis((0, 0, 1), math.pi / 2)
    # The same point, 10 cm to world +y of the centre: body +x after a quarter turn about z.
    point = (0.1, 0, 0) if frame == "body" else (0, 0.1, 1)
    box = thing("box", Box(size=(0.2, 0.2, 0.2)), (0, 0, 1), rotation=turn)
    push = ApplyForce(
        id="push", name="box", force=(1, 0, 0), point=point, point_frame=frame, duration=1
    )
    rollout = free(push, objects=[box])
    mass = 500 * 0.008
    assert rollout.velocities[1, 0] == pytest.approx([0.01 / mass, 0, 0])
    inertia = mass * 0.04 / 6
    assert rollout.angular[1, 0] == pytest.approx([0, 0, -0.1 * 0.01 / inertia], rel=1e-4, abs=1e-9)


def test_torque_gives_angular_momentum():
    torque = ApplyTorque(id="twist", name="ball", torque=(0, 0.02, 0), start_step=5, duration=10)
    rollout = free(torque)
    speed = 0.02 * 0.1 / (0.4 * MASS * RADIUS**2)
    assert not rollout.angular[:6].any()
    assert rollout.angular[15:, 0] == pytest.approx(np.tile([0, speed, 0], (66, 1)))
    energy = 0.5 * 0.4 * MASS * RADIUS**2 * speed**2
    assert span(rollout, "twist").work == pytest.approx(energy, rel=1e-6)


def test_angular_velocity_is_held_against_friction_for_its_duration():
    spin = SetAngularVelocity(
        id="spin", name="ball", angular_velocity=(0, 20, 0), start_step=10, duration=20
    )
    rollout = simulate(program([ball(position=(0, 0, RADIUS))], [ground()], [spin], seconds=0.8))
    assert not rollout.angular[5].round(6).any()
    held = rollout.angular[11:31, 0, 1]
    assert held == pytest.approx(np.full(20, 20.0), rel=0.05)
    # Friction has driven the ball forwards, and slows the spin once it is free.
    assert rollout.velocities[31, 0, 0] == pytest.approx(0.4 * 9.81 * 0.2, rel=0.05)
    assert rollout.angular[40, 0, 1] < 18


def test_angular_velocity_is_in_the_world_frame():
    turn = about_axis((1, 0, 0), 1.0)
    box = thing("box", Box(size=(0.2, 0.2, 0.2)), (0, 0, 1), rotation=turn)
    spin = SetAngularVelocity(id="spin", name="box", angular_velocity=(0, 0, 3))
    rollout = free(spin, objects=[box])
    assert rollout.angular[-1, 0] == pytest.approx([0, 0, 3], abs=1e-6)
    turned = angle_between(rollout.rotations[50, 0], turn)
    assert turned == pytest.approx(1.5, abs=2e-3)


@pytest.mark.parametrize("angle", [0, 90, -90, 180])
def test_angled_force_keeps_its_angle(angle):
    rollout = free(
        SetVelocity(id="go", name="ball", velocity=(0, 2, 0)),
        ApplyAngledForce(id="bend", name="ball", magnitude=2, angle=angle, duration=40),
        seconds=0.4,
    )
    velocity = rollout.velocities[-1, 0]
    if abs(angle) == 90:
        assert np.linalg.norm(velocity) == pytest.approx(2, abs=1e-12)
        turned = 2 / MASS * 0.4 / 2
        side = -math.sin(turned) if angle > 0 else math.sin(turned)
        assert velocity == pytest.approx([2 * side, 2 * math.cos(turned), 0], abs=1e-3)
    else:
        sign = 1 if angle == 0 else -1
        assert velocity == pytest.approx([0, 2 + sign * 2 / MASS * 0.4, 0], abs=1e-9)


def test_angled_force_at_rest_points_right():
    rollout = free(ApplyAngledForce(id="bend", name="ball", magnitude=2, angle=0, duration=5))
    assert rollout.velocities[-1, 0] == pytest.approx([2 * 0.05 / MASS, 0, 0])


def test_gust_and_bump_give_their_impulse():
    gust = ApplyDisturbance(
        id="gust", name="ball", model="gust", amplitude=4, direction="left", duration=20
    )
    assert free(gust).velocities[-1, 0] == pytest.approx([-4 * 0.1 / MASS, 0, 0], rel=1e-4)
    bump = ApplyDisturbance(id="bump", name="ball", model="bump", amplitude=4, duration=10)
    up = 4 * 0.1 * 2 / math.pi / MASS
    assert free(bump).velocities[-1, 0] == pytest.approx([0, 0, up], rel=1e-4)


def test_side_returns_to_rest_after_whole_periods():
    side = ApplyDisturbance(
        id="side", name="ball", model="side", amplitude=4, frequency=5, duration=20
    )
    rollout = free(side)
    assert rollout.velocities[10, 0, 0] == pytest.approx(4 / (math.pi * 5) / MASS, rel=1e-3)
    assert abs(rollout.velocities[20, 0, 0]) < 1e-9


@pytest.mark.parametrize("model", ["shake", "jitter"])
def test_noise_depends_on_its_seed_alone(model):
    def run(seed):
        noise = ApplyDisturbance(
            id="noise", name="ball", model=model, amplitude=3, seed=seed, duration=40
        )
        return free(noise).positions

    assert (run(1) == run(1)).all()
    assert np.abs(run(1) - run(2)).max() > 1e-4


def test_wind_carries_a_ball_towards_its_own_speed():
    light = ball(density=2)
    wind = ApplyDisturbance(id="wind", name="ball", model="wind", amplitude=5, duration=80)
    rollout = free(wind, objects=[light])
    # m v' = k (u − v)²  ⇒  v(t) = u − u / (1 + k u t / m)
    k = 0.5 * 1.204 * 0.47 * math.pi * RADIUS**2
    mass = 2 * 4 / 3 * math.pi * RADIUS**3
    exact = 5 - 5 / (1 + k * 5 * 0.8 / mass)
    assert rollout.velocities[-1, 0, 0] == pytest.approx(exact, rel=2e-3)


def test_wind_in_gusts_swells_to_its_speed_and_ebbs():
    wind = ApplyDisturbance(
        id="wind", name="ball", model="wind", amplitude=5, frequency=2.5, duration=80
    )
    rollout = free(wind, objects=[ball(density=2000)])
    # Slow against the air: m v = k A² ∫ ((1 − cos ω t) / 2)² dt, 3/8 of the time in full gusts.
    k = 0.5 * 1.204 * 0.47 * math.pi * RADIUS**2
    mass = 2000 * 4 / 3 * math.pi * RADIUS**3
    speed = rollout.velocities[:, 0, 0]
    assert speed[80] == pytest.approx(k * 25 * 0.375 * 0.8 / mass, rel=5e-3)
    calm, blown = speed[41] - speed[39], speed[21] - speed[19]
    assert calm < 0.02 * blown


def test_set_position_and_orientation_stop_the_object():
    turn = about_axis((0, 1, 0), 0.7)
    rollout = free(
        SetVelocity(id="go", name="ball", velocity=(1, 0, 0)),
        SetPosition(id="put", name="ball", position=(5, 6, 7), start_step=20),
        SetOrientation(id="turn", name="ball", rotation=turn, start_step=30),
    )
    assert rollout.positions[20, 0] == pytest.approx([0.2, 0, 1])
    assert rollout.positions[21:, 0] == pytest.approx(np.tile([5, 6, 7], (60, 1)))
    assert not rollout.velocities[21:].any()
    assert angle_between(rollout.rotations[-1, 0], turn) < 1e-7
    assert rollout.rotations[30, 0] == pytest.approx([1, 0, 0, 0])


def test_fix_object_holds_the_pose_it_finds_and_lets_go():
    box = thing("box", Box(size=(0.2, 0.2, 0.2)), (0, 0, 5))
    rollout = simulate(
        program(
            [box],
            actions=[
                SetAngularVelocity(id="spin", name="box", angular_velocity=(0, 0, 2)),
                FixObject(id="hold", name="box", start_step=20, duration=30),
            ],
            seconds=0.8,
        )
    )
    held = rollout.positions[20:51, 0]
    assert np.abs(held - held[0]).max() < 1e-5
    assert angle_between(rollout.rotations[20, 0], (1, 0, 0, 0)) == pytest.approx(0.4, abs=1e-3)
    assert angle_between(rollout.rotations[50, 0], rollout.rotations[20, 0]) < 1e-6
    time = 0.3
    assert rollout.positions[80, 0, 2] == pytest.approx(held[-1, 2] - 4.905 * time**2, abs=1e-4)


def test_velocity_toward_an_object_a_place_and_a_point():
    goal = Landmark(name="goal", kind="point", points=((0, 4, 9),))
    base = program([ball(), ball("other", (3, 0, 5))], gravity=STILL, seconds=0.4)
    scene = base.scene.model_copy(update={"landmarks": (goal,)})
    for toward, expected in (
        ("other", (2, 0, 0)),
        ("goal", (0, 2, 0)),
        ((0, -1, 1), (0, -2, 0)),
    ):
        go = SetVelocity(id="go", name="ball", velocity=Directed(magnitude=2, toward=toward))
        event = base.event.model_copy(update={"actions": (go,)})
        rollout = simulate(base.model_copy(update={"scene": scene, "event": event}))
        assert rollout.velocities[1, 0] == pytest.approx(expected)


def test_directions_elevation_and_azimuth():
    vector = Directed(magnitude=2, direction="right", elevation=30, azimuth=90)
    rollout = free(SetVelocity(id="go", name="ball", velocity=vector))
    assert rollout.velocities[1, 0] == pytest.approx([0, math.sqrt(3), 1])


def test_brake_stops_and_does_not_reverse():
    brake = Directed(magnitude=50, along="against_velocity")
    rollout = free(
        SetVelocity(id="go", name="ball", velocity=(1, 1, 0)),
        ApplyForce(id="brake", name="ball", force=brake, start_step=10, duration=40),
    )
    assert np.linalg.norm(rollout.velocities[50:, 0], axis=1).max() < 1e-9
    assert span(rollout, "brake").work == pytest.approx(-MASS, rel=0.02)


def test_acceleration_does_not_depend_on_mass():
    push = Directed(magnitude=3, direction="away", quantity="acceleration")
    heavy = ball(density=5000)
    rollout = free(ApplyForce(id="push", name="ball", force=push, duration=20), objects=[heavy])
    assert rollout.velocities[-1, 0] == pytest.approx([0, 0.6, 0])


@pytest.mark.parametrize("friction", [0.0, 0.3, 0.8])
def test_target_speed_is_reached_whatever_friction_takes(friction):
    box = thing("box", Box(size=(0.2, 0.2, 0.2)), (0, 0, 0.1), friction=friction)
    push = Directed(magnitude=2, direction="left", quantity="target_speed")
    action = ApplyForce(id="push", name="box", force=push, start_step=10, duration=30)
    rollout = simulate(program([box], [ground(friction=friction)], [action], seconds=0.8))
    assert rollout.velocities[40, 0, 0] == pytest.approx(-2, rel=0.05)


def test_start_on_contact():
    kick = SetVelocity(
        id="kick", name="ball", velocity=(1, 0, 0), when=OnContact(a="floor", b="ball", delay=3)
    )
    rollout = simulate(program([ball(position=(0, 0, 0.6))], [ground()], [kick], seconds=0.8))
    touched = int(rollout.contacts["step"][0])
    # Collisions are looked for at the start of each millisecond.
    assert touched == int(math.ceil(1000 * math.sqrt(2 * 0.5 / 9.81)) / 10)
    assert span(rollout, "kick").start == touched + 4
    assert not rollout.velocities[: touched + 5, 0, 0].round(9).any()
    assert rollout.velocities[touched + 5, 0, 0] == pytest.approx(1, abs=0.07)


def test_start_after_another_action_and_time_outs():
    rollout = free(
        ApplyForce(id="first", name="ball", force=(1, 0, 0), duration=10),
        SetVelocity(
            id="second", name="ball", velocity=(0, 1, 0), when=After(action="first", delay=5)
        ),
        SetVelocity(
            id="late",
            name="ball",
            velocity=(0, 0, 9),
            when=After(action="first", delay=5, timeout=9),
        ),
    )
    assert span(rollout, "second").start == 15
    assert span(rollout, "late").start is None
    assert rollout.velocities[-1, 0] == pytest.approx([0, 1, 0])


def test_muted_actions_do_nothing():
    go = SetVelocity(id="go", name="ball", velocity=(1, 0, 0), muted=True)
    assert not free(go).velocities.any()
    assert free(go).spans == ()


def test_force_on_a_turned_body_stays_in_the_world():
    turn = about_axis((0, 0, 1), 1.2)
    box = thing("box", Box(size=(0.2, 0.1, 0.3)), (0, 0, 1), rotation=turn)
    rollout = free(ApplyForce(id="push", name="box", force=(6, 0, 0), duration=10), objects=[box])
    assert rollout.velocities[-1, 0] == pytest.approx([6 * 0.1 / (500 * 0.006), 0, 0])
    assert matrix_of(rollout.rotations[-1, 0].tolist()) == pytest.approx(matrix_of(turn))


def test_fix_object_by_a_point_makes_a_pendulum():
    rod = thing("rod", Box(size=(0.02, 0.02, 0.4)), (0, 0, 1), rotation=about_axis((0, 1, 0), 0.1))
    hang = FixObject(id="hang", name="rod", point=(0, 0, 0.2), duration=80)
    rollout = simulate(program([rod], actions=[hang], seconds=3.2, substeps=10))
    pivot = rollout.positions + np.einsum(
        "tnij,j->tni", matrices_of(rollout.rotations), [0, 0, 0.2]
    )
    assert np.abs(pivot[:80] - pivot[0]).max() < 1e-4
    # A rod swings about its end with T = 2π √(2 L / 3 g); half of it later it is on the far side.
    half = math.pi * math.sqrt(2 * 0.4 / (3 * 9.81))
    row = round(half / 0.01)
    assert rollout.positions[row, 0, 0] == pytest.approx(0.4 * math.sin(0.1), abs=2e-3)
    # Let go, it falls with the motion it has.
    assert rollout.positions[-1, 0, 2] < 0


def test_start_when_a_statement_holds():
    kick = SetVelocity(
        id="kick",
        name="ball",
        velocity=(0, 3, 0),
        when=When(
            statement=Moves(id="m", subject="ball", distance=0.3, direction="right"), delay=2
        ),
    )
    rollout = free(SetVelocity(id="go", name="ball", velocity=(1, 0, 0)), kick)
    # Looked at once a frame: step 32 is the first frame with 0.3 m behind it.
    assert span(rollout, "kick").start == 34
    assert rollout.velocities[-1, 0] == pytest.approx([0, 3, 0])
