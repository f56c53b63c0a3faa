"""Whether a run is still physics, and a sentence on what went wrong where it is not."""

from __future__ import annotations

import numpy as np

from physagent_studio.records import Alarm
from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.stepping.trace import Trace

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
