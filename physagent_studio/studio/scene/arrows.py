"""Which arrows an action and a moving object have: world vectors, and how long they look."""

from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program import Action, Directed, duration_of
from physagent_studio.program.actions import ApplyForce, SetVelocity
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.records import Rollout
from physagent_studio.simulation.actions.vectors import support_centre, unit_of
from physagent_studio.studio.panels.words import number
from physagent_studio.workbench import Snapshot

VELOCITY_SECONDS = 0.25
"""A velocity's arrow reaches where the object would be after this time."""
WEIGHT_METRES = 0.25
"""A force as large as the object's weight has an arrow of this length."""
GRAVITY = 9.81
LINGER = 12
"""Control steps for which an instantaneous action's arrow stays."""


@dataclass(frozen=True, eq=False, slots=True)
class Arrow:
    """One arrow: the middle of its thing and a vector, world, m.

    scale: metres for one unit of the quantity. reach: half the size of the thing along the world's
    axes, m, beyond which the arrow begins, so that the thing does not hide it. path: the field that
    dragging its tip sets; None where it only shows something.
    """

    key: str
    middle: FloatArray
    vector: FloatArray
    scale: float
    text: str
    kind: str
    reach: tuple[float, float, float] = (0.0, 0.0, 0.0)
    path: str | None = None

    @property
    def foot(self) -> FloatArray:
        """Where the arrow begins, world, m."""
        length = float(np.linalg.norm(self.vector))
        gap = self._gap(self.vector)
        return self.middle + self.vector * (gap / length if length > 1e-9 else 0.0)

    @property
    def tip(self) -> FloatArray:
        """The arrow's tip, world, m."""
        return self.foot + self.vector

    def vector_to(self, tip: FloatArray) -> FloatArray:
        """(3,) m, the vector of the arrow whose tip is there."""
        way = tip - self.middle
        length = float(np.linalg.norm(way))
        gap = self._gap(way)
        return way * (max(length - gap, 1e-6) / length if length > 1e-9 else 0.0)

    def _gap(self, way: FloatArray) -> float:
        """How far from the middle the surface is in a direction, that of an ellipsoid, m."""
        length, reach = float(np.linalg.norm(way)), np.array(self.reach)
        if length < 1e-9 or reach.min() <= 0:
            return 0.0
        return 1.0 / float(np.linalg.norm(way / length / reach))


def action_arrows(snapshot: Snapshot, step: int, selected: str) -> tuple[Arrow, ...]:
    """Arrows of the actions that act on this step, and of the selected one at its start."""
    found = []
    for action in snapshot.program.event.actions:
        if action.muted or not isinstance(action, ApplyForce | SetVelocity):
            continue
        start = start_of(action, snapshot.rollout)
        if start is None:
            continue
        length = LINGER if isinstance(action, SetVelocity) else duration_of(action)
        acts = start <= step < start + length
        if acts or action.id == selected:
            arrow = _of_action(action, snapshot, step if acts else start)
            found += [] if arrow is None else [arrow]
    return tuple(found)


def start_of(action: Action, rollout: Rollout | None) -> int | None:
    """The step on which an action begins: where it fired, else where it is written."""
    if action.when is None:
        return action.start_step
    if rollout is None:
        return None
    return next((span.start for span in rollout.spans if span.id == action.id), None)


def velocity_arrows(snapshot: Snapshot, step: int) -> tuple[Arrow, ...]:
    """Velocities of everything that moves on this step."""
    rollout = snapshot.rollout
    if rollout is None:
        return ()
    row = min(step, rollout.steps)
    found = []
    for at, name in enumerate(rollout.objects):
        velocity = rollout.velocities[row, at]
        speed = float(np.linalg.norm(velocity))
        if speed > 0.02:
            text = f"{number(speed)} m/s"
            vector = velocity * VELOCITY_SECONDS
            middle, reach = rollout.positions[row, at], reach_of(name, snapshot, row)
            found.append(Arrow(name, middle, vector, VELOCITY_SECONDS, text, "velocity", reach))
    return tuple(found)


def _of_action(action: ApplyForce | SetVelocity, snapshot: Snapshot, step: int) -> Arrow | None:
    state = _state_at(action.name, snapshot, step)
    if state is None:
        return None
    foot, velocity, mass = state
    if isinstance(action, SetVelocity):
        value = vector_of(action.velocity, snapshot, foot, velocity, 1.0)
        scale, unit, field = VELOCITY_SECONDS, "m/s", "velocity"
    else:
        seconds = duration_of(action) * snapshot.program.clip.step_seconds
        value = vector_of(action.force, snapshot, foot, velocity, mass, seconds)
        scale, unit, field = WEIGHT_METRES / (mass * GRAVITY), "N", "force"
    if value is None:
        return None
    text = f"{action.id.replace('_', ' ')}: {number(float(np.linalg.norm(value)))} {unit}"
    path = f"event.actions.{action.id}.{field}"
    reach = reach_of(action.name, snapshot, step)
    return Arrow(f"action {action.id}", foot, value * scale, scale, text, "action", reach, path)


def reach_of(name: str, snapshot: Snapshot, step: int) -> tuple[float, float, float]:
    """Half the size of a thing along the world's axes as it lies on a step, m."""
    item, rollout = snapshot.program.scene.object(name), snapshot.rollout
    if item is None or item.shape is None:
        return (0.0, 0.0, 0.0)
    rotation = item.rotation
    if rollout is not None and name in rollout.objects:
        at = rollout.objects.index(name)
        rotation = tuple(rollout.rotations[min(step, rollout.steps), at].tolist())
    # Exact for a box along the axes, and for round things however they are turned.
    half = np.array(outline_of(item.shape).size) / 2
    turned = matrix_of(rotation)
    x, y, z = np.sqrt(turned**2 @ half**2).tolist()
    return x, y, z


def _state_at(
    name: str, snapshot: Snapshot, step: int
) -> tuple[FloatArray, FloatArray, float] | None:
    """Position, velocity and mass of an object on a step."""
    rollout = snapshot.rollout
    if rollout is not None and name in rollout.objects:
        at, row = rollout.objects.index(name), min(step, rollout.steps)
        return rollout.positions[row, at], rollout.velocities[row, at], float(rollout.masses[at])
    item = snapshot.program.scene.object(name)
    if item is None or item.position is None:
        return None
    return np.array(item.position), np.zeros(3), 1.0


def vector_of(
    value: Directed | tuple[float, float, float],
    snapshot: Snapshot,
    position: FloatArray,
    velocity: FloatArray,
    mass: float,
    seconds: float = 1.0,
) -> FloatArray | None:
    """A force or velocity in world axes; None where it aims at a place that is still open.

    `seconds`: how long a force acts, for those that are given as a target speed.
    """
    if not isinstance(value, Directed):
        return np.array(value, float)
    place = None
    if value.toward is not None:
        place = _place(value.toward, snapshot, position)
        if place is None:
            return None
    size = value.magnitude
    if value.quantity == "acceleration":
        size *= mass
    elif value.quantity == "target_speed":
        size *= mass / max(seconds, 1e-6)
    return unit_of(value, position, velocity, place) * size


def _place(
    toward: str | tuple[float, float, float], snapshot: Snapshot, near: FloatArray
) -> FloatArray | None:
    if not isinstance(toward, str):
        return np.array(toward, float)
    scene = snapshot.program.scene
    if (item := scene.object(toward)) is not None:
        return None if item.position is None else np.array(item.position)
    if (support := scene.support(toward)) is not None:
        return None if support.shape is None else support_centre(support.shape, near)
    landmark = scene.landmark(toward)
    if landmark is None or not landmark.points:
        return None
    return np.array(landmark.points, float).mean(axis=0)
