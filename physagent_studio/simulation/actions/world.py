"""`World`: the running engine as actions see it, object by object, in the world frame."""

import math
from dataclasses import dataclass, field

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.bodies import FLUTTER
from physagent_studio.program.scene.plants import FOLIAGE
from physagent_studio.simulation.actions.disturbance import Drag
from physagent_studio.simulation.actions.vectors import support_centre
from physagent_studio.simulation.contacts.wheels import Wheels
from physagent_studio.simulation.mj import Data, mj
from physagent_studio.simulation.model.model import Compiled
from physagent_studio.simulation.model.parts import Part, RigidPart
from physagent_studio.simulation.surfaces import FloatArray

IMPACT = 50.0
"""Accelerations above this many g are impacts; they are not extrapolated over half a step."""

DRAG = {"sphere": 0.47, "ellipsoid": 0.5, "box": 1.05, "cylinder": 1.0, "capsule": 0.8}
"""Drag coefficients at everyday Reynolds numbers (Hoerner 1965); 1.0 for other shapes."""

CROWN = 0.8
"""The same for the outline of a plant in light air, see `disturbance.LEAVES`."""


@dataclass(eq=False, slots=True)
class World:
    """Reads and writes the state of single objects.

    parts: the objects. dt: engine step, s. names: index of each object. bodies: the same,
    supports after objects. skins: (V, 3) m, world, first places of the vertices of what is
    not rigid. wheels: what is on wheels, None where nothing is. step: the control step that comes
    next. kicks: (step, object, velocity that was held back). falls: (N,) 1 for what has its
    weight, 0 for what floats.
    """

    program: PhysicalProgram
    compiled: Compiled
    parts: tuple[Part, ...]
    dt: float
    names: dict[str, int]
    bodies: dict[str, int]
    skins: dict[str, FloatArray]
    wheels: Wheels | None = None
    step: int = 0
    kicks: list[tuple[int, int, FloatArray]] = field(default_factory=list)
    falls: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        objects = self.program.scene.objects
        self.falls = np.array([float(one.aloft != "floats") for one in objects])

    def part(self, name: str) -> Part:
        """The object of that name."""
        return self.parts[self.names[name]]

    @property
    def step_seconds(self) -> float:
        """Length of a control step, s."""
        return self.program.clip.step_seconds

    @property
    def data(self) -> Data:
        """MuJoCo's state."""
        return self.compiled.data

    def set_velocity(self, name: str, velocity: FloatArray) -> None:
        """Assigns the linear velocity."""
        self.part(name).set_velocity(velocity)
        self.half_kick(name)

    def half_kick(self, name: str) -> None:
        """Takes half a step of the present acceleration off the linear velocity.

        The engine moves a body with the velocity at the end of each step, an error of a·dt²/2
        per step; starting half a step of acceleration behind cancels it for good. Deformables
        damp more than that and go without.
        """
        part = self.part(name)
        if not isinstance(part, RigidPart):
            return
        mj.mj_forward(self.compiled.model, self.data)
        at = part.handle.velocity
        acceleration = self.data.qacc[at : at + 3]
        limit = IMPACT * max(9.81, math.hypot(*self.program.scene.gravity))
        if math.hypot(*acceleration.tolist()) < limit:
            kick = acceleration * self.dt / 2
            self.data.qvel[at : at + 3] -= kick
            self.kicks.append((self.step, self.names[name], kick))

    def set_pose(
        self, name: str, position: FloatArray | None = None, rotation: FloatArray | None = None
    ) -> None:
        """Places or turns the object; its velocity becomes zero. rotation: wxyz."""
        self.part(name).set_pose(position, rotation)
        self.half_kick(name)

    def release(self, name: str) -> None:
        """Ends `hold` or `pin`."""
        self.part(name).release()
        self.half_kick(name)

    def place(self, name: str, near: FloatArray) -> FloatArray:
        """(3,) m: where an object, a support or a landmark is, seen from `near`."""
        if name in self.names:
            return self.part(name).position()
        scene = self.program.scene
        landmark = scene.landmark(name)
        if landmark is not None and landmark.points:
            return np.mean(np.array(landmark.points, float), axis=0)
        support = scene.support(name)
        assert support is not None
        assert support.shape is not None
        return support_centre(support.shape, near)

    def energy(self, name: str) -> float:
        """Kinetic and potential energy, J."""
        part = self.part(name)
        lift = part.centre() @ np.array(self.program.scene.gravity)
        return part.kinetic() - part.mass * float(self.falls[self.names[name]] * lift)

    def drag(self, name: str) -> Drag:
        """How the object catches the wind now."""
        index = self.names[name]
        solid, turn = self.compiled.solids[index], self.part(name).rotation()
        item = self.program.scene.objects[index]
        if item.material == FOLIAGE:
            return Drag(CROWN, turn, solid.shadows, leafy=True)
        shadows = solid.shadows
        if item.body.kind == "cloth":
            shadows = np.maximum(shadows, FLUTTER * shadows.max())
        return Drag(DRAG.get(solid.kind, 1.0), turn, shadows)
