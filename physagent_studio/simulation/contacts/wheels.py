"""Things on wheels: they roll along their own axis, hold across it, and keep their heading.

A contact of the engine grips alike in all directions, along axes of its own. So while a thing
stands on its wheels, what carries it has no friction for it, and the wheels' forces are ours: for
each control step those that would end its sliding along, its sliding across and its turning by
the end of the step, whatever pushes it meanwhile, each no stronger than its limit: the rolling
resistance along, the grip across, and the grip at the arm of half a wheelbase against turning.
Where a limit is reached it rolls on, slips or is turned as by Coulomb's law. They act at the centre
of mass: springs and riders lean against them, so that a push to the side makes nothing tip over.
The forces only ever take away motion, and what carries it gets their opposite.

A force across its way steers it: the wheels turn it, as far as they can, so that its way bends as
much as that force would bend it.

Lying on its side it slides as its material does; so it does against what it runs into.
"""

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import cross, matrix_of
from physagent_studio.program.scene.state import Wall
from physagent_studio.program.scene.state import Wheels as Given
from physagent_studio.simulation.bodies.undercarriage import ARM, UPRIGHT, axes_of
from physagent_studio.simulation.mj import Data
from physagent_studio.simulation.model.model import Compiled
from physagent_studio.simulation.model.parts import Part, RigidPart
from physagent_studio.simulation.surfaces import FloatArray

MAX_CURVATURE = 2.0
"""1 / turning radius, over 1 / length: the tightest circle is as wide as the thing is long."""

Footing: TypeAlias = tuple[FloatArray, FloatArray, int, float]
"""What carries it: unit normal, point, index of the object or −1, and friction with it."""


class Wheelset:
    """One object on wheels.

    footing: what it stands on with its wheels, None where it does not. loosened: its contact
    pairs whose friction is the wheels'. steered: N across its way, to the left, by which its wheels
    are turned for the engine step that comes.
    """

    def __init__(
        self, part: RigidPart, given: Given, rotation: Sequence[float], extent: FloatArray
    ) -> None:
        self.up, self.ahead = axes_of(given, rotation)
        self.length = float(np.abs(self.ahead) @ extent)
        self.arm, self.steered = ARM * self.length, 0.0
        self.part, self.given = part, given
        self.principal = matrix_of(part.model.body_iquat[part.handle.body].tolist())
        # Of each of its contact pairs: the other's index, friction, and whether it is a support
        # that carries things.
        self.pairs: dict[int, tuple[int, float, bool]] = {}
        self.loosened: frozenset[int] = frozenset()
        self.footing: Footing | None = None

    def wrench(
        self, data: Data, gravity: FloatArray, seconds: float, carrier: Part | None
    ) -> tuple[FloatArray, FloatArray] | None:
        """Force and torque (world) of the wheels for a control step; None off its wheels.

        What else pushes it for the step is in `xfrc_applied`. carrier: the object that it is on.
        """
        if self.footing is None:
            return None
        normal, spot, _, friction = self.footing
        turn, part = self.part.rotation(), self.part
        ahead = turn @ self.ahead
        ahead = ahead - float(ahead @ normal) * normal
        length = math.hypot(*ahead)
        if length < 1e-6:
            return None
        ahead = ahead / length
        pushed = data.xfrc_applied[part.handle.body]
        force = pushed[:3] + part.mass * gravity
        load = -float(force @ normal)
        if load <= 0:
            return None
        body, at = part.handle.body, part.handle.velocity
        spin, middle = data.qvel[at + 3 : at + 6], part.model.body_ipos[body]
        angular, velocity = turn @ spin, part.velocity()
        if middle.any():
            velocity += turn @ cross(spin, middle)
        own = self.principal.T @ (turn.T @ normal)
        mass, inertia = part.mass, float(part.model.body_inertia[body] @ (own * own))
        if carrier is not None:
            velocity = velocity - carrier.velocity()
            velocity = velocity - cross(carrier.angular(), spot - carrier.centre())
            angular = angular - carrier.angular()
            # What it stands on gives way as well.
            mass *= carrier.mass / (mass + carrier.mass)
        grip = load * (friction if self.given.grip is None else self.given.grip)
        across = cross(normal, ahead)
        found = np.zeros(3)
        for way, limit in ((ahead, self.given.rolling * load), (across, grip)):
            found += way * _within(-mass * float(velocity @ way) / seconds - force @ way, limit)
        turning = self._turning(float(velocity @ ahead), grip)
        held = inertia * (turning - float(angular @ normal)) / seconds - float(pushed[3:] @ normal)
        return found, normal * _within(held, grip * self.arm)

    def _turning(self, speed: float, grip: float) -> float:
        """rad/s at which the wheels turn it at a speed along its axis, m/s, as they are steered."""
        across = _within(self.steered, grip)
        if across == 0 or abs(speed) < 1e-6:
            return 0.0
        return _within(
            across / (self.part.mass * abs(speed)), MAX_CURVATURE / self.length * abs(speed)
        )


def _within(value: float, limit: float) -> float:
    return min(max(float(value), -limit), limit)


class Wheels:
    """All objects of a scene that are on wheels."""

    def __init__(self, program: PhysicalProgram, compiled: Compiled, parts: Sequence[Part]) -> None:
        scene = program.scene
        self._compiled, self._parts = compiled, parts
        self._gravity = np.array(scene.gravity, float)
        self._seconds = program.clip.step_seconds
        self._sets: dict[int, Wheelset] = {}
        for index, (item, part) in enumerate(zip(scene.objects, parts, strict=True)):
            if item.wheels is not None and isinstance(part, RigidPart):
                extent = np.asarray(compiled.solids[index].extent)
                self._sets[index] = Wheelset(part, item.wheels, item.rotation, extent)
        walls = {
            len(parts) + number
            for number, support in enumerate(scene.supports)
            if isinstance(support.shape, Wall)
        }
        for pair, ends in enumerate(compiled.pair_bodies.tolist()):
            friction = float(compiled.model.pair_friction[pair, 0])
            for own, other in (ends, ends[::-1]):
                if own in self._sets and own != other:
                    carries = other >= len(parts) and other not in walls
                    self._sets[own].pairs[pair] = (other, friction, carries)
        self._given: list[tuple[Part, FloatArray, FloatArray]] = []

    @property
    def most_gain(self) -> float:
        """m/s² by which the wheels may change a velocity at most, beside gravity."""
        grips = [
            max((f for _, f, _ in one.pairs.values()), default=0.0)
            if one.given.grip is None
            else one.given.grip
            for one in self._sets.values()
        ]
        rolling = max(one.given.rolling for one in self._sets.values())
        return (max(grips) + rolling) * float(np.linalg.norm(self._gravity))

    def act(self) -> None:
        """Works out the wheels' forces for a control step, and pushes with them."""
        data, self._given = self._compiled.data, []
        for one in self._sets.values():
            carrier = None
            if one.footing is not None and one.footing[2] >= 0:
                carrier = self._parts[one.footing[2]]
            wrench = one.wrench(data, self._gravity, self._seconds, carrier)
            if wrench is None:
                continue
            force, torque = wrench
            self._given.append((one.part, force, torque))
            if carrier is not None and one.footing is not None:
                lever = cross(one.footing[1] - carrier.centre(), -force)
                self._given.append((carrier, -force, np.array(lever) - torque))
        self.again()

    def again(self) -> None:
        """Pushes with the forces that were worked out last."""
        for part, force, torque in self._given:
            part.push(force, torque)
        for one in self._sets.values():
            one.steered = 0.0

    def steer(self, index: int, force: float) -> bool:
        """Turns the wheels of an object as a force across its way would turn it, N, to the left.

        False where it does not stand on wheels, so that the force itself has to act.
        """
        one = self._sets.get(index)
        if one is None or one.footing is None:
            return False
        one.steered += force
        return True

    def look(self) -> None:
        """Sees by the contacts of the last engine step which of them stand on their wheels."""
        compiled, found = self._compiled, {index: [] for index in self._sets}
        count, view = compiled.data.ncon, compiled.contacts
        if count:
            geoms, rows = view.geoms().tolist(), view.numbers[:count]
            frame, place = view.at["frame"], view.at["pos"]
            for (one, two), row in zip(geoms, rows, strict=True):
                if one < 0 or two < 0:
                    continue
                pair = int(compiled.pair_table[one, two])
                normal, spot = row[frame : frame + 3], row[place : place + 3]
                for geom, sign in ((one, -1.0), (two, 1.0)):
                    own = int(compiled.geom_bodies[geom])
                    if pair >= 0 and own in found:
                        found[own].append((pair, sign * normal, spot.copy()))
        for index, one in self._sets.items():
            self._stand(one, found[index])

    def _stand(self, one: Wheelset, touched: list[tuple[int, FloatArray, FloatArray]]) -> None:
        """Notes what one stands on. touched: pair, normal towards it and point of its contacts."""
        up = one.part.rotation() @ one.up
        below = [row for row in touched if float(row[1] @ up) > UPRIGHT]
        below = [row for row in below if float(row[1] @ self._gravity) < 0]
        meets = {pair for pair, _, _ in touched}
        carrying = {pair for pair, _, _ in below}
        # What it will come down upon carries it from the first touch, as long as it is upright.
        upright = -float(up @ self._gravity) > UPRIGHT * float(np.linalg.norm(self._gravity))
        coming = {p for p, (_, _, carries) in one.pairs.items() if carries and p not in meets}
        self._loosen(one, frozenset(carrying | (coming if upright else set())))
        one.footing = None
        if below:
            normal = np.add.reduce([row[1] for row in below])
            spot = np.add.reduce([row[2] for row in below])
            other, friction, _ = one.pairs[below[0][0]]
            carrier = other if other < len(self._parts) else -1
            one.footing = (normal / math.hypot(*normal), spot / len(below), carrier, friction)

    def _loosen(self, one: Wheelset, pairs: frozenset[int]) -> None:
        """Takes the friction from these of its contact pairs and gives it back to the others."""
        table = self._compiled.model.pair_friction
        for pair in pairs - one.loosened:
            table[pair, :2] = 0.0
        for pair in one.loosened - pairs:
            table[pair, :2] = one.pairs[pair][1]
        one.loosened = pairs

    def memory(self) -> list[Any]:
        """What the next control step depends on, as JSON."""
        found: list[Any] = []
        for one in self._sets.values():
            footing = None
            if one.footing is not None:
                normal, spot, carrier, friction = one.footing
                footing = [normal.tolist(), spot.tolist(), carrier, friction]
            found.append([footing, sorted(one.loosened)])
        return found

    def recall(self, memory: list[Any]) -> None:
        """Takes up where `memory` was taken."""
        for one, (footing, loosened) in zip(self._sets.values(), memory, strict=True):
            self._loosen(one, frozenset(loosened))
            one.footing = None
            if footing is not None:
                normal, spot, carrier, friction = footing
                one.footing = (np.array(normal), np.array(spot), carrier, friction)


def wheels_of(program: PhysicalProgram, compiled: Compiled, parts: Sequence[Part]) -> Wheels | None:
    """The wheels of a scene whose numbers are in the model already; None where nothing has any."""
    rolling = any(
        item.wheels is not None and isinstance(part, RigidPart)
        for item, part in zip(program.scene.objects, parts, strict=True)
    )
    return Wheels(program, compiled, parts) if rolling else None
