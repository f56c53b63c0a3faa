"""Control steps run at a stretch, and the view of the engine's contacts that they rest on."""

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.benchmark.physics.speed import stones
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene.state import (
    Box,
    Cylinder,
    Ellipsoid,
    Floor,
    Ramp,
    Revolved,
    Slab,
    Sphere,
    Wall,
)
from physagent_studio.simulation import Simulator
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.stepping.engine import run
from physagent_studio.simulation.stepping.free_flight import LONGEST, Calm, time_to_meet


def in_detail(clip, meshes, monkeypatch):
    """The same run with every engine step taken one by one."""
    with monkeypatch.context() as patch:
        patch.setattr(Calm, "_steps", lambda *_: 0)
        return Simulator().simulate(clip, meshes)


def first_touches(rollout):
    """The control step on which two things touched first, by pair."""
    found = {}
    for step, a, b in rollout.contacts[["step", "a", "b"]].tolist():
        found.setdefault((a, b), step)
    return found


def rolling_about():
    """Balls that roll towards a wall, one another and down a ramp, and boxes at rest."""
    return program(
        [
            thing("ball", Sphere(radius=0.1), (-0.6, 0, 0.1), restitution=0.6),
            thing("other", Sphere(radius=0.08), (0.4, 0.02, 0.08), restitution=0.6),
            thing("box", Box(size=(0.2, 0.2, 0.2)), (0.1, 0.8, 0.1)),
            thing("lid", Box(size=(0.2, 0.2, 0.05)), (0.1, 0.8, 0.225)),
            thing("runner", Sphere(radius=0.05), (2.4, -1, 0.42)),
        ],
        [
            ground("floor", Floor(), restitution=0.5),
            ground("wall", Wall(point=(1.2, 0, 0), yaw=math.pi), restitution=0.5),
            ground("shelf", Slab(position=(0, 2, 0.5), size=(1, 1, 0.05))),
            ground("ramp", Ramp(toe=(1.5, -1, 0), yaw=0, run=1, rise=0.4, width=0.6)),
        ],
        [SetVelocity(id="roll", name="ball", velocity=(1.2, 0, 0), start_step=30)],
    )


@pytest.mark.parametrize("scene", [(rolling_about(), {}), stones(3)], ids=["rolling", "stones"])
def test_a_run_at_a_stretch_has_the_bits_of_one_step_by_step(scene, monkeypatch):
    clip, meshes = scene
    quick, slow = Simulator().simulate(clip, meshes), in_detail(clip, meshes, monkeypatch)
    assert np.array_equal(quick.positions, slow.positions)
    assert np.array_equal(quick.velocities, slow.velocities)
    assert first_touches(quick) == first_touches(slow)


def test_of_many_pieces_those_that_are_measured_tell_of_all(monkeypatch):
    found, real = [], Calm._measured

    def both(self, data, reach, meeting, engaged, closing, haste):
        out = real(self, data, reach, meeting, engaged, closing, haste)
        every = longest = LONGEST * self._step_seconds
        most = (closing + haste * longest) * longest
        pairs = [ends for pair, *ends in meeting.geoms if pair not in engaged]
        for one, other in pairs:
            gap = mj.mj_geomDistance(self._model, data, one, other, most, self._ends)
            if gap < most:
                speed = reach.approach(meeting, data.qvel.tolist(), self._ends.tolist())
                every = min(every, time_to_meet(gap - speed * self._dt, speed, haste))
        found.append((len(pairs), out, every))
        return out

    outline = ((-0.05, 0.02), (-0.03, 0.03), (0.0, 0.035), (0.05, 0.045))
    cup = Revolved(profile=outline, wall=0.004)
    things = [
        thing("ball", Sphere(radius=0.04), (-0.3, 0.01, 0.04)),
        thing("cup", cup, (0, 0, 0.05)),
        thing("mug", cup, (0.13, 0.02, 0.05)),
    ]
    roll = SetVelocity(id="roll", name="ball", velocity=(1.0, 0, 0), start_step=0)
    monkeypatch.setattr(Calm, "_measured", both)
    Simulator().simulate(program(things, [ground()], [roll], seconds=1.2))
    many = [(out, every) for count, out, every in found if count > 8]
    assert len(many) > 20
    assert all(out == every for out, every in many)
    assert len({out for out, _ in many}) > 10


def test_what_rests_and_flies_is_run_at_a_stretch(monkeypatch):
    calls = []
    real = mj.mj_step
    monkeypatch.setattr(mj, "mj_step", lambda *args: calls.append(args) or real(*args))
    ball = thing("ball", Sphere(radius=0.1), (0, 0, 3), restitution=0.5)
    box = thing("box", Box(size=(0.2, 0.2, 0.2)), (1, 0, 0.1))
    Simulator().simulate(program([ball, box], [ground(restitution=0.5)], seconds=3.2))
    # 320 control steps of 10 engine steps each.
    assert len(calls) < 1200


def test_the_view_of_contacts_is_that_of_the_bindings():
    clip, meshes = stones(3)
    compiled, world, trace = Simulator().prepared(clip, meshes)
    run(world, trace, 0, None)
    data, view = compiled.data, compiled.contacts
    for _ in range(50):
        mj.mj_step(compiled.model, data, 20)
        count, contact = data.ncon, data.contact
        assert count > 0
        assert np.array_equal(view.geoms(), contact.geom)
        for name, width in (("dist", 1), ("pos", 3), ("frame", 9), ("includemargin", 1)):
            at = view.at[name]
            seen = view.numbers[:count, at : at + width].reshape(np.shape(getattr(contact, name)))
            assert np.array_equal(seen, getattr(contact, name)), name
        assert np.array_equal(view.integers[:count, view.at["efc_address"]], contact.efc_address)
        assert np.array_equal(view.integers[:count, view.at["dim"]], contact.dim)


def test_an_object_that_rolls_is_told_the_impulse_of_its_weight():
    ball = thing("ball", Sphere(radius=0.1), (0, 0, 0.1))
    go = SetVelocity(id="go", name="ball", velocity=(1, 0, 0))
    rollout = Simulator().simulate(program([ball], [ground()], [go], seconds=1.0))
    weight = rollout.masses[0] * 9.81 * 0.01
    assert rollout.contacts["impulse"][20:] == pytest.approx(weight, rel=1e-3)


def thrown_about(seed):
    """A few things of random shapes, turned and thrown at random times among four supports."""
    draw = np.random.default_rng(seed)
    objects, actions = [], []
    for number in range(int(draw.integers(2, 6))):
        size = float(draw.uniform(0.03, 0.12))
        shape = (
            Sphere(radius=size),
            Box(size=(2 * size, 1.5 * size, 3 * size)),
            Cylinder(radius=size, height=2 * size),
            Ellipsoid(radii=(size, 0.8 * size, 0.6 * size)),
        )[int(draw.integers(4))]
        x, y, *axis = draw.uniform(-0.5, 0.5, 5).tolist()
        item = thing(
            f"it{number}",
            shape,
            (x, y, 0.15 + 0.3 * number),
            rotation=about_axis(tuple(axis), float(draw.uniform(0, 1))),
            restitution=float(draw.uniform(0, 0.8)),
            rolling=float(draw.choice([0, 0.02])),
        )
        objects.append(item)
        speed, start = tuple(draw.normal(size=3).tolist()), int(draw.integers(0, 100))
        actions.append(
            SetVelocity(id=f"go{number}", name=item.name, velocity=speed, start_step=start)
        )
    supports = [
        ground(restitution=0.5),
        ground("wall", Wall(point=(1, 0, 0), yaw=math.pi), restitution=0.5),
        ground("ramp", Ramp(toe=(-0.6, 0, 0), yaw=math.pi, run=1, rise=0.4, width=1)),
        ground("slab", Slab(position=(0, 0.9, 0.2), size=(0.5, 0.5, 0.1))),
    ]
    return program(objects, supports, actions, seconds=2.4)


@pytest.mark.parametrize("seed", [5, 17, 22, 31, 36, 39])
def test_what_is_thrown_about_has_the_bits_of_a_run_step_by_step(seed, monkeypatch):
    clip = thrown_about(seed)
    quick, slow = Simulator().simulate(clip), in_detail(clip, {}, monkeypatch)
    assert np.array_equal(quick.positions, slow.positions)
    assert first_touches(quick) == first_touches(slow)


def test_a_run_that_goes_on_from_a_frame_has_the_same_contacts():
    clip = rolling_about()
    whole = Simulator().simulate(clip)
    # On step 104, the first of frame 26, two things come apart while the run is at a stretch.
    for frame in (5, *range(22, 30), 50):
        again = Simulator().resimulate(clip, {}, whole, frame * whole.steps_per_frame)
        assert np.array_equal(again.positions, whole.positions)
        assert again.contacts.tobytes() == whole.contacts.tobytes(), frame
