"""The nine operators at run time.

An effect lives from the first step of its action to the last. `begin` runs once, `act` before
each control step, or before each engine step where `each_substep`, `end` once after the last.
Effects account for the work that they do on their target.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

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
from physagent_studio.simulation.surfaces import FloatArray
from physagent_studio.simulation.vectors import unit_of
from physagent_studio.simulation.world import World

ZERO = np.zeros(3)


class Effect(ABC):
    """One action while it acts. work: J put into the target so far."""

    each_substep = False

    def __init__(self, action: Action) -> None:
        self.action = action
        self.work = 0.0

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


class _Push(Effect):
    """A force and a torque that last until the next `act`; work is force times path."""

    def __init__(self, action: Action) -> None:
        super().__init__(action)
        self._last: tuple[FloatArray, FloatArray, FloatArray, FloatArray] | None = None
        self._last_time = 0.0

    def act(self, world: World, time: float) -> None:
        """Settles the work of the last push and pushes anew."""
        self._settle(world, time)
        force, torque = self.wrench(world, time)
        world.push(self.name, force, torque)
        self._last = (force, torque, world.position(self.name), world.angular(self.name))
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
        turned = (angular + world.angular(self.name)) / 2 * (time - self._last_time)
        self.work += float(force @ (world.position(self.name) - position) + torque @ turned)

    @abstractmethod
    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        """Force (N) at the centre of mass and torque (N·m) about it, world frame."""


def _direction(world: World, name: str, vector: Directed) -> FloatArray:
    position = world.position(name)
    place = None
    if isinstance(vector.toward, str):
        place = world.place(vector.toward, position)
    elif vector.toward is not None:
        place = np.array(vector.toward, float)
    return unit_of(vector, position, world.velocity(name), place)


def _plain(world: World, name: str, vector: tuple[float, ...] | Directed) -> FloatArray:
    """A vector whose magnitude is the quantity itself."""
    if isinstance(vector, Directed):
        return vector.magnitude * _direction(world, name, vector)
    return np.array(vector, float)


class _SetVelocity(Effect):
    action: SetVelocity

    def begin(self, world: World) -> None:
        before = world.kinetic(self.name)
        world.set_velocity(self.name, _plain(world, self.name, self.action.velocity))
        self.work = world.kinetic(self.name) - before

    def act(self, world: World, time: float) -> None:
        pass


class _SetAngularVelocity(Effect):
    each_substep = True
    action: SetAngularVelocity

    def __init__(self, action: SetAngularVelocity) -> None:
        super().__init__(action)
        self._angular = ZERO

    def begin(self, world: World) -> None:
        self._angular = _plain(world, self.name, self.action.angular_velocity)

    def act(self, world: World, time: float) -> None:
        before = world.kinetic(self.name)
        world.set_angular(self.name, self._angular)
        self.work += world.kinetic(self.name) - before


class _ApplyForce(_Push):
    action: ApplyForce

    def __init__(self, action: ApplyForce) -> None:
        super().__init__(action)
        vector = action.force
        self._follows = isinstance(vector, Directed) and vector.along is not None
        # A lever arm turns with the body, a direction along the velocity with the path.
        self.each_substep = action.point is not None or self._follows
        self._unit = ZERO
        self._steering: Steering | None = None

    def begin(self, world: World) -> None:
        vector = self.action.force
        if not isinstance(vector, Directed):
            return
        self._unit = _direction(world, self.name, vector)
        if vector.quantity == "target_speed":
            speed = float(world.velocity(self.name) @ self._unit)
            seconds = self.action.duration * world.step_seconds
            self._steering = Steering(vector.magnitude, speed, seconds, world.mass(self.name))

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        force = self._force(world, time)
        if self.action.point is None:
            return force, ZERO
        point = np.array(self.action.point, float)
        centre = world.centre(self.name)
        if self.action.point_frame == "body":
            point = world.position(self.name) + world.rotation(self.name) @ point
        return force, np.cross(point - centre, force)

    def _force(self, world: World, time: float) -> FloatArray:
        vector = self.action.force
        if not isinstance(vector, Directed):
            return np.array(vector, float)
        velocity = world.velocity(self.name)
        if self._steering is not None:
            return self._unit * self._steering.force(float(velocity @ self._unit), time)
        if self._follows:
            self._unit = _direction(world, self.name, vector)
        size = vector.magnitude
        if vector.quantity == "acceleration":
            size *= world.mass(self.name)
        if vector.along == "against_velocity":
            # A brake stops a thing within a step, it does not drive it backwards.
            stop = world.mass(self.name) * float(np.linalg.norm(velocity)) / world.dt
            size = min(size, stop)
        return self._unit * size


class Steering:
    """The force along a line that brings a speed to its target at the end of a window.

    Closed loop: what friction or gravity took in the last steps is added in the next, and the
    rest is spread over the time that is left. Bounded, so that a blocked body is not crushed.
    """

    def __init__(self, target: float, speed: float, seconds: float, mass: float) -> None:
        self._target, self._seconds, self._mass = target, seconds, mass
        nominal = abs(target - speed) / seconds
        self._limit = 4 * nominal + 20.0
        self._last: tuple[float, float, float] | None = None
        self._resistance = 0.0
        self._count = 0

    def force(self, speed: float, time: float) -> float:
        """N; speed: m/s now; time: s since the start."""
        if self._last is not None:
            then, before, applied = self._last
            gained = (speed - before) / max(time - then, 1e-9)
            # A mean at first, then forgetting: single steps of a sliding contact are noisy.
            self._count += 1
            share = max(1 / self._count, 0.25)
            self._resistance += share * (applied - gained - self._resistance)
        left = max(self._seconds - time, 1e-9)
        wanted = (self._target - speed) / left + self._resistance
        wanted = max(-self._limit, min(self._limit, wanted))
        self._last = (time, speed, wanted)
        return wanted * self._mass


class _ApplyTorque(_Push):
    action: ApplyTorque

    def __init__(self, action: ApplyTorque) -> None:
        super().__init__(action)
        self._torque = ZERO

    def begin(self, world: World) -> None:
        vector = self.action.torque
        self._torque = _plain(world, self.name, vector)
        if isinstance(vector, Directed) and vector.quantity != "value":
            # An angular acceleration, or an angular speed to reach over the whole duration.
            self._torque = world.inertia(self.name) @ self._torque
            if vector.quantity == "target_speed":
                self._torque /= self.action.duration * world.step_seconds

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        return ZERO, self._torque


class _ApplyAngledForce(_Push):
    each_substep = True
    action: ApplyAngledForce

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        vx, vy, _ = world.velocity(self.name)
        angle = math.radians(self.action.angle)
        speed = math.hypot(vx, vy)
        heading = math.atan2(vy, vx) if speed > 1e-9 else 0.0
        # The force shall keep its angle to the velocity in the middle of the engine step, which
        # it turns itself; then a force across the path does no work at all.
        kick = self.action.magnitude * world.dt / (2 * world.mass(self.name))
        lead = kick * math.sin(angle) / speed if speed > 1e-9 else 0.0
        if abs(lead) < 1:
            angle += math.asin(lead)
        angle += heading
        force = self.action.magnitude * np.array([math.cos(angle), math.sin(angle), 0.0])
        return force, ZERO


class _ApplyDisturbance(_Push):
    each_substep = True
    action: ApplyDisturbance

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        middle = time + world.dt / 2
        total = self.action.duration * world.step_seconds
        force = disturbance(
            self.action, middle, total, world.velocity(self.name), world.drag(self.name)
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
    action: FixObject

    def begin(self, world: World) -> None:
        before = world.kinetic(self.name)
        world.hold(self.name)
        self.work = -before

    def act(self, world: World, time: float) -> None:
        pass

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


def effect_of(action: Action) -> Effect:
    """The effect of an action, not begun yet."""
    return _EFFECTS[type(action)](action)
