"""One object over a window of steps: its path, speed and tilt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import matrices_of
from physagent_studio.program.scene.shapes import Outline, Placed

CLEAR, CLEAR_SHARE = 1e-3, 0.02
"""What is free of another body is this far from it, m, or this part of its own smallest extent.
Below that a rolling ball trembles."""


@dataclass(frozen=True, slots=True)
class Window:
    """Control steps first … last, both inclusive."""

    first: int
    last: int

    @property
    def rows(self) -> slice:
        """The rows of the rollout's arrays."""
        return slice(self.first, self.last + 1)

    def __len__(self) -> int:
        return self.last - self.first + 1


@dataclass(frozen=True, eq=False, slots=True)
class Track:
    """One object over a window of W steps.

    positions (W, 3), rotations (W, 4), velocities (W, 3), angular (W, 3); rest_rotation (4,) is
    its pose at step 0, which tilt refers to.
    """

    name: str
    window: Window
    dt: float
    outline: Outline
    positions: FloatArray
    rotations: FloatArray
    velocities: FloatArray
    angular: FloatArray
    rest_rotation: FloatArray

    @property
    def size(self) -> float:
        """Characteristic size: mean edge of the bounding box, m."""
        return float(self.outline.size.mean())

    @property
    def clear(self) -> float:
        """Gap from which on it is visibly free of another body, m."""
        return max(CLEAR, CLEAR_SHARE * float(self.outline.size.min()))

    @property
    def speed(self) -> FloatArray:
        """(W,) speed of the centre of mass, m/s."""
        return np.linalg.norm(self.velocities, axis=-1)

    @property
    def bustle(self) -> FloatArray:
        """(W,) speed of the centre or, for a spin, of a point halfway out, m/s."""
        spin = np.linalg.norm(self.angular, axis=-1) * self.outline.radius / 2
        return np.maximum(self.speed, spin)

    def final_bustle(self) -> float:
        """Mean of `bustle` over the last twentieth of a second, m/s."""
        count = max(1, round(0.05 / self.dt))
        return float(self.bustle[-count:].mean())

    @property
    def placed(self) -> Placed:
        """Its outline over the window."""
        return Placed(self.outline, positions=self.positions, matrices=matrices_of(self.rotations))

    def tilt(self, since_start: bool = False) -> FloatArray:
        """(W,) degrees between its up axis and the vertical; turns about the vertical are none.

        The up axis is the body axis that pointed up at step 0, or, with `since_start`, when the
        window began. A ball has none (always 0), and a
        body of revolution tilts only as its axis of symmetry does: a can rolling on its side
        does not.
        """
        if self.outline.is_ball:
            return np.zeros(len(self.positions))
        matrices = matrices_of(self.rotations)
        first = matrices[0] if since_start else matrices_of(self.rest_rotation[None])[0]
        if self.outline.axis is not None:
            axis = np.array(self.outline.axis)
            now = np.degrees(np.arccos(np.clip(matrices[:, 2] @ axis, -1, 1)))
            then = np.degrees(np.arccos(np.clip(first[2] @ axis, -1, 1)))
            return np.abs(now - then)
        up = first.T @ np.array([0.0, 0.0, 1.0])
        return np.degrees(np.arccos(np.clip((matrices @ up)[:, 2], -1, 1)))

    def first(self, condition: BoolArray) -> int | None:
        """The step at which a per-step condition (W,) is first true."""
        return self.window.first + int(np.argmax(condition)) if condition.any() else None
