"""Raw engine states → the rollout's arrays, energies and alarms."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_studio import __version__
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import matrices_of
from physagent_studio.records import ActionSpan, Alarm, Rollout
from physagent_studio.simulation.clouds import quaternions_of
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.parts import CloudPart, Part, RigidPart
from physagent_studio.simulation.skin import skinned
from physagent_studio.simulation.surfaces import FloatArray
from physagent_studio.simulation.trace import Trace
from physagent_studio.simulation.world import World

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
    tracks = [_track(part, trace.positions[:rows], trace.velocities[:rows]) for part in world.parts]
    contacts = trace.log.contacts((rows - 1) * trace.substeps - 1)
    contacts = contacts[contacts["step"] < max(rows - 1, 0)]
    velocities = _column(tracks, rows, "velocity") + _held_back(
        world, _known(trace, contacts), rows
    )
    kinetic, potential = _energies(world, tracks, velocities)
    penetration = np.zeros(rows)
    np.maximum.at(penetration, contacts["step"] + 1, contacts["depth"])
    return Rollout(
        program_hash=program.hash,
        objects=tuple(item.name for item in scene.objects),
        bodies=tuple(item.name for item in (*scene.objects, *scene.supports)),
        step_seconds=program.clip.step_seconds,
        steps_per_frame=program.clip.steps_per_frame,
        frames=program.clip.frames,
        positions=_column(tracks, rows, "position"),
        rotations=_column(tracks, rows, "rotation"),
        velocities=velocities,
        angular=_column(tracks, rows, "angular"),
        contacts=contacts,
        kinetic=kinetic,
        potential=potential,
        masses=np.array([part.mass for part in world.parts]),
        penetration=penetration,
        spans=_spans(trace),
        warnings=tuple(trace.alarms),
        releases=tuple(trace.releases),
        versions=versions(),
        snapshots=trace.snapshots[: len(trace.memories)].copy(),
        memories=tuple(trace.memories),
        actions=action_keys(program),
        setting=setting,
    )


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class _Track:
    """One object's rows. offset: of the centre of mass from the origin, world, (T, 3).

    inner: kinetic energy beyond that of the centre, J, (T,). rotation: (T, 4).
    """

    position: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular: FloatArray
    offset: FloatArray
    inner: FloatArray


def _track(part: Part, qpos: FloatArray, qvel: FloatArray) -> _Track:
    if isinstance(part, RigidPart):
        return _rigid_track(part, qpos, qvel)
    assert isinstance(part, CloudPart)
    cloud = part.cloud
    places, speeds = cloud.places(qpos), cloud.speeds(qvel)
    position, turn = cloud.pose(places)
    velocity, angular = cloud.motion(places, speeds)
    relative = np.square(speeds - velocity[:, None]).sum(-1)
    inner = 0.5 * part.mass * relative @ cloud.shares
    rotation = quaternions_of(turn)
    return _Track(position, rotation, velocity, angular, np.zeros_like(position), inner)


def _rigid_track(part: RigidPart, qpos: FloatArray, qvel: FloatArray) -> _Track:
    handle, model = part.handle, part.model
    at, to = handle.position, handle.velocity
    rotation = qpos[:, at + 3 : at + 7].copy()
    matrices = matrices_of(rotation)
    turning = qvel[:, to + 3 : to + 6]
    principal = turning @ matrices_of(model.body_iquat[handle.body])
    return _Track(
        qpos[:, at : at + 3].copy(),
        rotation,
        qvel[:, to : to + 3].copy(),
        np.einsum("tij,tj->ti", matrices, turning),
        np.einsum("tij,j->ti", matrices, model.body_ipos[handle.body]),
        0.5 * np.square(principal) @ model.body_inertia[handle.body],
    )


def _column(tracks: list[_Track], rows: int, name: str) -> FloatArray:
    """(T, N, 3 or 4): one field of all objects."""
    if not tracks:
        return np.zeros((rows, 0, 4 if name == "rotation" else 3))
    return np.stack([getattr(track, name) for track in tracks], axis=1)


def action_keys(program: PhysicalProgram) -> tuple[tuple[str, str], ...]:
    """(id, canonical JSON) of the actions that act, in order."""
    return tuple((a.id, a.model_dump_json()) for a in program.event.actions if not a.muted)


def versions() -> tuple[tuple[str, str], ...]:
    """What made the rollout."""
    return (("mujoco", mj.mj_versionString()), ("physagent-studio", __version__))


def _known(trace: Trace, contacts: np.ndarray) -> np.ndarray:
    """The contacts since the start of the clip."""
    if trace.head is None:
        return contacts
    before = trace.head.contacts
    return np.concatenate([before[before["step"] < trace.first], contacts])


def _held_back(world: World, contacts: np.ndarray, rows: int) -> FloatArray:
    """(T, N, 3) m/s: what `World.half_kick` took off, for as long as the body flies freely."""
    missing = np.zeros((rows, len(world.names), 3))
    for step, index, kick in world.kicks:
        mine = (contacts["a"] == index) | (contacts["b"] == index)
        later = contacts["step"][mine & (contacts["step"] >= step)]
        until = int(later.min()) + 1 if len(later) else rows
        missing[step + 1 : until, index] = kick
        missing[max(until, step + 1) :, index] = 0
    return missing


def _energies(
    world: World, tracks: list[_Track], velocities: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Kinetic and potential energy (T, N), J."""
    kinetic, potential = np.zeros(velocities.shape[:2]), np.zeros(velocities.shape[:2])
    gravity = np.array(world.program.scene.gravity)
    for index, (track, part) in enumerate(zip(tracks, world.parts, strict=True)):
        moving = velocities[:, index] + np.cross(track.angular, track.offset)
        kinetic[:, index] = 0.5 * part.mass * np.square(moving).sum(1) + track.inner
        potential[:, index] = -part.mass * (track.position + track.offset) @ gravity
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
    solids = world.compiled.solids
    alarms: list[Alarm] = []
    pairs, index = np.unique(contacts[["a", "b"]], return_inverse=True)
    for number, (a, b) in enumerate(pairs.tolist()):
        rows = contacts[index == number]
        deepest = rows[int(np.argmax(rows["depth"]))]
        smallest = min(float(solids[i].extent.min()) for i in (a, b) if i < len(solids))
        loose = any(i < len(solids) and not _is_firm(program, i) for i in (a, b))
        if deepest["depth"] > DEEP * smallest and not loose:
            text = (
                f"{things[a].name} sinks {1000 * float(deepest['depth']):.1f} mm "
                f"into {things[b].name}"
            )
            alarms.append(Alarm(int(deepest["step"]), "penetration", text))
    return dataclasses.replace(rollout, warnings=(*rollout.warnings, *alarms))


def _is_firm(program: PhysicalProgram, index: int) -> bool:
    return program.scene.objects[index].body.kind in ("rigid", "breakable")


def _join(previous: Rollout, tail: Rollout, contacts: np.ndarray, step: int) -> Rollout:
    """`previous` up to and with row `step`, then `tail`, whose rows before are not valid."""
    arrays = {
        name: np.concatenate([getattr(previous, name)[: step + 1], getattr(tail, name)[step + 1 :]])
        for name in _ROWS
    }
    return dataclasses.replace(tail, contacts=contacts, **arrays)


_ROWS = (
    "positions",
    "rotations",
    "velocities",
    "angular",
    "kinetic",
    "potential",
    "penetration",
)
