"""What a run writes down while it goes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Alarm, Rollout
from physagent_studio.records.rollout import Release
from physagent_studio.simulation.fracture import Fracture
from physagent_studio.simulation.grip import Grip
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.model import Compiled
from physagent_studio.simulation.schedule import Schedule
from physagent_studio.simulation.surfaces import FloatArray
from physagent_studio.simulation.touches import ContactLog

SNAPSHOT = mj.mjtState.mjSTATE_INTEGRATION.value


@dataclass(eq=False, slots=True)
class Trace:
    """What the loop writes: raw states per control step and snapshots per frame.

    positions: (S+1, nq). velocities: (S+1, nv). snapshots: (frames, engine state and grip).
    memories: per frame; memory: the last one and what it depended on. rows: how many rows are
    valid. count: contacts of the last engine step. first_touch: control step by pair. came_true:
    control step by id of the waiting action. releases: joints that let go. head: the earlier run
    that stands for the rows up to `first`, which are not filled here.
    """

    positions: FloatArray
    velocities: FloatArray
    snapshots: FloatArray
    log: ContactLog
    schedule: Schedule
    grip: Grip
    fracture: Fracture
    substeps: int
    rows: int = 0
    count: int = 0
    memories: list[str] = field(default_factory=list)
    memory: tuple[tuple[int, int, int, bool] | None, str] = (None, "")
    alarms: list[Alarm] = field(default_factory=list)
    releases: list[Release] = field(default_factory=list)
    first_touch: dict[tuple[int, int], int] = field(default_factory=dict)
    came_true: dict[str, int] = field(default_factory=dict)
    head: Rollout | None = None
    first: int = 0


def new_trace(program: PhysicalProgram, compiled: Compiled, substeps: int) -> Trace:
    """An empty trace of a whole clip."""
    model, clip = compiled.model, program.clip
    dt = clip.step_seconds / substeps
    return Trace(
        np.zeros((clip.steps + 1, model.nq)),
        np.zeros((clip.steps + 1, model.nv)),
        np.empty((clip.frames, mj.mj_stateSize(model, SNAPSHOT) + model.npair)),
        ContactLog(compiled, substeps, dt),
        Schedule(program.event.actions, clip.steps),
        Grip(compiled, dt),
        Fracture(program, compiled),
        substeps,
    )
