"""Raw engine states → the rollout's arrays, energies, alarms and impulses of contacts.

Readings tell what a contact does at single engine steps; a body that rolls over its edges is hit
and let go many times in between. But the momentum that an object gains over a control step, less
that of its weight, is exactly what its contacts gave it. Where it touches one thing alone, that
is the impulse of this contact.
"""

import dataclasses
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physagent_studio import __version__
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import cross, rotated
from physagent_studio.records import ActionSpan, Alarm, Rollout
from physagent_studio.records.rollout_io import ARRAYS
from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.bodies.clouds import quaternions_of
from physagent_studio.simulation.bodies.flexes import skinned
from physagent_studio.simulation.contacts.touches import Touching
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.model.parts import CloudPart, RigidPart
from physagent_studio.simulation.stepping.trace import Trace
from physagent_studio.simulation.surfaces import FloatArray

DEEP = 0.1
"""Share of an object's smallest extent from which a penetration is worth an alarm."""


def rollout_of(world: World, trace: Trace, setting: str) -> Rollout:
    """The rollout of a run, finished or so far; setting: see `resume.setting_key`."""
    own = _own(world, trace, setting)
    if trace.head is None:
        return own
    return _join(trace.head, own, _known(trace, own.contacts), trace.first)


def _own(world: World, trace: Trace, setting: str) -> Rollout:
    """The rollout as far as this run has filled it."""
    program = world.program
    scene, rows = program.scene, trace.rows
    track = _track(world, trace.positions[:rows], trace.velocities[:rows])
    engine = track.velocity
    if track.lopsided:
        engine = engine + cross(track.angular, track.offset)
    touching = trace.log.contacts((rows - 1) * trace.substeps - 1)
    contacts = balanced(world, trace, touching, engine).table(max(rows - 1, 0))
    missing = _held_back(world, _known(trace, contacts), rows)
    kinetic, potential = _energies(world, track, engine + missing)
    penetration = np.zeros(rows)
    np.maximum.at(penetration, contacts["step"] + 1, contacts["depth"])
    return Rollout(
        program_hash=program.hash,
        objects=tuple(item.name for item in scene.objects),
        bodies=tuple(item.name for item in (*scene.objects, *scene.supports)),
        step_seconds=program.clip.step_seconds,
        steps_per_frame=program.clip.steps_per_frame,
        frames=program.clip.frames,
        positions=track.position,
        rotations=track.rotation,
        velocities=track.velocity + missing,
        angular=track.angular,
        contacts=contacts,
        kinetic=kinetic,
        potential=potential,
        masses=np.array([part.mass for part in world.parts]),
        penetration=penetration,
        spans=_spans(trace),
        warnings=tuple(trace.alarms),
        releases=tuple(trace.releases),
        versions=(("mujoco", mj.mj_versionString()), ("physagent-studio", __version__)),
        snapshots=trace.snapshots_so_far(),
        memories=tuple(trace.memories),
        actions=action_keys(program),
        setting=setting,
    )


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class _Track:
    """The rows of N objects. offset: of the centres of mass from the origins, world, (T, N, 3).

    inner: kinetic energy beyond that of the centre, J, (T, N). rotation: (T, N, 4). lopsided:
    whether some offset is not zero.
    """

    position: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular: FloatArray
    offset: FloatArray
    inner: FloatArray
    lopsided: bool = False


def _track(world: World, qpos: FloatArray, qvel: FloatArray) -> _Track:
    parts, rows = world.parts, len(qpos)
    rigid = [index for index, part in enumerate(parts) if isinstance(part, RigidPart)]
    whole = _rigid_tracks([part for part in parts if isinstance(part, RigidPart)], qpos, qvel)
    if len(rigid) == len(parts):
        return whole
    shape = (rows, len(parts))
    track = _Track(
        np.empty((*shape, 3)),
        np.empty((*shape, 4)),
        np.empty((*shape, 3)),
        np.empty((*shape, 3)),
        np.zeros((*shape, 3)),
        np.empty(shape),
        whole.lopsided,
    )
    clouds = {
        i: _cloud_track(p, qpos, qvel) for i, p in enumerate(parts) if isinstance(p, CloudPart)
    }
    for name in ("position", "rotation", "velocity", "angular", "offset", "inner"):
        column = getattr(track, name)
        column[:, rigid] = getattr(whole, name)
        for index, own in clouds.items():
            column[:, index] = getattr(own, name)
    return track


def _cloud_track(part: CloudPart, qpos: FloatArray, qvel: FloatArray) -> _Track:
    """The rows of one object of many nodes, without the axis of objects."""
    cloud = part.cloud
    places, speeds = cloud.places(qpos), cloud.speeds(qvel)
    position, turn = cloud.pose(places)
    velocity, angular = cloud.motion(places, speeds)
    relative = np.square(speeds - velocity[:, None]).sum(-1)
    inner = 0.5 * part.mass * relative @ cloud.shares
    rotation = quaternions_of(turn)
    return _Track(position, rotation, velocity, angular, np.zeros_like(position), inner)


def _rigid_tracks(parts: list[RigidPart], qpos: FloatArray, qvel: FloatArray) -> _Track:
    if not parts:
        empty = np.zeros((len(qpos), 0, 3))
        return _Track(empty, np.zeros((len(qpos), 0, 4)), empty, empty, empty, empty[..., 0])
    model = parts[0].model
    at = np.array([part.handle.position for part in parts])[:, None]
    to = np.array([part.handle.velocity for part in parts])[:, None]
    bodies = [part.handle.body for part in parts]
    rotation = qpos[:, at + np.arange(3, 7)]
    turning = qvel[:, to + np.arange(3, 6)]
    # One product per body: beats the general sum over both axes by far.
    principal = np.matmul(turning.swapaxes(0, 1), _principal_frames(parts))
    centres = model.body_ipos[bodies]
    lopsided = bool(centres.any())
    return _Track(
        qpos[:, at + np.arange(3)],
        rotation,
        qvel[:, to + np.arange(3)],
        rotated(rotation, turning),
        rotated(rotation, centres) if lopsided else np.zeros((*rotation.shape[:2], 3)),
        0.5 * np.einsum("nti,ni->tn", np.square(principal), model.body_inertia[bodies]),
        lopsided,
    )


def _principal_frames(parts: list[RigidPart]) -> FloatArray:
    """(N, 3, 3) columns: principal axes of inertia in the body frame."""
    frames = np.empty((len(parts), 9))
    for row, part in zip(frames, parts, strict=True):
        mj.mju_quat2Mat(row, part.model.body_iquat[part.handle.body])
    return frames.reshape(-1, 3, 3)


def action_keys(program: PhysicalProgram) -> tuple[tuple[str, str], ...]:
    """(id, canonical JSON) of the actions that act, in order."""
    return tuple((a.id, a.model_dump_json()) for a in program.event.actions if not a.muted)


def _known(trace: Trace, contacts: np.ndarray) -> np.ndarray:
    """The contacts since the start of the clip."""
    if trace.head is None:
        return contacts
    before = trace.head.contacts
    return np.concatenate([before[before["step"] < trace.first], contacts])


def _held_back(world: World, contacts: np.ndarray, rows: int) -> FloatArray:
    """(T, N, 3) m/s: what `World.half_kick` took off, for as long as the body flies freely."""
    missing = np.zeros((rows, len(world.names), 3))
    steps, one, other = contacts["step"], contacts["a"], contacts["b"]
    for step, index, kick in world.kicks:
        touched = np.flatnonzero(((one == index) | (other == index)) & (steps >= step))
        until = int(steps[touched[0]]) + 1 if len(touched) else rows
        missing[step + 1 : until, index] = kick
        missing[max(until, step + 1) :, index] = 0
    return missing


def _energies(world: World, track: _Track, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Kinetic and potential energy (T, N), J. velocities: of the centres of mass."""
    masses = np.array([part.mass for part in world.parts])
    gravity = np.array(world.program.scene.gravity)
    kinetic = 0.5 * masses * np.einsum("tni,tni->tn", velocities, velocities) + track.inner
    potential = -masses * world.falls * ((track.position + track.offset) @ gravity)
    return kinetic, potential


def _spans(trace: Trace) -> tuple[ActionSpan, ...]:
    last = trace.rows - 1
    found = []
    for slot in trace.schedule.slots:
        ran = slot.began and slot.start is not None and slot.end is not None
        start = slot.start if ran else None
        end = min(slot.end, last) if ran and slot.end is not None else None
        found.append(ActionSpan(slot.action.id, start, end, slot.effect.work))
    return tuple(found)


def with_vertices(world: World, trace: Trace, rollout: Rollout) -> Rollout:
    """Adds the deformed vertices of everything that is not rigid, per frame."""
    if not any(isinstance(part, CloudPart) for part in world.parts):
        return rollout
    before = dict(trace.head.vertices) if trace.head is not None else {}
    frames = np.unique(rollout.frame_steps())
    first = trace.first // rollout.steps_per_frame if trace.head is not None else 0
    found = []
    for item, part in zip(world.program.scene.objects, world.parts, strict=True):
        if not isinstance(part, CloudPart):
            continue
        points = world.skins[item.name]
        vertices = skinned(part.cloud, points, trace.positions[frames[first:]], item.body.kind)
        if item.name in before:
            vertices = np.concatenate([before[item.name][:first], vertices])
        found.append((item.name, vertices))
    return dataclasses.replace(rollout, vertices=tuple(found))


def with_alarms(world: World, rollout: Rollout) -> Rollout:
    """Adds one alarm per pair whose deepest overlap is a fair share of the smaller body."""
    program, contacts = world.program, rollout.contacts
    things = (*program.scene.objects, *program.scene.supports)
    extents = np.full(len(things), np.inf)
    for index, (item, solid) in enumerate(
        zip(program.scene.objects, world.compiled.solids, strict=True)
    ):
        extents[index] = solid.extent.min()
        if item.body.kind not in ("rigid", "breakable"):
            extents[index] = np.nan
    limit = DEEP * np.minimum(extents[contacts["a"]], extents[contacts["b"]])
    deep = contacts[contacts["depth"] > limit + _strides(world, rollout)]
    alarms: list[Alarm] = []
    for a, b in sorted({(row["a"].item(), row["b"].item()) for row in deep}):
        rows = deep[(deep["a"] == a) & (deep["b"] == b)]
        deepest = rows[int(np.argmax(rows["depth"]))]
        text = (
            f"{things[a].name} sinks {1000 * float(deepest['depth']):.1f} mm into {things[b].name}"
        )
        alarms.append(Alarm(int(deepest["step"]), "penetration", text))
    if not alarms:
        return rollout
    return dataclasses.replace(rollout, warnings=(*rollout.warnings, *alarms))


def _strides(world: World, rollout: Rollout) -> FloatArray:
    """(C,) m that the two bodies of each contact move towards each other in an engine step.

    So deep a blow starts, however thin they are.
    """
    rows, count = rollout.contacts, len(rollout.objects)
    speeds = np.zeros((len(rollout.positions), len(rollout.bodies)))
    speeds[:, :count] = np.linalg.norm(rollout.velocities, axis=2)
    return world.dt * (speeds[rows["step"], rows["a"]] + speeds[rows["step"], rows["b"]])


def _join(previous: Rollout, tail: Rollout, contacts: np.ndarray, step: int) -> Rollout:
    """`previous` up to and with row `step`, then `tail`, whose rows before are not valid."""
    arrays = {
        name: np.concatenate([getattr(previous, name)[: step + 1], getattr(tail, name)[step + 1 :]])
        for name in ARRAYS
        if name != "masses"
    }
    return dataclasses.replace(tail, contacts=contacts, **arrays)


LEAST = 0.01
"""Impulses below this share of the weight's are no contact, if the reading saw none."""


def balanced(world: World, trace: Trace, touching: Touching, velocities: FloatArray) -> Touching:
    """The contacts with impulses from momenta where they follow from them.

    Rows of things that are close and have an impulse act, whatever the readings say. velocities:
    (T, N, 3) m/s, of the centres of mass, as the engine has them.
    """
    if world.compiled.reach is None or not len(touching.step):
        return touching
    one, sign = _alone(trace, touching, velocities.shape[1])
    known = np.flatnonzero(sign)
    step, one, sign = touching.step[known], one[known], sign[known]
    masses = np.array([part.mass for part in world.parts])
    fall = np.array(world.program.scene.gravity) * world.step_seconds
    gained = velocities[step + 1, one] - velocities[step, one] - fall * world.falls[one, None]
    speed = sign * np.einsum("ij,ij->i", gained, touching.normal[known])
    impulse, acts = touching.impulse.copy(), touching.acts.copy()
    impulse[known] = masses[one] * np.maximum(speed, 0)
    acts[known] |= speed > LEAST * float(np.linalg.norm(fall)) + 1e-9
    return replace(touching, impulse=impulse, acts=acts)


def _alone(trace: Trace, touching: Touching, count: int) -> tuple[NDArray[np.int64], FloatArray]:
    """For each row an object that touches nothing else on that step, and the sign of the normal
    that points at it; sign 0 where there is none.
    """
    rows, width = trace.rows - 1, count + 1
    # After a blow-up there are readings beyond the rows that are kept.
    quiet = np.zeros(max(rows, int(touching.step[-1]) + 1), bool)
    steps = np.array(trace.log.undisturbed, np.int64)
    quiet[steps[steps < rows]] = True
    step, a, b = touching.step, touching.a, touching.b
    # All supports count as one, which is never alone.
    at_a, at_b = step * width + a, step * width + np.minimum(b, count)
    partners = np.bincount(np.concatenate([at_a, at_b]))
    only_a, only_b = partners[at_a] == 1, (partners[at_b] == 1) & (b < count)
    sign = np.where(only_a, -1.0, np.where(only_b, 1.0, 0.0))
    return np.where(only_a, a, b), sign * quiet[step]
