"""`World`: the running engine as actions see it, object by object, in the world frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import matrix_of
from physagent_studio.simulation.disturbance import Drag
from physagent_studio.simulation.mj import Data, mj
from physagent_studio.simulation.model import Compiled, Handle
from physagent_studio.simulation.surfaces import FloatArray
from physagent_studio.simulation.vectors import support_centre

IMPACT = 50.0
"""Accelerations above this many g are impacts; they are not extrapolated over half a step."""

DRAG = {"sphere": 0.47, "ellipsoid": 0.5, "box": 1.05, "cylinder": 1.0, "capsule": 0.8}
"""Drag coefficients at everyday Reynolds numbers (Hoerner 1965); 1.0 for other shapes."""


@dataclass(eq=False, slots=True)
class World:
    """Reads and writes the state of single objects.

    step: the control step that comes next. kicks: (step, object, velocity that was held back).

    dt: engine step, s. names: index of each object. bodies: the same, supports after objects.
    """

    program: PhysicalProgram
    compiled: Compiled
    dt: float
    names: dict[str, int]
    bodies: dict[str, int]
    step: int = 0
    kicks: list[tuple[int, int, FloatArray]] = field(default_factory=list)

    def handle(self, name: str) -> Handle:
        """The rigid body of that name."""
        return self.compiled.handles[self.names[name]]

    @property
    def step_seconds(self) -> float:
        """Length of a control step, s."""
        return self.program.clip.step_seconds

    @property
    def data(self) -> Data:
        """MuJoCo's state."""
        return self.compiled.data

    def mass(self, name: str) -> float:
        """kg."""
        return float(self.compiled.model.body_mass[self.handle(name).body])

    def position(self, name: str) -> FloatArray:
        """(3,) m, a copy."""
        at = self.handle(name).position
        return self.data.qpos[at : at + 3].copy()

    def rotation(self, name: str) -> FloatArray:
        """`R_world_body`, (3, 3)."""
        at = self.handle(name).position + 3
        return matrix_of(self.data.qpos[at : at + 4].tolist())

    def velocity(self, name: str) -> FloatArray:
        """(3,) m/s, world, a copy."""
        at = self.handle(name).velocity
        return self.data.qvel[at : at + 3].copy()

    def angular(self, name: str) -> FloatArray:
        """(3,) rad/s, world."""
        at = self.handle(name).velocity + 3
        return self.rotation(name) @ self.data.qvel[at : at + 3]

    def inertia(self, name: str) -> FloatArray:
        """(3, 3) kg·m², world axes, about the centre of mass."""
        body = self.handle(name).body
        model = self.compiled.model
        turn = self.rotation(name) @ matrix_of(model.body_iquat[body].tolist())
        return turn @ np.diag(model.body_inertia[body]) @ turn.T

    def kinetic(self, name: str) -> float:
        """J."""
        w = self.angular(name)
        v = self.velocity(name) + np.cross(w, self.centre(name) - self.position(name))
        return float(0.5 * self.mass(name) * v @ v + 0.5 * w @ self.inertia(name) @ w)

    def set_velocity(self, name: str, velocity: FloatArray) -> None:
        """Assigns the linear velocity.

        The engine moves a body with the velocity at the end of each step, an error of a·dt²/2
        per step; starting half a step of acceleration behind cancels it for good.
        """
        at = self.handle(name).velocity
        self.data.qvel[at : at + 3] = velocity
        self.half_kick(name)

    def half_kick(self, name: str) -> None:
        """Takes half a step of the present acceleration off the linear velocity."""
        mj.mj_forward(self.compiled.model, self.data)
        at = self.handle(name).velocity
        acceleration = self.data.qacc[at : at + 3]
        limit = IMPACT * max(9.81, float(np.linalg.norm(self.program.scene.gravity)))
        if np.linalg.norm(acceleration) < limit:
            kick = acceleration * self.dt / 2
            self.data.qvel[at : at + 3] -= kick
            self.kicks.append((self.step, self.names[name], kick))

    def set_angular(self, name: str, angular: FloatArray) -> None:
        """Assigns the angular velocity, world, rad/s (MuJoCo keeps it in the body frame)."""
        at = self.handle(name).velocity + 3
        self.data.qvel[at : at + 3] = self.rotation(name).T @ angular

    def set_pose(
        self, name: str, position: FloatArray | None = None, rotation: FloatArray | None = None
    ) -> None:
        """Places or turns the object; its velocity becomes zero. rotation: wxyz."""
        handle = self.handle(name)
        if position is not None:
            self.data.qpos[handle.position : handle.position + 3] = position
        if rotation is not None:
            self.data.qpos[handle.position + 3 : handle.position + 7] = rotation
        self.data.qvel[handle.velocity : handle.velocity + 6] = 0
        if handle.weld >= 0 and self.data.eq_active[handle.weld]:
            self._anchor(handle)
        self.half_kick(name)

    def hold(self, name: str) -> None:
        """Welds the object to the pose that it has now."""
        handle = self.handle(name)
        self._anchor(handle)
        self.data.qvel[handle.velocity : handle.velocity + 6] = 0
        self.data.eq_active[handle.weld] = 1

    def pin(self, name: str, point: FloatArray) -> None:
        """Holds a point (3,) of the body frame where it is now; the object may turn about it."""
        handle = self.handle(name)
        self.data.mocap_pos[handle.anchor] = self.position(name) + self.rotation(name) @ point
        self.place_pin(name, point)
        self.data.eq_active[handle.pin] = 1

    def place_pin(self, name: str, point: FloatArray) -> None:
        """Tells the model which point of the body frame is held; not part of the state."""
        self.compiled.model.eq_data[self.handle(name).pin, :6] = (0, 0, 0, *point)

    def release(self, name: str) -> None:
        """Ends `hold`, and the object starts from rest, or `pin`, and it keeps its motion."""
        handle = self.handle(name)
        if self.data.eq_active[handle.weld]:
            self.data.qvel[handle.velocity : handle.velocity + 6] = 0
        self.data.eq_active[[handle.weld, handle.pin]] = 0
        self.half_kick(name)

    def _anchor(self, handle: Handle) -> None:
        at = handle.position
        self.data.mocap_pos[handle.anchor] = self.data.qpos[at : at + 3]
        self.data.mocap_quat[handle.anchor] = self.data.qpos[at + 3 : at + 7]

    def push(self, name: str, force: FloatArray, torque: FloatArray) -> None:
        """Adds a force (N) at the centre of mass and a torque (N·m) until the next clearing."""
        wrench = self.data.xfrc_applied[self.handle(name).body]
        wrench[:3] += force
        wrench[3:] += torque

    def place(self, name: str, near: FloatArray) -> FloatArray:
        """(3,) m: where an object, a support or a landmark is, seen from `near`."""
        if name in self.names:
            return self.position(name)
        scene = self.program.scene
        landmark = scene.landmark(name)
        if landmark is not None and landmark.points:
            return np.mean(np.array(landmark.points, float), axis=0)
        support = scene.support(name)
        assert support is not None
        assert support.shape is not None
        return support_centre(support.shape, near)

    def centre(self, name: str) -> FloatArray:
        """(3,) m: the centre of mass; its offset from the body's origin is usually zero."""
        offset = self.compiled.model.body_ipos[self.handle(name).body]
        return self.position(name) + self.rotation(name) @ offset

    def energy(self, name: str) -> float:
        """Kinetic and potential energy, J."""
        lift = self.centre(name) @ np.array(self.program.scene.gravity)
        return self.kinetic(name) - self.mass(name) * float(lift)

    def drag(self, name: str) -> Drag:
        """How the object catches the wind now."""
        solid = self.compiled.solids[self.names[name]]
        coefficient = DRAG.get(solid.kind, 1.0)
        return Drag(coefficient, self.rotation(name), solid.shadows)
