"""The stepping loop: control steps cut into engine steps, and whether a run is still physics."""

import json
import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from physagent_studio.contract import met
from physagent_studio.errors import Cancelled
from physagent_studio.records import Alarm
from physagent_studio.simulation.actions.schedule import Slot
from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.contacts.friction import GripState
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.stepping.measure import rollout_of
from physagent_studio.simulation.stepping.trace import SNAPSHOT, Trace

Reached: TypeAlias = Callable[[int], bool]
"""What is done at the beginning of a control step; False where the run ends there."""


def run(
    world: World,
    trace: Trace,
    first: int,
    cancelled: Callable[[], bool] | None,
) -> None:
    """Runs the control steps from `first` to the end of the clip, or to a blow-up."""
    steps, step = world.program.clip.steps, first
    reached = partial(_reached, world, trace, cancelled)
    while reached(step):
        if step == steps:
            # Actions that reach the end of the clip are settled.
            for slot in trace.schedule.active:
                slot.effect.end(world)
            return
        _edges(world, trace, step)
        step = _advance(world, trace, step, reached)


def _reached(world: World, trace: Trace, cancelled: Callable[[], bool] | None, step: int) -> bool:
    """Writes the state down, at a frame with all that it takes to go on from it."""
    if trace.over:
        return False
    # Of grains a frame takes a second.
    if cancelled is not None and cancelled():
        raise Cancelled("the simulation was cancelled")
    clip, data = world.program.clip, world.data
    trace.positions[step], trace.velocities[step] = data.qpos, data.qvel
    trace.rows = step + 1
    if step % clip.steps_per_frame == 0:
        if not is_sound(world, trace, step):
            return False
        _snapshot(world, trace, step // clip.steps_per_frame)
    return True


def _snapshot(world: World, trace: Trace, frame: int) -> None:
    mj.mj_getState(world.compiled.model, world.data, trace.states[frame], SNAPSHOT)
    extra = (trace.count, trace.acting, *trace.calm.state)
    trace.pending.append((frame, extra, trace.grip.state))
    trace.memories[frame:] = [_memory(world, trace)]


def _memory(world: World, trace: Trace) -> str:
    """What a snapshot needs beyond the engine's state, as JSON."""
    calm = (len(world.kicks), len(trace.came_true), trace.schedule.just_ended)
    still = not trace.schedule.active and world.wheels is None
    if still and trace.memory[0] == calm:
        return trace.memory[1]
    memory: dict[str, Any] = {
        "kicks": [[step, index, kick.tolist()] for step, index, kick in world.kicks],
        "active": {slot.action.id: slot.effect.memory() for slot in trace.schedule.active},
        "true": trace.came_true,
        "wrench": trace.schedule.just_ended,
    }
    if world.wheels is not None:
        memory["wheels"] = world.wheels.memory()
    text = _compact(memory)
    trace.memory = (calm if still else None, text)
    return text


_compact = json.JSONEncoder(separators=(",", ":")).encode


def _edges(world: World, trace: Trace, step: int) -> None:
    """Ends and begins the actions whose window opens or closes before `step`."""
    schedule, world.step = trace.schedule, step
    if step == 0:
        for item in world.program.scene.objects:
            world.half_kick(item.name)
        if world.wheels is not None:
            world.wheels.look()
        trace.grip.update(world.data.ncon)
        trace.fracture.follow(world.data)
    if schedule.is_conditional:
        if schedule.awaits_contact and step:
            _note_touches(trace, step)
        if schedule.awaited and step % world.program.clip.steps_per_frame == 0:
            _note_statements(world, trace, step)
        schedule.resolve(step, partial(_touched, world, trace), trace.came_true.get)
    if not schedule.has_edge(step):
        return
    ending, starting = schedule.turn(step)
    trace.calm.end(step)
    for slot in ending:
        slot.effect.end(world)
    for slot in starting:
        slot.effect.begin(world)


def _note_touches(trace: Trace, step: int) -> None:
    """Remembers which pairs touched first during the step before."""
    for pair in trace.log.touching((step - 1) * trace.substeps):
        trace.first_touch.setdefault(pair, step - 1)


def _note_statements(world: World, trace: Trace, step: int) -> None:
    """Remembers which awaited statements hold for the run so far, "at the end" meaning now."""
    rollout = rollout_of(world, trace, "")
    for action_id, when in trace.schedule.awaited:
        if met(when.statement, world.program, rollout):
            trace.came_true.setdefault(action_id, step)


def _touched(world: World, trace: Trace, a: str, b: str) -> int | None:
    one, other = sorted((world.bodies[a], world.bodies[b]))
    return trace.first_touch.get((one, other))


def _advance(world: World, trace: Trace, step: int, reached: Reached) -> int:
    """Goes on from a control step, as far as nothing of ours can act; returns the next one."""
    schedule, calm, wheels = trace.schedule, trace.calm, world.wheels
    busy = [slot for slot in schedule.active if slot.effect.acts] if schedule.active else []
    if busy or schedule.just_ended or wheels is not None:
        world.data.xfrc_applied[:] = 0
        schedule.just_ended = False
    fine = _work(world, busy, step) if busy else []
    if wheels is not None and not fine:
        wheels.act()
    if fine:
        _step_by_step(world, trace, step, _pushes(world, fine, step))
    elif step < calm.until:
        step = _stretch(world, trace, step, bool(busy), reached) - 1
    else:
        _meet(world, trace, step, not busy and step > 0 and not schedule.has_edge(step))
    if wheels is not None:
        wheels.look()
    first = step * trace.substeps
    if trace.fracture.watches:
        trace.releases += trace.fracture.release(world.data, trace.log.blows(first), step)
    if step + 1 >= calm.until:
        gain = sum(slot.effect.most_gain(world) for slot in busy) if busy else 0.0
        gain += wheels.most_gain if wheels is not None else 0.0
        if fine or math.isinf(gain):
            calm.end(step + 1)
        else:
            calm.look(step + 1, world.data, trace.grip, trace.log, first, gain)
    return step + 1


def _work(world: World, busy: list[Slot], step: int) -> list[Slot]:
    """What pushes for a control step pushes; returns the actions that act on engine steps."""
    for slot in busy:
        if not slot.effect.each_substep:
            slot.effect.act(world, (step - _start(slot)) * world.step_seconds)
    return [slot for slot in busy if slot.effect.each_substep]


def _pushes(world: World, fine: list[Slot], step: int) -> Callable[[int], None]:
    """What acts anew before each engine step of a control step."""
    data, seconds, wheels = world.data, world.step_seconds, world.wheels
    base = data.xfrc_applied.copy()

    def before(tick: int) -> None:
        data.xfrc_applied[:] = base
        for slot in fine:
            slot.effect.act(world, (step - _start(slot)) * seconds + tick * world.dt)
        if wheels is not None:
            # Against the pushes as they are when the control step begins.
            (wheels.again if tick else wheels.act)()

    return before


def _stretch(world: World, trace: Trace, step: int, busy: bool, reached: Reached) -> int:
    """Control steps as a whole, see `calm`, as many as can follow each other; returns the next.

    busy: whether an action is at work.
    """
    model, data, grip, log = world.compiled.model, world.data, trace.grip, trace.log
    go_on, substeps, per = mj.mj_step, trace.substeps, world.program.clip.steps_per_frame
    places, rates, positions, velocities = data.qpos, data.qvel, trace.positions, trace.velocities
    quiet = not busy and step > 0 and not trace.schedule.has_edge(step)
    alone = busy or world.wheels is not None
    stop, close = step + 1 if alone else _stop(trace, step), grip.now
    while True:
        go_on(model, data, substeps)
        first, count = step * substeps, data.ncon
        parted = grip.update(count)
        if quiet:
            log.undisturbed.append(step)
        step += 1
        if grip.now is not close:
            log.part(data, first, parted)
            trace.calm.end(step)
            stop = step
        log.read(data, count, first, quiet and grip.alone and not parted)
        if step < stop and step % per:
            positions[step], velocities[step] = places, rates
        else:
            trace.count, trace.acting = count, data.nefc
            if step >= stop or not reached(step):
                return step
        quiet = True


def _stop(trace: Trace, step: int) -> int:
    """The next control step before which something must be looked at."""
    if trace.schedule.is_conditional or trace.fracture.watches:
        return step + 1
    return min(trace.calm.until, trace.schedule.next_edge(step))


def _meet(world: World, trace: Trace, step: int, quiet: bool) -> None:
    """The engine steps of a control step in which bodies may meet, see `liveliness`.

    quiet: whether no action is at work.
    """
    lively, grip = trace.liveliness, trace.grip
    if quiet:
        trace.log.undisturbed.append(step)
    if not lively.watches:
        _step_by_step(world, trace, step)
        return
    lively.mark()
    known = trace.count, trace.acting, grip.state, trace.log.mark()
    _step_by_step(world, trace, step)

    def undo() -> None:
        trace.count, trace.acting, state, read = known
        trace.log.forget(read)
        grip.recall(state)

    hopping, share = lively.hopping()
    # What has been close before may part as it likes: it may do so at a stretch as well.
    if len(hopping) and _has_met(world, trace, known[2], step):
        undo()
        rough = lively.slippery(hopping, share)
        _step_by_step(world, trace, step)
        lively.rough(hopping, rough)
    # What pushes may add energy.
    if quiet and lively.has_gained():
        undo()
        kept, grip.firm = lively.take_back(), True
        _step_by_step(world, trace, step)
        grip.firm = False
        lively.give_back(kept)


def _has_met(world: World, trace: Trace, before: GripState, step: int) -> bool:
    """Whether two bodies touch in a control step that were not close before it."""
    close = world.compiled.pair_bodies[list(before[0])]
    known = {(min(two), max(two)) for two in close.tolist()}
    return not trace.log.touching(step * trace.substeps) <= known


def _step_by_step(
    world: World, trace: Trace, step: int, before: Callable[[int], None] | None = None
) -> None:
    """The engine steps of one control step; `before` runs before each. Reads as `touches` says."""
    model, data, grip = world.compiled.model, world.data, trace.grip
    go_on, read, first = mj.mj_step, trace.log.read, step * trace.substeps
    close, acting, fresh = trace.count, trace.acting, True
    for tick in range(first, first + trace.substeps):
        if before is not None:
            before(tick - first)
        go_on(model, data)
        count, rows = data.ncon, data.nefc
        if count != close or rows != acting:
            grip.gather(count)
        # While a close pair has not touched, any step may be its impact, and neither count nor
        # rows need tell: a foot that lifts in the same step takes away what the impact adds.
        grown = grip.awaits and (rows > acting or not grip.loose)
        if fresh or grown:
            read(data, count, tick)
            fresh = grown
        close, acting = count, rows
    grip.update(close)
    trace.count, trace.acting = close, acting


def _start(slot: Slot) -> int:
    assert slot.start is not None
    return slot.start


FASTEST = 5e3
"""m/s or rad/s above which a state is absurd and the run has blown up."""


def is_sound(world: World, trace: Trace, step: int) -> bool:
    """False, with an alarm, where the state is no longer physics; cuts the trace before it."""
    since = max(step - world.program.clip.steps_per_frame, 0)
    rates = trace.velocities[since : step + 1]
    # The sum of squares bounds every rate, and is NaN where one of them is.
    if np.vdot(rates, rates) < FASTEST**2:
        return True
    speeds = np.abs(rates)
    # NaN compares false, so an unsound row is one that is not provably slow.
    rows = (~(speeds < FASTEST)).any(axis=1)
    if not rows.any():
        return True
    row = since + int(np.argmax(rows))
    column = int(
        np.argmax(~(trace.velocities[row] < FASTEST) | ~(trace.velocities[row] > -FASTEST))
    )
    name = _object_at(world, column)
    trace.alarms.append(Alarm(row, "blow_up", _diagnosis(trace, row, name)))
    trace.rows, trace.over = max(row, 1), True
    return False


def _object_at(world: World, dof: int) -> str:
    names = [item.name for item in world.program.scene.objects]
    for name, handle in zip(names, world.compiled.handles, strict=True):
        starts = np.atleast_1d(handle.velocity)
        if ((starts <= dof) & (dof < starts + 6)).any():
            return name
    return names[0] if names else "the scene"


def _diagnosis(trace: Trace, row: int, name: str) -> str:
    """A sentence: when, what, and which action most likely did it."""
    recent = [
        slot
        for slot in trace.schedule.slots
        if slot.start is not None and slot.start < row and (slot.end or 0) >= row - 20
    ]
    own = [slot for slot in recent if slot.action.name == name]
    text = f"the simulation blew up at step {row}: the motion of {name} became absurd"
    if own or recent:
        slot = (own or recent)[-1]
        return f"{text}; likely cause: action {slot.action.id} ({slot.action.operator})"
    return f"{text}; no action was at work, so look at overlaps, sizes and densities"
