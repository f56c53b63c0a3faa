"""What a run promises: the same bits, honest contacts and energies, and no silent blow-up."""

import dataclasses
import hashlib
import io
import json
import subprocess
import sys

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import STILL, ground, program, thing
from physagent_studio.errors import Cancelled, InputError, SimulationError
from physagent_studio.program import After, Clip, Directed, OnContact, SetField, apply
from physagent_studio.program.actions import ApplyForce, FixObject, SetVelocity, When
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene.state import Box, Cylinder, Floor, Ramp, Slab, Sphere, Wall
from physagent_studio.program.statements import Falls
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.rollout_io import (
    rollout_from_bytes,
    rollout_to_bytes,
    save_rollout,
)
from physagent_studio.simulation import Simulator, simulate
from physagent_studio.simulation.stepping import resume

ARRAYS = (
    "positions",
    "rotations",
    "velocities",
    "angular",
    "contacts",
    "kinetic",
    "potential",
    "masses",
    "penetration",
)


RAMP = Ramp(toe=(1, 0, 0), yaw=0, run=1, rise=0.3, width=1)


def busy():
    """Things that hit, roll, wait for each other and are held."""
    return program(
        [
            thing("ball", Sphere(radius=0.1), (-0.6, 0, 0.8), restitution=0.6),
            thing("box", Box(size=(0.2, 0.2, 0.3)), (0.2, 0, 0.15)),
            thing("can", Cylinder(radius=0.05, height=0.15), (0.6, 0.05, 0.08)),
        ],
        [
            ground(restitution=0.5),
            ground("ramp", Ramp(toe=(1, 0, 0), yaw=0, run=1, rise=0.3, width=1)),
        ],
        [
            SetVelocity(id="throw", name="ball", velocity=(1.5, 0, 0)),
            ApplyForce(
                id="push",
                name="box",
                force=Directed(magnitude=1.5, direction="right", quantity="target_speed"),
                start_step=60,
                duration=60,
            ),
            FixObject(id="hold", name="can", start_step=50, duration=120),
            SetVelocity(
                id="kick",
                name="ball",
                velocity=(0, 1, 1),
                when=OnContact(a="box", b="can", delay=2),
            ),
            SetVelocity(
                id="late", name="can", velocity=(0, 0, 2), when=After(action="hold", delay=9)
            ),
        ],
    )


def digest(rollout: Rollout) -> str:
    parts = [getattr(rollout, name).tobytes() for name in ARRAYS]
    parts.append(repr((rollout.spans, rollout.warnings)).encode())
    assert rollout.snapshots is not None
    parts += [rollout.snapshots.tobytes(), *(item.encode() for item in rollout.memories)]
    return hashlib.sha256(b"".join(parts)).hexdigest()


def test_same_bits_again_and_from_a_cached_model():
    simulator = Simulator()
    first = digest(simulator.simulate(busy()))
    # Another scene of the same structure goes through the same cached model in between.
    other = apply(busy(), [SetField(path="scene.objects.ball.density", value=9000.0)])
    assert digest(simulator.simulate(other)) != first
    assert digest(simulator.simulate(busy())) == first
    assert digest(simulate(busy())) == first


@pytest.mark.slow
def test_same_bits_in_another_process():
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from test_runs import busy, digest\n"
        "from physagent_studio.simulation import simulate\n"
        "print(digest(simulate(busy())))"
    )
    folder = __file__.rsplit("/", 1)[0]
    done = subprocess.run(
        [sys.executable, "-c", code, folder], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == digest(simulate(busy()))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("event.actions.push.duration", 70),
        ("event.actions.push.force.magnitude", 0.5),
        ("event.actions.kick.when.delay", 5),
        ("event.actions.late.velocity", [1.0, 0.0, 0.0]),
        ("event.actions.hold.muted", True),
        ("scene.objects.box.friction", 0.9),
    ],
)
def test_resimulate_gives_the_bits_of_a_full_run(path, value):
    before = simulate(busy())
    edited = apply(busy(), [SetField(path=path, value=value)])
    full = simulate(edited)
    assert digest(full) != digest(before)
    for step in (0, 63, 200, 320):
        assert digest(Simulator().resimulate(edited, {}, before, step)) == digest(full), step


def test_resimulate_in_the_middle_of_every_kind_of_waiting():
    wait = When(statement=Falls(id="f", subject="ball", drop=0.3), delay=1)
    waiting = apply(busy(), [SetField(path="event.actions.kick.when", value=wait.model_dump())])
    before = simulate(waiting)
    edited = apply(waiting, [SetField(path="event.actions.late.velocity", value=[0, 0, 1])])
    full = simulate(edited)
    assert full.spans[3].start is not None
    for step in (10, 100, 170, 240):
        assert digest(Simulator().resimulate(edited, {}, before, step)) == digest(full)


def test_a_saved_rollout_comes_back_and_can_be_continued(tmp_path):
    before = simulate(busy())
    save_rollout(tmp_path / "run.npz", before)
    loaded = rollout_from_bytes((tmp_path / "run.npz").read_bytes())
    assert digest(loaded) == digest(before)
    assert loaded.actions == before.actions
    changed = dataclasses.replace(before, masses=before.masses * 2)
    assert rollout_to_bytes(changed) != rollout_to_bytes(before) == rollout_to_bytes(loaded)
    edited = apply(busy(), [SetField(path="event.actions.push.duration", value=70)])
    assert digest(Simulator().resimulate(edited, {}, loaded, 100)) == digest(simulate(edited))


def test_a_run_whose_snapshots_are_of_another_version_is_not_gone_on_from():
    before = simulate(busy())
    assert before.snapshots is not None
    old = dataclasses.replace(before, snapshots=before.snapshots[:, :-1])
    edited = apply(busy(), [SetField(path="event.actions.push.duration", value=70)])
    assert digest(Simulator().resimulate(edited, {}, old, 100)) == digest(simulate(edited))


@pytest.mark.parametrize("of", ["engine", "law"])
def test_a_run_of_another_engine_or_law_is_not_gone_on_from(of, monkeypatch):
    with monkeypatch.context() as patch:
        if of == "law":
            patch.setattr(resume, "LAW", 1)
        else:
            patch.setattr(resume.mj, "mj_versionString", lambda: "3.0.0")
        before = simulate(busy())
    other = dataclasses.replace(before, positions=before.positions + 1)
    edited = apply(busy(), [SetField(path="event.actions.push.duration", value=70)])
    assert digest(Simulator().resimulate(edited, {}, other, 100)) == digest(simulate(edited))


def test_a_rollout_that_was_tampered_with_is_refused():
    data = rollout_to_bytes(simulate(busy()))
    with np.load(io.BytesIO(data)) as archive:
        arrays = {name: archive[name] for name in archive.files}
    arrays["positions"][5, 0, 0] += 0.1
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    with pytest.raises(InputError, match="hash"):
        rollout_from_bytes(stream.getvalue())
    meta = json.loads(arrays["meta"].tobytes())
    assert len(meta.pop("sha256")) == 64
    # The first rollouts had no hash, and later ones no field that came after them.
    for name in ("releases", "memories", "actions", "setting"):
        meta.pop(name)
    for one, told in ((meta, ""), (meta | {"format": 2}, "format 2"), ({"format": 1}, "lacks")):
        arrays["meta"] = np.frombuffer(json.dumps(one).encode(), np.uint8)
        np.savez_compressed(stream := io.BytesIO(), **arrays)
        if not told:
            assert rollout_from_bytes(stream.getvalue()).objects == simulate(busy()).objects
            continue
        with pytest.raises(InputError, match=told):
            rollout_from_bytes(stream.getvalue())


@pytest.mark.parametrize("shape", [Sphere(radius=0.1), Box(size=(0.2, 0.2, 0.2))])
def test_impulses_of_contacts_change_the_momentum(shape):
    item = thing("it", shape, (0, 0, 0.4), rotation=about_axis((1, 2, 0), 0.3), restitution=0.6)
    rollout = simulate(program([item], [ground(restitution=0.6)], seconds=1.6))
    impulse = np.zeros(rollout.steps)
    np.add.at(impulse, rollout.contacts["step"], rollout.contacts["impulse"])
    gained = np.diff(rollout.velocities[:, 0, 2]) + 9.81 * 0.01
    # The step on which the body first touches also gives back half an engine step of fall.
    slack = 0.02 * np.abs(gained) + 0.03
    assert (np.abs(impulse / rollout.masses[0] - gained) < slack).all()
    assert impulse.max() > 2 * rollout.masses[0]


def test_contacts_name_the_pair_with_the_normal_from_a_to_b():
    box = thing("box", Box(size=(0.2, 0.2, 0.2)), (0, 0, 0.1))
    top = thing("top", Sphere(radius=0.1), (0.02, 0, 0.3))
    rollout = simulate(program([top, box], [ground()], seconds=0.2))
    assert rollout.bodies == ("top", "box", "floor")
    first = rollout.contacts[rollout.contacts["step"] == 2]
    assert [(a, b) for a, b in first[["a", "b"]].tolist()] == [(0, 1), (1, 2)]
    assert first["normal"] == pytest.approx(np.array([[0, 0, -1.0], [0, 0, -1.0]]), abs=1e-6)
    assert first["point"][0] == pytest.approx([0.02, 0, 0.2], abs=1e-3)
    weights = 9.81 * 0.01 * np.array([rollout.masses[0], rollout.masses.sum()])
    assert first["impulse"] == pytest.approx(weights, rel=0.05)


def test_energy_is_lost_but_never_made():
    rollout = simulate(
        program(
            [thing("ball", Sphere(radius=0.1), (0, 0, 2), restitution=0.8)],
            [ground(restitution=0.8)],
        )
    )
    energy = (rollout.kinetic + rollout.potential).sum(1)
    floor = rollout.masses[0] * 9.81 * 0.1
    assert np.diff(energy).max() < 0.002 * (energy[0] - floor)
    assert energy[-1] < energy[0]


@pytest.mark.parametrize("depth", [0.0005, 0.004, 0.015])
@pytest.mark.parametrize("shape", [Sphere(radius=0.1), Box(size=(0.2, 0.2, 0.2))])
def test_a_small_overlap_at_the_start_throws_nothing(shape, depth):
    item = thing("it", shape, (0, 0, 0.1 - depth), restitution=0.7)
    rollout = simulate(program([item], [ground(restitution=0.7)], seconds=1.0))
    assert np.abs(rollout.positions - rollout.positions[0]).max() < 2e-5
    assert rollout.penetration.max() < 1e-4
    named = [alarm for alarm in rollout.warnings if alarm.kind == "penetration"]
    assert len(named) == (1 if depth > 0.001 else 0)


def test_a_deep_overlap_comes_apart_slowly():
    item = thing("it", Box(size=(0.2, 0.2, 0.2)), (0, 0, 0.03))
    rollout = simulate(program([item], [ground()], seconds=2.0))
    assert rollout.velocities[..., 2].max() < 0.15
    assert rollout.positions[-1, 0, 2] > 0.08
    assert "come apart slowly" in rollout.warnings[0].text


def test_supports_carry_and_stop():
    shelf = ground("shelf", Slab(position=(0, 0, 0.5), size=(1, 1, 0.05)))
    wall = ground("wall", Wall(point=(1.0, 0, 0), yaw=np.pi))
    box = thing("box", Box(size=(0.1, 0.1, 0.1)), (0, 0, 0.6))
    ball = thing("ball", Sphere(radius=0.1), (0.3, 2, 0.1))
    roll = SetVelocity(id="roll", name="ball", velocity=(3, 0, 0))
    floor = ground("floor", Floor())
    rollout = simulate(program([box, ball], [floor, shelf, wall], [roll], seconds=1.2))
    assert rollout.positions[-1, 0, 2] == pytest.approx(0.575, abs=1e-3)
    assert rollout.positions[:, 1, 0].max() == pytest.approx(0.9, abs=0.02)
    pair = (rollout.index("ball"), rollout.index("wall"))
    assert pair in [(a, b) for a, b in rollout.contacts[["a", "b"]].tolist()]


def test_a_blow_up_is_named_with_its_step_object_and_cause():
    ball = thing("ball", Sphere(radius=0.01), (0, 0, 1), density=1.0)
    push = ApplyForce(id="push", name="ball", force=(1e7, 0, 0), start_step=20, duration=5)
    rollout = simulate(program([ball], [ground()], [push], gravity=STILL, seconds=0.8))
    alarm = rollout.blown_up
    assert alarm is not None
    assert 20 <= alarm.step <= 24
    assert "ball" in alarm.text
    assert "push" in alarm.text
    assert rollout.steps < 30
    for name in ARRAYS:
        if name != "contacts":
            assert np.isfinite(getattr(rollout, name)).all()


def test_cancelling():
    with pytest.raises(Cancelled):
        Simulator().simulate(busy(), cancelled=lambda: True)


def test_an_open_scene_is_refused_by_name():
    scene = busy().scene
    ball = scene.objects[0].model_copy(update={"position": None})
    unresolved = busy().model_copy(
        update={"scene": scene.model_copy(update={"objects": (ball, *scene.objects[1:])})}
    )
    with pytest.raises(SimulationError, match=r"scene\.objects\.ball\.position"):
        simulate(unresolved)


def test_finer_engine_steps_do_not_move_the_schedule():
    coarse = busy()
    fine = coarse.model_copy(update={"clip": Clip(substeps=20)})
    one, two = simulate(coarse), simulate(fine)
    assert [s.start for s in one.spans[:3]] == [s.start for s in two.spans[:3]]
    assert np.abs(one.positions[:30] - two.positions[:30]).max() < 1e-4


def test_an_empty_scene_runs():
    rollout = simulate(program([], [ground()], seconds=0.2))
    assert rollout.positions.shape == (rollout.steps + 1, 0, 3)
    assert len(rollout.contacts) == 0


def test_a_rollout_tells_what_carries_what_and_since_when_it_rests():
    low = thing("low", Box(size=(0.2, 0.2, 0.2)), (0, 0, 0.1))
    top = thing("top", Box(size=(0.2, 0.2, 0.1)), (0, 0, 0.4))
    roller = thing("roller", Sphere(radius=0.1), (1, 0, 0.1))
    roll = SetVelocity(id="roll", name="roller", velocity=(1, 0, 0), start_step=20)
    rollout = simulate(program([low, top, roller], [ground()], [roll], seconds=1.2))
    carriers = rollout.carriers()
    assert (np.diff(carriers[:, 0]) >= 0).all()
    last = carriers[carriers[:, 0] == rollout.steps - 1, 1:].tolist()
    assert sorted(last) == [[0, 3], [1, 0], [2, 3]]
    falls = np.sqrt(2 * 0.15 / 9.81)
    first = carriers[carriers[:, 1] == 1, 0].min()
    assert first == pytest.approx(100 * falls, abs=1.5)
