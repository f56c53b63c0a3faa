"""One object over a window of steps, what measuring a statement gives, and flat outlines."""

from collections.abc import Sequence
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


LIMIT = 100.0
"""Margins are kept within ± this, so that a sum of them stays meaningful."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The plain (not negated) statement, measured.

    margin: signed, ≥ 0 holds. op: how `value` must compare with `threshold`; "" where the
    statement is a yes or no. step: when it was decided (became true, or failed). note: what an
    English reader wants beside it. lasting: the verdict speaks of the end of the window, so a
    run that ended early cannot give it. measurable: False when there was nothing to measure.
    claim: the statement's words where they depend on what was measured.
    """

    margin: float
    value: float | None = None
    threshold: float | None = None
    unit: str = ""
    op: str = ""
    step: int | None = None
    note: str = ""
    claim: str = ""
    lasting: bool = False
    measurable: bool = True

    @property
    def holds(self) -> bool:
        """Whether the plain statement is true."""
        return self.margin >= 0


def unmeasurable(reason: str) -> Outcome:
    """Nothing could be measured: the statement fails, and its opposite as well."""
    return Outcome(margin=-1.0, note=reason, measurable=False)


def bounded(margin: float) -> float:
    """The margin within ± `LIMIT`."""
    return float(max(-LIMIT, min(LIMIT, margin)))


def opposite(margin: float) -> float:
    """The margin of the opposite; a statement that just holds leaves its opposite just failed."""
    return -margin if margin != 0 else -1e-9


def excess(value: float, threshold: float) -> float:
    """Margin of value ≥ threshold, relative to the threshold."""
    return bounded((value - threshold) / max(abs(threshold), 1e-3))


def shortfall(value: float, threshold: float) -> float:
    """Margin of value ≤ threshold, relative to the threshold."""
    return bounded((threshold - value) / max(abs(threshold), 1e-3))


def slowness(value: float, threshold: float) -> float:
    """Margin of value ≤ threshold for speeds over many scales, within −1 … 1."""
    total = value + threshold
    return (threshold - value) / total if total > 0 else 1.0


def worst(outcomes: Sequence[Outcome]) -> Outcome:
    """The one with the least margin, the first of equals."""
    return min(outcomes, key=lambda one: one.margin)


def in_order(outline: FloatArray) -> FloatArray:
    """A quadrilateral's corners in order round it, however they were clicked."""
    if len(outline) != 4:
        return outline
    off = outline - outline.mean(axis=0)
    return outline[np.argsort(np.arctan2(off[:, 1], off[:, 0]))]


def inside_depth(points: FloatArray, outline: FloatArray) -> FloatArray:
    """(T,) signed distance of points (T, 2) to a simple polygon (K, 2), positive inside, m."""
    start, end = outline, np.roll(outline, -1, axis=0)
    along = end - start
    to_point = points[:, None] - start
    square = np.maximum(np.sum(along**2, -1), 1e-12)
    share = np.clip(np.sum(to_point * along, -1) / square, 0, 1)
    distance = np.linalg.norm(to_point - share[..., None] * along, axis=-1).min(axis=1)
    y = points[:, 1:2]
    spans = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(np.abs(along[:, 1]) < 1e-12, 1e-12, along[:, 1])
    crossing = start[:, 0] + (y - start[:, 1]) / rise * along[:, 0]
    inside = (spans & (points[:, :1] < crossing)).sum(axis=1) % 2 == 1
    return np.where(inside, distance, -distance)
