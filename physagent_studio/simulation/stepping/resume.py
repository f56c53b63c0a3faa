"""Runs again from a snapshot: what an edit cannot have changed is taken over bit by bit."""

import hashlib
import json
from typing import Any

import numpy as np

from physagent_studio.program import Action, After, OnContact, PhysicalProgram
from physagent_studio.records import Rollout
from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.stepping.measure import action_keys
from physagent_studio.simulation.stepping.trace import EXTRA, SNAPSHOT, Trace

LAW = 4
"""Counts up whenever the same program gives other bits, so that no older run is gone on from."""


def setting_key(program: PhysicalProgram, structure: str, substeps: int) -> str:
    """Hash of everything in a run but its actions, the engine's version and our law's included."""
    unseen = dict.fromkeys(("camera", "horizon", "flags"), True)
    scene = program.scene.model_dump_json(exclude={**unseen, **program.scene.without})
    clip = program.clip.model_dump_json(exclude={"playback_fps"})
    parts = (structure, scene, clip, str(substeps), mj.mj_versionString(), str(LAW))
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def first_effect(program: PhysicalProgram, previous: Rollout) -> int:
    """The first control step on which `program` can differ from the run before."""
    old, new = dict(previous.actions), dict(action_keys(program))
    common = [name for name, text in previous.actions if new.get(name) == text]
    if common != [name for name, text in action_keys(program) if old.get(name) == text]:
        return 0
    changed = {name for name in {*old, *new} if old.get(name) != new.get(name)}
    starts = [s.start for s in previous.spans if s.id in changed and s.start is not None]
    for action in program.event.actions:
        if action.id in changed and not action.muted:
            starts.append(_earliest(action, previous))
    return min(starts, default=previous.steps)


def _earliest(action: Action, previous: Rollout) -> int:
    """The earliest start of a new or changed action, judged by the run before."""
    when = action.when
    if when is None:
        return action.start_step
    if isinstance(when, After):
        ends = [s.end for s in previous.spans if s.id == when.action and s.end is not None]
        return min(ends, default=0)
    if not isinstance(when, OnContact):
        # A statement may have held from the start.
        return 0
    a, b = sorted((previous.index(when.a), previous.index(when.b)))
    contacts = previous.contacts
    steps = contacts["step"][(contacts["a"] == a) & (contacts["b"] == b)]
    return int(steps.min()) + 1 if len(steps) else previous.steps


def restore(world: World, trace: Trace, previous: Rollout, frame: int) -> int:
    """Puts the engine and the schedule where `previous` was at a frame; returns its step."""
    assert previous.snapshots is not None
    step = frame * previous.steps_per_frame
    size = trace.engine_size
    row = previous.snapshots[frame]
    mj.mj_setState(world.compiled.model, world.data, row[:size], SNAPSHOT)
    trace.count, trace.acting = int(row[size]), int(row[size + 1])
    trace.calm.restore(row[size + 2 : size + EXTRA])
    trace.grip.restore(row[size + EXTRA :])
    trace.fracture.follow(world.data)
    trace.releases.extend(item for item in previous.releases if item.step < step)
    trace.snapshots[: frame + 1] = previous.snapshots[: frame + 1]
    trace.memories.extend(previous.memories[:frame])
    memory: dict[str, Any] = json.loads(previous.memories[frame])
    trace.came_true.update(memory["true"])
    trace.head, trace.first = previous, step
    world.kicks.extend((s, i, np.array(kick)) for s, i, kick in memory["kicks"])
    contacts = previous.contacts[previous.contacts["step"] < step]
    for row_step, a, b in contacts[["step", "a", "b"]].tolist():
        trace.first_touch.setdefault((a, b), row_step)
    spans = {span.id: span for span in previous.spans}
    trace.schedule.recall(spans, memory["active"], step)
    trace.schedule.just_ended = memory["wrench"]
    if world.wheels is not None:
        world.wheels.recall(memory["wheels"])
    for slot in trace.schedule.active:
        slot.effect.resume(world)
    return step
