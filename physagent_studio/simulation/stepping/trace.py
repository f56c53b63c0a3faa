"""What a run writes down while it goes."""

from dataclasses import dataclass, field

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.aloft import hangs
from physagent_studio.records import Alarm, Rollout
from physagent_studio.records.rollout import Release
from physagent_studio.simulation.actions.schedule import Schedule
from physagent_studio.simulation.contacts.fracture import Fracture
from physagent_studio.simulation.contacts.friction import Grip, GripState
from physagent_studio.simulation.contacts.restitution_guard import Liveliness
from physagent_studio.simulation.contacts.touches import ContactLog
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.model.model import Compiled
from physagent_studio.simulation.stepping.free_flight import Calm
from physagent_studio.simulation.surfaces import FloatArray

SNAPSHOT = mj.mjtState.mjSTATE_INTEGRATION.value

EXTRA = 5
"""Numbers in a snapshot between the engine's state and the grip: count, acting, state of calm."""


@dataclass(eq=False, slots=True)
class Trace:
    """What the loop writes: raw states per control step and snapshots per frame.

    positions: (S+1, nq). velocities: (S+1, nv). snapshots: (frames, engine state, extra, grip).
    engine_size: numbers in the engine's state; states: the part of each snapshot that holds it.
    pending: what the other parts will hold, by frame, see `snapshots_so_far`. memories: per frame;
    memory: the last one and what it depended on. rows: how many rows are valid. over: whether
    the run ended early. count,
    acting: contacts and constraint rows of the last engine step. first_touch: control step by
    pair. came_true: control step by id of the waiting action. releases: joints that let go. head:
    the earlier run that stands for the rows up to `first`, which are not filled here.
    """

    positions: FloatArray
    velocities: FloatArray
    snapshots: FloatArray
    log: ContactLog
    schedule: Schedule
    grip: Grip
    calm: Calm
    fracture: Fracture
    liveliness: Liveliness
    substeps: int
    engine_size: int
    rows: int = 0
    over: bool = False
    count: int = 0
    acting: int = 0
    memories: list[str] = field(default_factory=list)
    memory: tuple[tuple[int, int, bool] | None, str] = (None, "")
    alarms: list[Alarm] = field(default_factory=list)
    releases: list[Release] = field(default_factory=list)
    first_touch: dict[tuple[int, int], int] = field(default_factory=dict)
    came_true: dict[str, int] = field(default_factory=dict)
    head: Rollout | None = None
    first: int = 0
    states: list[FloatArray] = field(init=False)
    pending: list[tuple[int, tuple[int, ...], GripState]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.states = list(self.snapshots[:, : self.engine_size])

    def snapshots_so_far(self) -> FloatArray:
        """(frames reached, K): the snapshots, with what was left to be written into them."""
        if self.pending:
            frames, extras, grips = zip(*self.pending, strict=True)
            rest = self.snapshots[frames[0] : frames[-1] + 1, self.engine_size :]
            rest[:, :EXTRA] = extras
            rest[:, EXTRA:] = self.grip.rows(grips)
            self.pending.clear()
        filled = len(self.memories)
        return self.snapshots if filled == len(self.snapshots) else self.snapshots[:filled].copy()


def new_trace(program: PhysicalProgram, compiled: Compiled, substeps: int) -> Trace:
    """An empty trace of a whole clip."""
    model, clip = compiled.model, program.clip
    dt = clip.step_seconds / substeps
    size = mj.mj_stateSize(model, SNAPSHOT)
    hanging = {item.name: item.tether for item in program.scene.objects if hangs(item)}
    return Trace(
        np.zeros((clip.steps + 1, model.nq)),
        np.zeros((clip.steps + 1, model.nv)),
        np.empty((clip.frames, size + EXTRA + model.npair)),
        ContactLog(compiled, substeps, dt),
        Schedule(program.event.actions, clip.steps, hanging),
        Grip(compiled, dt),
        Calm(compiled, np.array(program.scene.gravity), clip.step_seconds),
        Fracture(program, compiled),
        Liveliness(compiled, dt),
        substeps,
        size,
    )
