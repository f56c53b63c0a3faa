"""The nine operators at run time, by the class of their action."""

import numpy as np

from physagent_studio.program import actions
from physagent_studio.simulation.actions import pushes
from physagent_studio.simulation.actions.effect import Effect, plain_vector
from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.model.parts import ZERO, CloudPart, RigidPart
from physagent_studio.simulation.surfaces import FloatArray


class _AtOnce(Effect):
    """Does everything at its begin."""

    @property
    def acts(self) -> bool:
        return False

    def act(self, world: World, time: float) -> None:
        pass


class _SetVelocity(_AtOnce):
    action: actions.SetVelocity

    def begin(self, world: World) -> None:
        before = world.part(self.name).kinetic()
        world.set_velocity(self.name, plain_vector(world, self.name, self.action.velocity))
        self.work = world.part(self.name).kinetic() - before


class _SetAngularVelocity(Effect):
    @property
    def each_substep(self) -> bool:
        return True

    kept = ("work", "_angular")
    action: actions.SetAngularVelocity

    def __init__(self, action: actions.SetAngularVelocity) -> None:
        super().__init__(action)
        self._angular = ZERO

    def begin(self, world: World) -> None:
        self._angular = plain_vector(world, self.name, self.action.angular_velocity)

    def act(self, world: World, time: float) -> None:
        before = world.part(self.name).kinetic()
        world.part(self.name).set_angular(self._angular)
        self.work += world.part(self.name).kinetic() - before


class _SetPosition(_AtOnce):
    action: actions.SetPosition

    def begin(self, world: World) -> None:
        before = world.energy(self.name)
        world.set_pose(self.name, position=np.array(self.action.position, float))
        self.work = world.energy(self.name) - before


class _SetOrientation(_AtOnce):
    action: actions.SetOrientation

    def begin(self, world: World) -> None:
        before = world.energy(self.name)
        world.set_pose(self.name, rotation=np.array(self.action.rotation, float))
        self.work = world.energy(self.name) - before


class _FixObject(Effect):
    kept = ("work", "_point", "_places")
    action: actions.FixObject

    def __init__(self, action: actions.FixObject) -> None:
        super().__init__(action)
        self._point: FloatArray | None = None
        self._places: FloatArray | None = None

    @property
    def acts(self) -> bool:
        """Only nodes need it, see `each_substep`."""
        return self._places is not None

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


class Hanging(_FixObject):
    """Keeps a thing that hangs: rigid, by a point straight above its middle, so that it swings
    when it is struck; anything else as it is. thread: how far above, m; None for its own end.
    """

    def __init__(self, action: actions.FixObject, thread: float | None = None) -> None:
        super().__init__(action)
        self._thread = thread

    def begin(self, world: World) -> None:
        part = world.part(self.name)
        if isinstance(part, RigidPart):
            own = float(world.compiled.solids[world.names[self.name]].extent.max()) / 2
            reach = own if self._thread is None else self._thread
            above = part.centre() + np.array([0.0, 0.0, reach])
            self._point = part.rotation().T @ (above - part.position())
            part.pin(self._point)
            return
        super().begin(world)


EFFECTS: dict[type, type[Effect]] = {
    actions.SetVelocity: _SetVelocity,
    actions.SetAngularVelocity: _SetAngularVelocity,
    actions.ApplyForce: pushes.ApplyForceEffect,
    actions.ApplyTorque: pushes.ApplyTorqueEffect,
    actions.ApplyAngledForce: pushes.ApplyAngledForceEffect,
    actions.ApplyDisturbance: pushes.ApplyDisturbanceEffect,
    actions.SetPosition: _SetPosition,
    actions.SetOrientation: _SetOrientation,
    actions.FixObject: _FixObject,
}
