"""Objects that are many small bodies: deformables by their nodes, grains, and cut pieces.

The object's pose is that of its nodes as a whole: the centre of mass, and the rotation that fits
the nodes' present places best to their first ones.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from physagent_studio.program.rotations import matrices_of, quaternion_of
from physagent_studio.simulation.surfaces import FloatArray

STIFFENING = 1e-3
"""Share of the nodes' spread that pulls the fitted rotation to none: a line has no twist."""


@dataclass(frozen=True, eq=False, slots=True)
class Cloud:
    """Where a many-bodied object lives in the model.

    bodies: (K,) MuJoCo body ids, of the parent where a node is pinned. position, velocity: (K,)
    first address in `qpos` and `qvel`, −1 where pinned. rest: (K, 3) m, world, first places.
    shares: (K,) of the mass, sum 1. volume: m³ that weigh. axes: (3, 3) world directions of the
    nodes' coordinates as columns. whole: whether nodes turn (free joints); their `qpos` is a
    place then, and a displacement along `axes` otherwise. turn: R_world_body at first, (3, 3).
    joints: equality ids that join pieces, (J,), and the two pieces of each, (J, 2).
    """

    bodies: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    rest: FloatArray
    shares: FloatArray
    turn: FloatArray
    volume: float = 0.0
    axes: FloatArray = field(default_factory=lambda: np.eye(3))
    whole: bool = False
    joints: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    joined: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int64))

    @property
    def free(self) -> np.ndarray:
        """(K,) bool: nodes that are not pinned."""
        return self.position >= 0

    @property
    def start(self) -> FloatArray:
        """(3,) m: the first centre of mass."""
        return self.shares @ self.rest

    def places(self, qpos: FloatArray) -> FloatArray:
        """(..., K, 3) m, world: node positions of raw states (..., nq)."""
        at = np.maximum(self.position, 0)[:, None] + np.arange(3)
        moved = qpos[..., at] if self.whole else qpos[..., at] @ self.axes.T + self.rest
        return np.where(self.free[:, None], moved, self.rest)

    def speeds(self, qvel: FloatArray) -> FloatArray:
        """(..., K, 3) m/s, world: node velocities of raw velocities (..., nv)."""
        at = np.maximum(self.velocity, 0)[:, None] + np.arange(3)
        return np.where(self.free[:, None], qvel[..., at] @ self.axes.T, 0.0)

    def turns(self, qpos: FloatArray) -> FloatArray:
        """(..., K, 3, 3) rotation of each piece; only for pieces with free joints."""
        at = self.position[:, None] + np.arange(3, 7)
        return matrices_of(qpos[..., at])

    def pose(self, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Centres (..., 3) and `R_world_body` (..., 3, 3) of node places (..., K, 3)."""
        centre = np.einsum("k,...ki->...i", self.shares, places)
        away, first = places - centre[..., None, :], self.rest - self.start
        moment = np.einsum("k,...ki,kj->...ij", self.shares, away, first)
        spread = float(self.shares @ np.square(first).sum(1))
        u, _, vt = np.linalg.svd(moment + STIFFENING * max(spread, 1e-12) * np.eye(3))
        sign = np.ones((*u.shape[:-2], 3))
        sign[..., 2] = np.sign(np.linalg.det(u @ vt))
        return centre, (u * sign[..., None, :]) @ vt @ self.turn

    def motion(self, places: FloatArray, speeds: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Velocity of the centre and angular velocity (..., 3): mean motion of the nodes."""
        centre = np.einsum("k,...ki->...i", self.shares, places)
        mean = np.einsum("k,...ki->...i", self.shares, speeds)
        away = places - centre[..., None, :]
        spin = np.einsum("k,...ki->...i", self.shares, np.cross(away, speeds))
        moment = np.einsum("k,...ki,...kj->...ij", self.shares, away, away)
        trace = np.trace(moment, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
        return mean, np.einsum("...ij,...j->...i", np.linalg.pinv(trace - moment), spin)

    def inertia(self, places: FloatArray) -> FloatArray:
        """(3, 3) m²: inertia of the nodes about their centre per kg of the whole."""
        away = places - self.shares @ places
        moment = np.einsum("k,ki,kj->ij", self.shares, away, away)
        return np.trace(moment) * np.eye(3) - moment


def quaternions_of(matrices: FloatArray) -> FloatArray:
    """Unit quaternions (T, 4) of rotations (T, 3, 3), without sign jumps along T."""
    rows = np.array([quaternion_of(matrix) for matrix in matrices])
    for before, row in pairwise(rows):
        if before @ row < 0:
            row *= -1
    return rows
