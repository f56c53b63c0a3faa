"""The nine operators at run time.

An effect lives from the first step of its action to the last. `begin` runs once, `act` before
each control step, or before each engine step where `each_substep`, `end` once after the last.
Effects account for the work that they do on their target.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from physagent_studio.program import Action, Directed
from physagent_studio.program.actions import (
    ApplyAngledForce,
    ApplyDisturbance,
    ApplyForce,
    ApplyTorque,
    FixObject,
    SetAngularVelocity,
    SetOrientation,
    SetPosition,
    SetVelocity,
)
from physagent_studio.simulation.disturbance import disturbance
from physagent_studio.simulation.parts import CloudPart, RigidPart
from physagent_studio.simulation.surfaces import FloatArray
from physagent_studio.simulation.vectors import unit_of
from physagent_studio.simulation.world import World

ZERO = np.zeros(3)


class Effect(ABC):
    """One action while it acts.

    work: J put into the target so far. kept: the attributes that make up its memory while it
    acts, plain numbers or arrays.
    """

    kept: tuple[str, ...] = ("work",)

    def __init__(self, action: Action) -> None:
        self.action = action
        self.work = 0.0

    @property
    def each_substep(self) -> bool:
        """Whether `act` runs before every engine step."""
        return False

    @property
    def name(self) -> str:
        """The target object."""
        return self.action.name

    def begin(self, world: World) -> None:
        """Runs once, at the start of the first step; most effects have nothing to do."""
        return

    @abstractmethod
    def act(self, world: World, time: float) -> None:
        """Runs before each (engine or control) step; time: s since the action began."""

    def end(self, world: World) -> None:
        """Runs once, after the last step; most effects have nothing to do."""
        return

    def resume(self, world: World) -> None:
        """Runs after `recall`, to restore what is not in the engine's state."""
        return

    def memory(self) -> dict[str, Any]:
        """Everything that it has learned since it began, as JSON."""
        return {name: _as_json(getattr(self, name)) for name in self.kept}

    def recall(self, memory: dict[str, Any]) -> None:
        """Takes up where `memory` was taken."""
        for name in self.kept:
            value = memory[name]
            setattr(self, name, np.array(value) if isinstance(value, list) else value)


def _as_json(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


class _Push(Effect):
    """A force and a torque that last until the next `act`; work is force times path."""

    kept = ("work", "_last", "_last_time")

    def __init__(self, action: Action) -> None:
        super().__init__(action)
        # Force, torque, position and angular velocity at the last push, one row each.
        self._last: FloatArray | None = None
        self._last_time = 0.0

    def act(self, world: World, time: float) -> None:
        """Settles the work of the last push and pushes anew."""
        self._settle(world, time)
        force, torque = self.wrench(world, time)
        world.part(self.name).push(force, torque)
        state = (world.part(self.name).position(), world.part(self.name).angular())
        self._last = np.array([force, torque, *state])
        self._last_time = time

    def end(self, world: World) -> None:
        """Settles the work of the last push."""
        unit = world.dt if self.each_substep else world.step_seconds
        self._settle(world, self._last_time + unit)
        self._last = None

    def _settle(self, world: World, time: float) -> None:
        if self._last is None:
            return
        force, torque, position, angular = self._last
        turned = (angular + world.part(self.name).angular()) / 2 * (time - self._last_time)
        self.work += float(force @ (world.part(self.name).position() - position) + torque @ turned)

    @abstractmethod
    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        """Force (N) at the centre of mass and torque (N·m) about it, world frame."""


def _direction(world: World, name: str, vector: Directed) -> FloatArray:
    position = world.part(name).position()
    place = None
    if isinstance(vector.toward, str):
        place = world.place(vector.toward, position)
    elif vector.toward is not None:
        place = np.array(vector.toward, float)
    return unit_of(vector, position, world.part(name).velocity(), place)


def _plain(world: World, name: str, vector: tuple[float, ...] | Directed) -> FloatArray:
    """A vector whose magnitude is the quantity itself."""
    if isinstance(vector, Directed):
        return vector.magnitude * _direction(world, name, vector)
    return np.array(vector, float)


class _SetVelocity(Effect):
    action: SetVelocity

    def begin(self, world: World) -> None:
        before = world.part(self.name).kinetic()
        world.set_velocity(self.name, _plain(world, self.name, self.action.velocity))
        self.work = world.part(self.name).kinetic() - before

    def act(self, world: World, time: float) -> None:
        pass


class _SetAngularVelocity(Effect):
    @property
    def each_substep(self) -> bool:
        return True

    kept = ("work", "_angular")
    action: SetAngularVelocity

    def __init__(self, action: SetAngularVelocity) -> None:
        super().__init__(action)
        self._angular = ZERO

    def begin(self, world: World) -> None:
        self._angular = _plain(world, self.name, self.action.angular_velocity)

    def act(self, world: World, time: float) -> None:
        before = world.part(self.name).kinetic()
        world.part(self.name).set_angular(self._angular)
        self.work += world.part(self.name).kinetic() - before


class _ApplyForce(_Push):
    kept = (*_Push.kept, "_unit")
    action: ApplyForce

    def __init__(self, action: ApplyForce) -> None:
        super().__init__(action)
        vector = action.force
        self._follows = isinstance(vector, Directed) and vector.along is not None
        self._unit = ZERO
        self._steering: Steering | None = None

    @property
    def each_substep(self) -> bool:
        """A lever arm turns with the body, a direction along the velocity with the path."""
        return self.action.point is not None or self._follows

    def begin(self, world: World) -> None:
        vector = self.action.force
        if not isinstance(vector, Directed):
            return
        self._unit = _direction(world, self.name, vector)
        if vector.quantity == "target_speed":
            speed = float(world.part(self.name).velocity() @ self._unit)
            seconds = self.action.duration * world.step_seconds
            mass = world.part(self.name).mass
            self._steering = Steering.towards(vector.magnitude, speed, seconds, mass)

    def memory(self) -> dict[str, Any]:
        """The push, its direction and the state of the controller."""
        steering = asdict(self._steering) if self._steering is not None else None
        return {**super().memory(), "steering": steering}

    def recall(self, memory: dict[str, Any]) -> None:
        """Takes up where `memory` was taken."""
        super().recall(memory)
        if memory["steering"] is not None:
            self._steering = Steering(**memory["steering"])

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        force = self._force(world, time)
        if self.action.point is None:
            return force, ZERO
        point = np.array(self.action.point, float)
        centre = world.part(self.name).centre()
        if self.action.point_frame == "body":
            point = world.part(self.name).position() + world.part(self.name).rotation() @ point
        return force, np.cross(point - centre, force)

    def _force(self, world: World, time: float) -> FloatArray:
        vector = self.action.force
        if not isinstance(vector, Directed):
            return np.array(vector, float)
        velocity = world.part(self.name).velocity()
        if self._steering is not None:
            return self._unit * self._steering.force(float(velocity @ self._unit), time)
        if self._follows:
            self._unit = _direction(world, self.name, vector)
        size = vector.magnitude
        if vector.quantity == "acceleration":
            size *= world.part(self.name).mass
        if vector.along == "against_velocity":
            # A brake stops a thing within a step, it does not drive it backwards.
            stop = world.part(self.name).mass * float(np.linalg.norm(velocity)) / world.dt
            size = min(size, stop)
        return self._unit * size


@dataclass(eq=False, slots=True)
class Steering:
    """The force along a line that brings a speed to its target at the end of a window.

    Closed loop: what friction or gravity took in the last steps is added in the next, and the
    rest is spread over the time that is left. Bounded, so that a blocked body is not crushed.
    target: m/s. seconds: length of the window. limit: m/s².
    """

    target: float
    seconds: float
    mass: float
    limit: float
    count: int = 0
    resistance: float = 0.0
    last_time: float = 0.0
    last_speed: float = 0.0
    last_acceleration: float = 0.0

    @classmethod
    def towards(cls, target: float, speed: float, seconds: float, mass: float) -> Steering:
        """From `speed` now to `target` after `seconds`."""
        return cls(target, seconds, mass, 4 * abs(target - speed) / seconds + 20.0)

    def force(self, speed: float, time: float) -> float:
        """N; speed: m/s now; time: s since the start."""
        if self.count:
            gained = (speed - self.last_speed) / max(time - self.last_time, 1e-9)
            # A mean at first, then forgetting: single steps of a sliding contact are noisy.
            share = max(1 / self.count, 0.25)
            self.resistance += share * (self.last_acceleration - gained - self.resistance)
        left = max(self.seconds - time, 1e-9)
        wanted = (self.target - speed) / left + self.resistance
        wanted = max(-self.limit, min(self.limit, wanted))
        self.count += 1
        self.last_time, self.last_speed, self.last_acceleration = time, speed, wanted
        return wanted * self.mass


class _ApplyTorque(_Push):
    kept = (*_Push.kept, "_torque")
    action: ApplyTorque

    def __init__(self, action: ApplyTorque) -> None:
        super().__init__(action)
        self._torque = ZERO

    def begin(self, world: World) -> None:
        vector = self.action.torque
        self._torque = _plain(world, self.name, vector)
        if isinstance(vector, Directed) and vector.quantity != "value":
            # An angular acceleration, or an angular speed to reach over the whole duration.
            self._torque = world.part(self.name).inertia() @ self._torque
            if vector.quantity == "target_speed":
                self._torque /= self.action.duration * world.step_seconds

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        return ZERO, self._torque


class _ApplyAngledForce(_Push):
    @property
    def each_substep(self) -> bool:
        return True

    action: ApplyAngledForce

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        vx, vy, _ = world.part(self.name).velocity()
        angle = math.radians(self.action.angle)
        speed = math.hypot(vx, vy)
        heading = math.atan2(vy, vx) if speed > 1e-9 else 0.0
        # The force shall keep its angle to the velocity in the middle of the engine step, which
        # it turns itself; then a force across the path does no work at all.
        kick = self.action.magnitude * world.dt / (2 * world.part(self.name).mass)
        lead = kick * math.sin(angle) / speed if speed > 1e-9 else 0.0
        if abs(lead) < 1:
            angle += math.asin(lead)
        angle += heading
        force = self.action.magnitude * np.array([math.cos(angle), math.sin(angle), 0.0])
        return force, ZERO


class _ApplyDisturbance(_Push):
    @property
    def each_substep(self) -> bool:
        return True

    action: ApplyDisturbance

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        middle = time + world.dt / 2
        total = self.action.duration * world.step_seconds
        force = disturbance(
            self.action, middle, total, world.part(self.name).velocity(), world.drag(self.name)
        )
        return force, ZERO


class _SetPosition(Effect):
    action: SetPosition

    def begin(self, world: World) -> None:
        before = world.energy(self.name)
        world.set_pose(self.name, position=np.array(self.action.position, float))
        self.work = world.energy(self.name) - before

    def act(self, world: World, time: float) -> None:
        pass


class _SetOrientation(Effect):
    action: SetOrientation

    def begin(self, world: World) -> None:
        before = world.energy(self.name)
        world.set_pose(self.name, rotation=np.array(self.action.rotation, float))
        self.work = world.energy(self.name) - before

    def act(self, world: World, time: float) -> None:
        pass


class _FixObject(Effect):
    kept = ("work", "_point", "_places")
    action: FixObject

    def __init__(self, action: FixObject) -> None:
        super().__init__(action)
        self._point: FloatArray | None = None
        self._places: FloatArray | None = None

    @property
    def each_substep(self) -> bool:
        """A weld holds a rigid body by itself; nodes are put back before every engine step."""
        return self._places is not None

    def begin(self, world: World) -> None:
        part = world.part(self.name)
        if isinstance(part, RigidPart) and self.action.point is not None:
            self._point = np.array(self.action.point, float)
            if self.action.point_frame == "world":
                self._point = part.rotation().T @ (self._point - part.position())
            part.pin(self._point)
            return
        self.work = -part.kinetic()
        part.hold()
        if isinstance(part, CloudPart):
            self._places = part.kept()

    def resume(self, world: World) -> None:
        part = world.part(self.name)
        if self._point is not None and isinstance(part, RigidPart):
            part.place_pin(self._point)

    def act(self, world: World, time: float) -> None:
        part = world.part(self.name)
        if isinstance(part, CloudPart) and self._places is not None:
            part.keep(self._places)

    def end(self, world: World) -> None:
        world.release(self.name)


_EFFECTS: dict[type, type[Effect]] = {
    SetVelocity: _SetVelocity,
    SetAngularVelocity: _SetAngularVelocity,
    ApplyForce: _ApplyForce,
    ApplyTorque: _ApplyTorque,
    ApplyAngledForce: _ApplyAngledForce,
    ApplyDisturbance: _ApplyDisturbance,
    SetPosition: _SetPosition,
    SetOrientation: _SetOrientation,
    FixObject: _FixObject,
}


OPERATORS = tuple(_EFFECTS)
"""The operators that can run."""


def effect_of(action: Action) -> Effect:
    """The effect of an action, not begun yet."""
    return _EFFECTS[type(action)](action)
