"""One object of the running engine: read and written as a whole, in the world frame."""

import numpy as np

from physagent_studio.program.rotations import cross, matrix_of, quaternion_of
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.mj import Data, Model
from physagent_studio.simulation.model.model import Compiled, Handle
from physagent_studio.simulation.surfaces import FloatArray

ZERO = np.zeros(3)
"""The vector that is known to be zero."""


class RigidPart:
    """A free rigid body. mass: kg."""

    def __init__(self, model: Model, data: Data, handle: Handle) -> None:
        self.model, self.data, self.handle = model, data, handle
        # Views of the engine's memory, which stays where it is.
        self._place = data.qpos[handle.position : handle.position + 3]
        self._rate = data.qvel[handle.velocity : handle.velocity + 3]
        self._wrench = data.xfrc_applied[handle.body]
        self.mass = float(model.body_mass[handle.body])

    def position(self) -> FloatArray:
        """(3,) m, of the body's origin, a copy."""
        return self._place.copy()

    def rotation(self) -> FloatArray:
        """`R_world_body`, (3, 3)."""
        at = self.handle.position + 3
        return matrix_of(self.data.qpos[at : at + 4].tolist())

    def velocity(self) -> FloatArray:
        """(3,) m/s, a copy."""
        return self._rate.copy()

    def angular(self) -> FloatArray:
        """(3,) rad/s."""
        at = self.handle.velocity + 3
        return self.rotation() @ self.data.qvel[at : at + 3]

    def inertia(self) -> FloatArray:
        """(3, 3) kg·m², about the centre of mass."""
        body = self.handle.body
        turn = self.rotation() @ matrix_of(self.model.body_iquat[body].tolist())
        return turn @ np.diag(self.model.body_inertia[body]) @ turn.T

    def centre(self) -> FloatArray:
        """(3,) m: the centre of mass; its offset from the body's origin is usually zero."""
        return self.position() + self.rotation() @ self.model.body_ipos[self.handle.body]

    def kinetic(self) -> float:
        """J."""
        at, body = self.handle.velocity + 3, self.handle.body
        # In the body frame, as the engine keeps it.
        turning, middle = self.data.qvel[at : at + 3], self.model.body_ipos[body]
        velocity = self.velocity()
        if middle.any():
            velocity += self.rotation() @ cross(turning, middle)
        principal = turning @ matrix_of(self.model.body_iquat[body].tolist())
        inner = float(np.square(principal) @ self.model.body_inertia[body])
        return 0.5 * self.mass * float(velocity @ velocity) + 0.5 * inner

    def set_velocity(self, velocity: FloatArray) -> None:
        """Assigns the linear velocity."""
        at = self.handle.velocity
        self.data.qvel[at : at + 3] = velocity

    def set_angular(self, angular: FloatArray) -> None:
        """Assigns the angular velocity, world, rad/s."""
        # MuJoCo keeps the angular velocity of a free joint in the body frame.
        at = self.handle.velocity + 3
        self.data.qvel[at : at + 3] = self.rotation().T @ angular

    def set_pose(self, position: FloatArray | None, rotation: FloatArray | None) -> None:
        """Places or turns the object; its velocity becomes zero. rotation: wxyz."""
        handle = self.handle
        if position is not None:
            self.data.qpos[handle.position : handle.position + 3] = position
        if rotation is not None:
            self.data.qpos[handle.position + 3 : handle.position + 7] = rotation
        self.data.qvel[handle.velocity : handle.velocity + 6] = 0
        if handle.weld >= 0 and self.data.eq_active[handle.weld]:
            self._anchor()

    def push(self, force: FloatArray, torque: FloatArray) -> None:
        """Adds a force (N) at the centre of mass and a torque (N·m) until the next clearing."""
        self._wrench[:3] += force
        if torque is not ZERO:
            self._wrench[3:] += torque

    def hold(self) -> None:
        """Welds the object to the pose that it has now."""
        self._anchor()
        self.data.qvel[self.handle.velocity : self.handle.velocity + 6] = 0
        self.data.eq_active[self.handle.weld] = 1

    def _anchor(self) -> None:
        at, anchor = self.handle.position, self.handle.anchor
        self.data.mocap_pos[anchor] = self.data.qpos[at : at + 3]
        self.data.mocap_quat[anchor] = self.data.qpos[at + 3 : at + 7]

    def pin(self, point: FloatArray) -> None:
        """Holds a point (3,) of the body frame where it is now; the object may turn about it."""
        self.data.mocap_pos[self.handle.anchor] = self.position() + self.rotation() @ point
        self.place_pin(point)
        self.data.eq_active[self.handle.pin] = 1

    def place_pin(self, point: FloatArray) -> None:
        """Tells the model which point of the body frame is held; not part of the state."""
        self.model.eq_data[self.handle.pin, :6] = (0, 0, 0, *point)

    def release(self) -> None:
        """After `hold` the object starts from rest, after `pin` it keeps its motion."""
        if self.data.eq_active[self.handle.weld]:
            self.data.qvel[self.handle.velocity : self.handle.velocity + 6] = 0
        self.data.eq_active[[self.handle.weld, self.handle.pin]] = 0


class CloudPart:
    """Many nodes that are moved as one: an action on the object is shared out by mass."""

    def __init__(self, model: Model, data: Data, cloud: Cloud, mass: float) -> None:
        self.model, self.data, self.cloud, self.mass = model, data, cloud, mass
        free = cloud.free
        self._q = cloud.position[free][:, None] + np.arange(3)
        self._v = cloud.velocity[free][:, None] + np.arange(3)
        self._bodies = cloud.bodies[free]
        self._masses = mass * cloud.shares[free]

    def _places(self) -> FloatArray:
        return self.cloud.places(self.data.qpos)

    def position(self) -> FloatArray:
        return self.cloud.shares @ self._places()

    def rotation(self) -> FloatArray:
        return self.cloud.pose(self._places())[1]

    def velocity(self) -> FloatArray:
        return self.cloud.shares @ self.cloud.speeds(self.data.qvel)

    def angular(self) -> FloatArray:
        return self.cloud.motion(self._places(), self.cloud.speeds(self.data.qvel))[1]

    def inertia(self) -> FloatArray:
        return self.mass * self.cloud.inertia(self._places())

    def centre(self) -> FloatArray:
        return self.position()

    def kinetic(self) -> float:
        speeds = self.cloud.speeds(self.data.qvel)
        return float(0.5 * self.mass * self.cloud.shares @ np.square(speeds).sum(1))

    def set_velocity(self, velocity: FloatArray) -> None:
        """The whole keeps its turning and its inner motion."""
        self.data.qvel[self._v] += (velocity - self.velocity()) @ self.cloud.axes

    def set_angular(self, angular: FloatArray) -> None:
        """A rigid turning about the centre; the centre keeps its velocity."""
        places = self._places()
        away = (places - self.cloud.shares @ places)[self.cloud.free]
        speeds = self.velocity() + np.cross(angular, away)
        self.data.qvel[self._v] = speeds @ self.cloud.axes
        if self.cloud.whole:
            spins = np.einsum("kji,j->ki", self.cloud.turns(self.data.qpos), angular)
            self.data.qvel[self._v + 3] = spins

    def set_pose(self, position: FloatArray | None, rotation: FloatArray | None) -> None:
        places = self._places()
        centre, turn = self.cloud.pose(places)
        to = centre if position is None else position
        spin = np.eye(3) if rotation is None else matrix_of(rotation.tolist()) @ turn.T
        moved = ((places - centre) @ spin.T + to)[self.cloud.free]
        if self.cloud.whole:
            self.data.qpos[self._q] = moved
            for at, piece in zip(self._q[:, 0], self.cloud.turns(self.data.qpos), strict=True):
                self.data.qpos[at + 3 : at + 7] = quaternion_of(spin @ piece)
            self.data.qvel[self._v + 3] = 0
        else:
            away = moved - self.cloud.rest[self.cloud.free]
            self.data.qpos[self._q] = away @ self.cloud.axes
        self.data.qvel[self._v] = 0

    def push(self, force: FloatArray, torque: FloatArray) -> None:
        shares = self._masses / self._masses.sum()
        forces = shares[:, None] * force
        if torque.any():
            places = self._places()
            away = (places - self.cloud.shares @ places)[self.cloud.free]
            turning = np.linalg.pinv(self.inertia()) @ torque
            forces = forces + self._masses[:, None] * np.cross(turning, away)
        self.data.xfrc_applied[self._bodies, :3] += forces

    def hold(self) -> None:
        """Stops every node; `keep` holds them."""
        self.data.qvel[self._v] = 0

    def keep(self, places: FloatArray) -> None:
        """Puts the free nodes back to places (K', 3) as `kept` gave them."""
        self.data.qpos[self._q] = places
        self.data.qvel[self._v] = 0
        if self.cloud.whole:
            self.data.qvel[self._v + 3] = 0

    def kept(self) -> FloatArray:
        """(K', 3): the raw coordinates of the free nodes now."""
        return self.data.qpos[self._q].copy()

    def release(self) -> None:
        self.data.qvel[self._v] = 0


Part = RigidPart | CloudPart
"""What actions ask of an object and do to it."""


def part_of(compiled: Compiled, handle: Handle | Cloud, density: float) -> Part:
    """The running object behind a handle. density: kg/m³."""
    if isinstance(handle, Handle):
        return RigidPart(compiled.model, compiled.data, handle)
    return CloudPart(compiled.model, compiled.data, handle, handle.volume * density)
