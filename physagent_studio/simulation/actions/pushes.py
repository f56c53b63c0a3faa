"""The operators that push: a force, a torque, a force at an angle to the path, a disturbance."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from physagent_studio.program import Action, Directed, actions
from physagent_studio.simulation.actions.disturbance import disturbance
from physagent_studio.simulation.actions.effect import Effect, direction_of, plain_vector
from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.model.parts import ZERO, Part
from physagent_studio.simulation.surfaces import FloatArray


class Push(Effect):
    """A force and a torque that last until the next `act`; work is force times path."""

    kept = ("work", "_last", "_last_time")

    def __init__(self, action: Action) -> None:
        super().__init__(action)
        # Force, torque, position and angular velocity at the last push.
        self._last: Sequence[FloatArray] | None = None
        self._last_time = 0.0

    def act(self, world: World, time: float) -> None:
        """Settles the work of the last push and pushes anew."""
        part = world.part(self.name)
        position = part.position()
        self._settle(part, position, time)
        force, torque = self.wrench(world, time)
        part.push(force, torque)
        angular = ZERO if torque is ZERO else part.angular()
        self._last = (force, torque, position, angular)
        self._last_time = time

    def end(self, world: World) -> None:
        """Settles the work of the last push."""
        unit = world.dt if self.each_substep else world.step_seconds
        part = world.part(self.name)
        self._settle(part, part.position(), self._last_time + unit)
        self._last = None

    def _settle(self, part: Part, position: FloatArray, time: float) -> None:
        if self._last is None:
            return
        force, torque, before, angular = self._last
        self.work += float(force @ (position - before))
        if torque is not ZERO and torque.any():
            turned = (angular + part.angular()) / 2 * (time - self._last_time)
            self.work += float(torque @ turned)

    @abstractmethod
    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        """Force (N) at the centre of mass and torque (N·m) about it, world frame."""


class ApplyForceEffect(Push):
    """A force, at the centre of mass or at a point; or a controlled speed."""

    kept = (*Push.kept, "_unit")
    action: actions.ApplyForce

    def __init__(self, action: actions.ApplyForce) -> None:
        super().__init__(action)
        vector = action.force
        self._follows = isinstance(vector, Directed) and vector.along is not None
        self._unit = ZERO
        self._steering: Steering | None = None

    @property
    def each_substep(self) -> bool:
        """A lever arm turns with the body, a direction along the velocity with the path."""
        return self.action.point is not None or self._follows

    def most_gain(self, world: World) -> float:
        """What the force can do at the centre of mass; it turns nothing there."""
        vector = self.action.force
        if self._steering is not None:
            return self._steering.limit
        if isinstance(vector, Directed) and vector.quantity == "acceleration":
            return vector.magnitude
        size = vector.magnitude if isinstance(vector, Directed) else math.hypot(*vector)
        return size / world.part(self.name).mass

    def begin(self, world: World) -> None:
        vector = self.action.force
        if not isinstance(vector, Directed):
            return
        self._unit = direction_of(world, self.name, vector)
        if vector.quantity == "target_speed":
            speed = float(world.part(self.name).velocity() @ self._unit)
            seconds = self.action.duration * world.step_seconds
            mass = world.part(self.name).mass
            self._steering = Steering.towards(vector.magnitude, speed, seconds, mass)

    def memory(self) -> dict[str, Any]:
        """The push, its direction and the state of the controller."""
        steering = None
        if self._steering is not None:
            steering = {name: getattr(self._steering, name) for name in STEERING}
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
            self._unit = direction_of(world, self.name, vector)
        size = vector.magnitude
        if vector.quantity == "acceleration":
            size *= world.part(self.name).mass
        if vector.along == "against_velocity":
            # A brake stops a thing within a step, it does not drive it backwards.
            stop = world.part(self.name).mass * float(np.linalg.norm(velocity)) / world.dt
            size = min(size, stop)
        return self._unit * size


STUCK, CREEPS = 0.02, 1e-3
"""Part of the asked acceleration, and m/s, below which a pushed thing has not moved yet."""
LEANS = 0.3
"""Growth of the push from step to step while it sticks."""


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
            if abs(gained) < STUCK * abs(self.last_acceleration) and abs(speed) < CREEPS:
                # It sticks: a hand leans on it harder until it gives way, whatever the window.
                self.resistance += LEANS * max(abs(self.resistance), 1.0) * np.sign(self.target)
            # A mean at first, then forgetting: single steps of a sliding contact are noisy.
            share = max(1 / self.count, 0.25)
            self.resistance += share * (self.last_acceleration - gained - self.resistance)
        left = max(self.seconds - time, 1e-9)
        wanted = (self.target - speed) / left + self.resistance
        wanted = max(-self.limit, min(self.limit, wanted))
        self.count += 1
        self.last_time, self.last_speed, self.last_acceleration = time, speed, wanted
        return wanted * self.mass


STEERING = tuple(item.name for item in fields(Steering))


class ApplyTorqueEffect(Push):
    """A torque about the centre of mass."""

    kept = (*Push.kept, "_torque")
    action: actions.ApplyTorque

    def __init__(self, action: actions.ApplyTorque) -> None:
        super().__init__(action)
        self._torque = ZERO

    def begin(self, world: World) -> None:
        vector = self.action.torque
        self._torque = plain_vector(world, self.name, vector)
        if isinstance(vector, Directed) and vector.quantity != "value":
            # An angular acceleration, or an angular speed to reach over the whole duration.
            self._torque = world.part(self.name).inertia() @ self._torque
            if vector.quantity == "target_speed":
                self._torque /= self.action.duration * world.step_seconds

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        return ZERO, self._torque


class ApplyAngledForceEffect(Push):
    """A force at an angle to the horizontal velocity; across it, it steers what is on wheels."""

    @property
    def each_substep(self) -> bool:
        return True

    action: actions.ApplyAngledForce

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        vx, vy, _ = world.part(self.name).velocity()
        across = self.action.magnitude * math.sin(math.radians(self.action.angle))
        if world.wheels is not None and world.wheels.steer(world.names[self.name], across):
            along = self.action.magnitude * math.cos(math.radians(self.action.angle))
            way = np.array([vx, vy, 0.0]) / max(math.hypot(vx, vy), 1e-9)
            return along * way, ZERO
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


class ApplyDisturbanceEffect(Push):
    """Wind, gust, bump, side, shake or jitter."""

    @property
    def each_substep(self) -> bool:
        return True

    action: actions.ApplyDisturbance

    def wrench(self, world: World, time: float) -> tuple[FloatArray, FloatArray]:
        middle = time + world.dt / 2
        total = self.action.duration * world.step_seconds
        force = disturbance(
            self.action, middle, total, world.part(self.name).velocity(), world.drag(self.name)
        )
        return force, ZERO
