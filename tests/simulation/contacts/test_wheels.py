"""What stands on wheels goes along its own axis, and lying on its side it slides."""

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.program import Directed, SceneObject
from physagent_studio.program.actions import (
    ApplyAngledForce,
    ApplyForce,
    SetOrientation,
    SetPosition,
    SetVelocity,
)
from physagent_studio.program.rotations import about_axis, about_up, matrix_of, multiply
from physagent_studio.program.scene.state import Box, Meshed, Ramp, Slab, Sphere, Wheels
from physagent_studio.records.scene import Mesh
from physagent_studio.simulation import Simulator, simulate
from physagent_studio.simulation.surfaces import hull, mass_properties

G = 9.81
ARRAYS = ("positions", "rotations", "velocities", "angular", "contacts", "kinetic", "snapshots")


def car(heading: float = 30.0, *, at=(0.0, 0.0, 0.05), turn=None, **wheels) -> SceneObject:
    """A box of .4 × .2 × .1 m whose long side lies along its heading."""
    body = thing("car", Box(size=(0.4, 0.2, 0.1)), at, rotation=about_up(math.radians(heading)))
    update: dict[str, object] = {"wheels": Wheels(heading=heading, **wheels)}
    if turn is not None:
        update["rotation"] = multiply(about_up(math.radians(heading)), turn)
    return body.model_copy(update=update)


def push(force, *, duration=20, start=4, point=None) -> ApplyForce:
    return ApplyForce(
        id="push", name="car", force=force, duration=duration, start_step=start, point=point
    )


def way_of(rollout, index=0) -> float:
    path = rollout.positions[-1, index] - rollout.positions[0, index]
    return math.degrees(math.atan2(path[1], path[0]))


def turned(rollout, index=0) -> float:
    first, last = (matrix_of(rollout.rotations[row, index].tolist()) for row in (0, -1))
    return math.degrees(math.acos(min((np.trace(first.T @ last) - 1) / 2, 1.0)))


@pytest.mark.parametrize("aside", [-30, 30])
@pytest.mark.parametrize("kind", ["target_speed", "acceleration"])
def test_a_push_off_its_axis_moves_it_along_its_axis(aside, kind):
    force = Directed(magnitude=2.0, direction="right", azimuth=30 + aside, quantity=kind)
    rollout = simulate(program([car(grip=0.9)], [ground()], [push(force, duration=30)]))
    assert np.linalg.norm(rollout.positions[-1, 0] - rollout.positions[0, 0]) > 0.2
    assert way_of(rollout) == pytest.approx(30, abs=2)
    assert turned(rollout) < 2


def test_a_push_at_its_corner_does_not_turn_it():
    force = Directed(magnitude=2.0, direction="right", azimuth=50, quantity="acceleration")
    action = push(force, duration=30, point=(-0.2, 0.1, 0))
    rollout = simulate(program([car(grip=0.9)], [ground()], [action]))
    assert way_of(rollout) == pytest.approx(30, abs=2)
    assert turned(rollout) < 2


@pytest.mark.parametrize("rolling", [0.01, 0.05])
def test_it_rolls_as_far_as_its_resistance_says(rolling):
    speed = 0.8
    ahead = (speed * math.cos(math.radians(30)), speed * math.sin(math.radians(30)), 0.0)
    go = SetVelocity(id="go", name="car", velocity=ahead)
    one = car(rolling=rolling)
    rollout = simulate(program([one], [ground()], [go], seconds=speed / (rolling * G) + 1))
    far = np.linalg.norm(rollout.positions[-1, 0] - rollout.positions[0, 0])
    assert far == pytest.approx(speed**2 / (2 * rolling * G), rel=0.03)
    assert np.linalg.norm(rollout.velocities[-1, 0]) < 1e-6


@pytest.mark.parametrize(("share", "slips"), [(0.8, False), (1.3, True)])
def test_across_it_holds_up_to_its_grip(share, slips):
    force = Directed(magnitude=share * 0.5 * G, direction="away", quantity="acceleration")
    action = push(force, duration=96)
    rollout = simulate(program([car(0.0, grip=0.5)], [ground()], [action], seconds=1.0))
    across = float(rollout.positions[-1, 0, 1])
    # What is over the grip speeds it up.
    seconds = 0.96
    expected = (share - 1) * 0.5 * G * seconds**2 / 2
    assert across == pytest.approx(expected if slips else 0.0, abs=0.05 if slips else 1e-3)


def test_on_its_side_it_slides_as_its_material_does():
    lying = car(0.0, at=(0, 0, 0.1), turn=about_axis((1, 0, 0), math.pi / 2))
    go = SetVelocity(id="go", name="car", velocity=(1.0, 0, 0))
    plain = lying.model_copy(update={"wheels": None})
    slid = simulate(program([plain], [ground()], [go]))
    assert slid.positions[-1, 0, 0] == pytest.approx(1 / (2 * 0.4 * G), rel=0.03)
    # Which side is up is told by the pose at the start, so it is tipped over.
    standing = program([car(0.0)], [ground()], seconds=1.0)
    actions = [
        SetOrientation(id="tip", name="car", rotation=lying.rotation),
        SetPosition(id="put", name="car", position=(0, 0, 0.1)),
        go.model_copy(update={"start_step": 5}),
    ]
    event = standing.event.model_copy(update={"actions": tuple(actions)})
    rollout = simulate(standing.model_copy(update={"event": event}))
    assert rollout.positions[-1, 0, 0] == pytest.approx(1 / (2 * 0.4 * G), rel=0.03)


def test_it_rolls_down_a_slope_and_on_and_stays_across_one():
    lean = math.atan(0.3)
    slope = ground("slope", Ramp(toe=(0, 0, 0), yaw=math.pi, run=1, rise=0.3, width=1))
    start = np.array([-0.6, 0, 0.18]) + 0.05 * np.array([math.sin(lean), 0, math.cos(lean)])
    body = thing(
        "car", Box(size=(0.2, 0.1, 0.1)), tuple(start), rotation=about_axis((0, 1, 0), lean)
    )
    down = body.model_copy(update={"wheels": Wheels(heading=0.0)})
    rollout = simulate(program([down], [ground(), slope], seconds=2.0))
    path = rollout.positions[:, 0]
    assert path[-1, 0] > 0.5
    assert np.abs(path[:, 1]).max() < 1e-3
    across = body.model_copy(update={"wheels": Wheels(heading=90.0, grip=0.8)})
    still = simulate(program([across], [ground(), slope], seconds=1.0)).positions[:, 0]
    assert np.linalg.norm(still[-1] - still[0]) < 2e-3
    energy = (rollout.kinetic + rollout.potential).sum(axis=1)
    assert (np.diff(energy) < 1e-3 * energy.max()).all()


def test_what_it_stands_on_gets_the_opposite():
    tray = thing("tray", Box(size=(0.8, 0.6, 0.04)), (0, 0, 0.02), friction=0.0)
    rider = car(0.0, at=(0, 0, 0.09), rolling=0.1)
    go = SetVelocity(id="go", name="car", velocity=(0.6, 0, 0))
    rollout = simulate(program([tray, rider], [ground(friction=0.0)], [go], seconds=0.6))
    momentum = rollout.masses @ rollout.velocities[:, :, 0].T
    assert momentum[-1] == pytest.approx(momentum[1], rel=0.02)
    assert rollout.velocities[-1, 0, 0] > 0.01


def crash():
    """A car that meets a box and is pushed at a point."""
    force = Directed(magnitude=1.5, direction="right", azimuth=20, quantity="acceleration")
    return program(
        [
            car(10.0),
            thing("box", Box(size=(0.2, 0.2, 0.2)), (0.7, 0.1, 0.1)),
            thing("ball", Sphere(radius=0.1), (-0.6, 0.3, 0.4), restitution=0.5),
        ],
        [ground(), ground("step", Slab(position=(1.5, 0, 0.1), size=(0.4, 0.6, 0.2)))],
        [
            push(Directed(magnitude=1.5, toward="box", quantity="target_speed")),
            push(force, start=90, duration=20, point=(-0.2, 0.1, 0)).model_copy(
                update={"id": "again"}
            ),
        ],
    )


def test_the_same_bits_again_and_from_a_snapshot():
    made = crash()
    first, second = simulate(made), simulate(made)
    later = made.event.actions[1].model_copy(update={"duration": 25})
    event = made.event.model_copy(update={"actions": (made.event.actions[0], later)})
    edited = made.model_copy(update={"event": event})
    anew, resumed = simulate(edited), Simulator().resimulate(edited, {}, first, 90)
    for name in ARRAYS:
        assert np.array_equal(getattr(first, name), getattr(second, name)), name
        assert np.array_equal(getattr(anew, name), getattr(resumed, name)), name


def test_a_scene_without_wheels_has_the_hash_and_key_that_it_had():
    made = program([car()], [ground()])
    bare = made.model_copy(
        update={
            "scene": made.scene.model_copy(
                update={"objects": (made.scene.objects[0].model_copy(update={"wheels": None}),)}
            )
        }
    )
    assert bare.hash != made.hash
    assert '"wheels"' not in bare.scene.model_dump_json(exclude=bare.scene.without)
    assert '"wheels"' in made.scene.model_dump_json(exclude=made.scene.without)


@pytest.mark.parametrize("on_wheels", [True, False])
def test_a_body_that_is_lowest_at_one_corner_stands_on_its_wheels(on_wheels):
    """As what is inflated from the outline of a car that is seen at an angle."""
    x, y, low, top = 0.2, 0.1, -0.05, 0.05
    corners = [(i * x, j * y, top) for i in (-1, 1) for j in (-1, 1)]
    corners += [(-x, -y, low), (-x, 0, low), (0, -y, low), (x, y, 0.0)]
    vertices = np.array(corners)
    surface = hull(vertices, "car")
    vertices, faces = surface
    centre = mass_properties(surface).centre
    mesh = Mesh(vertices - centre, faces)
    shape = Meshed(asset="c" * 16, size=(2 * x, 2 * y, top - low))
    item = thing("car", shape, (0.0, 0.0, float(centre[2]) - low + 1e-5))
    if on_wheels:
        item = item.model_copy(update={"wheels": Wheels(heading=0.0)})
    still = Simulator().simulate(program([item], [ground()], [], seconds=1.0), {"car": mesh})
    assert (turned(still) < 0.5) == on_wheels
    if on_wheels:
        go = SetVelocity(id="go", name="car", velocity=(0.8, 0.0, 0.0))
        moved = Simulator().simulate(program([item], [ground()], [go], seconds=1.0), {"car": mesh})
        assert turned(moved) < 1
        assert moved.positions[-1, 0, 0] > 0.5


def steered(force: float, speed: float = 1.0, *, wheels: bool = True, **given):
    """It rolls to the right at a speed, and is steered from step 10 to 110."""
    start = SetVelocity(id="go", name="car", velocity=(speed, 0, 0))
    bend = ApplyAngledForce(
        id="bend", name="car", magnitude=abs(force), angle=math.copysign(90, force),
        start_step=10, duration=100,
    )  # fmt: skip
    item = car(0.0, rolling=0.0, grip=0.9, **given)
    item = item if wheels else item.model_copy(update={"wheels": None, "friction": 0.0})
    return simulate(program([item], [ground()], [start, bend]))


@pytest.mark.parametrize(("force", "speed"), [(2.0, 1.0), (-2.0, 1.0), (1.0, -1.0)])
def test_a_force_across_its_way_steers_it(force, speed):
    rollout = steered(force, speed)
    mass = 500.0 * 0.4 * 0.2 * 0.1
    way = rollout.velocities[110:, 0, :2].mean(0)
    bent = math.degrees(math.atan2(way[1], way[0]) - (0 if speed > 0 else math.pi))
    bent = (bent + 180) % 360 - 180
    # It turns by force · time / (mass · speed), and faces where it goes.
    assert bent == pytest.approx(math.degrees(force / (mass * abs(speed))), rel=0.05)
    assert turned(rollout) == pytest.approx(abs(bent), abs=1)
    assert np.hypot(*way) == pytest.approx(abs(speed), rel=0.02)


def test_it_turns_no_tighter_than_its_wheels_can_be_turned():
    rollout = steered(1000.0)
    path = rollout.positions[10:110, 0, :2]
    width = np.ptp(path, axis=0).max()
    # The least circle is as wide as it is long.
    assert width == pytest.approx(0.4, rel=0.15)


def test_without_wheels_the_force_pushes_and_turns_nothing():
    rollout = steered(2.0, wheels=False)
    assert turned(rollout) < 1
    assert abs(way_of(rollout)) > 3
