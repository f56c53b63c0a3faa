"""`Rollout`: what happened when a program ran; opened without MuJoCo."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray

CONTACT_DTYPE = np.dtype(
    [
        ("step", np.int32),  # control step on which it was seen
        ("a", np.int16),  # body index, see Rollout.bodies
        ("b", np.int16),
        ("point", np.float64, 3),  # world, m
        ("normal", np.float64, 3),  # world, unit, from a to b
        ("impulse", np.float64),  # normal impulse on this step, N·s
        ("depth", np.float64),  # deepest on this step, m, ≥ 0, beyond the initial overlap
    ]
)


CARRYING = 0.3
"""A contact carries when the upward part of its normal is at least this."""


@dataclass(frozen=True, slots=True)
class Alarm:
    """What the engine or a tripwire reported: on which step, about what, in a sentence."""

    step: int
    kind: Literal["blow_up", "penetration", "energy", "engine", "action", "material"]
    text: str


@dataclass(frozen=True, slots=True)
class ActionSpan:
    """When an action really acted (start inclusive, end exclusive); None: it never started.

    work: energy that it put in, J.
    """

    id: str
    start: int | None
    end: int | None
    work: float


@dataclass(frozen=True, slots=True)
class Release:
    """A joint of the breakable object `name` that let go: on which step, at what impulse, N·s."""

    step: int
    name: str
    joint: str
    impulse: float


@dataclass(frozen=True, eq=False, slots=True)
class Rollout:
    """S control steps of N objects; index 0 is the initial state, so arrays have S + 1 rows.

    objects: names, in the order of axis 1. bodies: objects first, then supports; contacts
    refer to these. positions: (S+1, N, 3) world, m, of the centres of mass. rotations:
    (S+1, N, 4) R_world_body, wxyz. velocities: (S+1, N, 3) world, m/s. angular: (S+1, N, 3)
    world, rad/s. contacts: structured, `CONTACT_DTYPE`, sorted by step; resting contacts appear
    on every step. kinetic, potential: (S+1, N) J, of motion and of gravity; what a soft,
    plastic, cloth or rope body stores by its shape is in neither, since MuJoCo's energy counts
    springs of joints, tendons and edges and gives 0 for the elasticity of a flex. masses: (N,)
    kg. penetration: (S+1,) m, deepest, beyond what a pair overlapped by initially (an alarm on
    step 0 names that).
    vertices: deformed visual vertices per frame for soft objects, (frames, V, 3).
    releases: joints of breakable objects that let go, sorted by step.

    For running again from a frame: snapshots, (frames reached, K) engine states; memories, what
    the actions knew there; actions, (id, JSON) of those that acted; setting, a hash of all else.
    """

    program_hash: str
    objects: tuple[str, ...]
    bodies: tuple[str, ...]
    step_seconds: float
    steps_per_frame: int
    frames: int
    positions: FloatArray
    rotations: FloatArray
    velocities: FloatArray
    angular: FloatArray
    contacts: NDArray[np.void]
    kinetic: FloatArray
    potential: FloatArray
    masses: FloatArray
    penetration: FloatArray
    spans: tuple[ActionSpan, ...]
    warnings: tuple[Alarm, ...]
    versions: tuple[tuple[str, str], ...]
    vertices: tuple[tuple[str, FloatArray], ...] = ()
    releases: tuple[Release, ...] = ()
    snapshots: FloatArray | None = None
    memories: tuple[str, ...] = ()
    actions: tuple[tuple[str, str], ...] = ()
    setting: str = ""

    @property
    def blown_up(self) -> Alarm | None:
        """The warning that ended the run early, or None."""
        return next((item for item in self.warnings if item.kind == "blow_up"), None)

    @property
    def steps(self) -> int:
        """Number of control steps; rows of the arrays less one."""
        return len(self.positions) - 1

    def index(self, name: str) -> int:
        """Index of an object or support among `bodies`."""
        return self.bodies.index(name)

    def carriers(self) -> NDArray[np.int64]:
        """(K, 3) which body carries which object when: step, object, its carrier; sorted by step.

        One carries another where they touch and the push on it points up.
        """
        rows = self.contacts
        # The normal points from a to b, so it is the push on b.
        up = rows["normal"][:, 2]
        forward, back = np.flatnonzero(up >= CARRYING), np.flatnonzero(up <= -CARRYING)
        order = np.concatenate([forward, back])
        carried = np.concatenate([rows["b"][forward], rows["a"][back]])
        carrier = np.concatenate([rows["a"][forward], rows["b"][back]])
        found = np.column_stack([rows["step"][order], carried, carrier]).astype(np.int64)
        found = found[found[:, 1] < len(self.objects)]
        return found[np.argsort(found[:, 0], kind="stable")]

    def frame_steps(self) -> NDArray[np.int64]:
        """(frames,) the control step that each frame shows."""
        return np.minimum(np.arange(self.frames) * self.steps_per_frame, self.steps)

    def frame_of(self, step: int) -> int:
        """The frame that shows a control step."""
        return min(step // self.steps_per_frame, self.frames - 1)
