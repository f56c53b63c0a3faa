"""A program and its rollout, as the measures ask for them: tracks, touches, tilts, windows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.contract.track import Track, Window
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.shapes import (
    Outline,
    Placed,
    gap,
    outline_of,
    place_object,
    place_support,
)
from physagent_studio.records.rollout import Rollout

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Facts:
    """A program with its rollout. `last` is the last step with finite numbers before any blow-up.

    The cache holds per-pair contact masks and per-shape outlines of this one rollout.
    """

    program: PhysicalProgram
    rollout: Rollout
    last: int
    _cache: dict[object, object] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, program: PhysicalProgram, rollout: Rollout) -> Facts:
        """Facts up to the last step that can be trusted."""
        arrays = (rollout.positions, rollout.rotations, rollout.velocities, rollout.angular)
        columns = [one.reshape(len(one), -1) for one in (*arrays, rollout.kinetic)]
        finite = np.asarray(np.isfinite(np.concatenate(columns, axis=1)).all(axis=1))
        last = rollout.steps if finite.all() else max(int(np.argmin(finite)) - 1, 0)
        if rollout.blown_up is not None:
            last = min(last, max(rollout.blown_up.step - 1, 0))
        return cls(program, rollout, last)

    def cached(self, key: object, make: Callable[[], T]) -> T:
        """The value of `make`, computed once per key."""
        if key not in self._cache:
            self._cache[key] = make()
        return self._cache[key]  # type: ignore[return-value]

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return self.rollout.blown_up is None and self.last == self.rollout.steps

    @property
    def dt(self) -> float:
        """Seconds per control step."""
        return self.rollout.step_seconds

    def window(self, from_step: int | None, to_step: int | None) -> Window | None:
        """The steps of a statement's window that the run covers, or None if it covers none."""
        first = from_step or 0
        last = self.last if to_step is None else min(to_step, self.last)
        return Window(first, last) if first <= last else None

    def whole(self) -> Window:
        """Every step that can be trusted."""
        return Window(0, self.last)

    def is_object(self, name: str) -> bool:
        """Whether the rollout has an object of that name."""
        return name in self.rollout.objects

    def outline(self, name: str) -> Outline:
        """The outline of an object; a point where its shape is open."""
        item = self.program.scene.object(name)
        shape = item.shape if item is not None else None
        if shape is None:
            return Outline(is_ball=True, exact=False, rounding=0.05)
        return self.cached(("outline", name), lambda: outline_of(shape))

    def track(self, name: str, window: Window) -> Track:
        """One object over a window."""
        index, rows = self.rollout.objects.index(name), window.rows
        run = self.rollout
        return Track(
            name=name,
            window=window,
            dt=run.step_seconds,
            outline=self.outline(name),
            positions=run.positions[rows, index],
            rotations=run.rotations[rows, index],
            velocities=run.velocities[rows, index],
            angular=run.angular[rows, index],
            rest_rotation=run.rotations[0, index],
        )

    def placed(self, name: str, window: Window) -> Placed | None:
        """An object over the window or a support; None where its shape is open."""
        if self.is_object(name):
            return self.track(name, window).placed
        support = self.program.scene.support(name)
        if support is None or support.shape is None:
            return None
        return place_support(support.shape)

    def placed_at_start(self, name: str, step: int) -> Placed | None:
        """A support, or an object as it is at one step."""
        item = self.program.scene.object(name)
        if item is not None and item.shape is not None and self.is_object(name):
            index = self.rollout.objects.index(name)
            run = self.rollout
            return place_object(item.shape, run.positions[step, index], run.rotations[step, index])
        return self.placed(name, Window(step, step))

    # --- contacts ----------------------------------------------------------------------------

    def pair(self, first: str, second: str) -> NDArray[np.void]:
        """Contact rows between two bodies, sorted by step."""
        return self.cached(("pair", first, second), lambda: self._pair(first, second))

    def _pair(self, first: str, second: str) -> NDArray[np.void]:
        bodies, rows = self.rollout.bodies, self.rollout.contacts
        if first not in bodies or second not in bodies:
            return rows[:0]
        a, b = bodies.index(first), bodies.index(second)
        forward = (rows["a"] == a) & (rows["b"] == b)
        return rows[(forward | ((rows["a"] == b) & (rows["b"] == a))) & (rows["step"] <= self.last)]

    def touching(self, first: str, second: str, window: Window) -> BoolArray:
        """(W,) whether two bodies touch on each step of a window."""
        return self._mask(self.pair(first, second)["step"], window)

    def touching_anything(self, name: str, window: Window) -> BoolArray:
        """(W,) whether a body touches anything at all."""
        index, rows = self.rollout.index(name), self.rollout.contacts
        mine = (rows["a"] == index) | (rows["b"] == index)
        return self._mask(rows["step"][mine], window)

    def carried(self, name: str, by: str, window: Window) -> BoolArray:
        """(W,) whether `by` carries the object: they touch, and the push on it points up."""
        bodies = self.rollout.bodies
        if name not in bodies or by not in bodies:
            return self._mask(np.zeros(0, np.int64), window)
        rows = self.cached("carriers", self.rollout.carriers)
        mine = (rows[:, 1] == bodies.index(name)) & (rows[:, 2] == bodies.index(by))
        return self._mask(rows[mine & (rows[:, 0] <= self.last), 0], window)

    def _mask(self, steps: NDArray[np.signedinteger], window: Window) -> BoolArray:
        """(W,) which steps of the window are among `steps`.

        The last row of a rollout is a state and no step; it counts as the step before it.
        """
        mask = np.zeros(len(window), bool)
        inside = (steps >= window.first) & (steps <= window.last)
        mask[steps[inside] - window.first] = True
        if window.last == self.rollout.steps and len(mask) > 1:
            mask[-1] |= mask[-2]
        return mask

    def is_clear(self, name: str, window: Window) -> BoolArray:
        """(W,) whether an object is visibly free of all other bodies.

        Where only the outline's size is known, gaps are taken from what they are in contact.
        """
        track = self.track(name, window)
        free = np.ones(len(window), bool)
        for other in self.rollout.bodies:
            placed = self.placed(other, window) if other != name else None
            if placed is None:
                continue
            rows = np.nonzero(free & _may_touch(track.placed, placed, track.clear))[0]
            gaps = gap(track.placed.at(rows), placed.at(rows)) if len(rows) else np.zeros(0)
            touching = self.touching(name, other, window)[rows]
            if touching.any() and not track.outline.exact:
                gaps = gaps - np.median(gaps[touching])
            free[rows] &= gaps > track.clear
        return free

    def gaps(self, subject: str, other: str, window: Window) -> FloatArray | None:
        """(W,) distance of two bodies' surfaces at each step, m; None where a shape is open."""
        second = self.placed(other, window)
        if second is None:
            return None
        first = self.track(subject, window).placed

        def measure() -> FloatArray:
            return _coarse_gaps(first, second, len(window))

        return self.cached(("gap", subject, other, window), measure)

    def acted_on(self, name: str, operators: tuple[str, ...] = ()) -> BoolArray:
        """(S + 1,) whether an action (of these operators, or any) acts on the object."""
        acted = np.zeros(self.rollout.steps + 1, bool)
        for span in self.rollout.spans:
            action = self.program.action(span.id)
            if action is None or action.name != name or span.start is None:
                continue
            if not operators or action.operator in operators:
                end = self.rollout.steps if span.end is None else span.end
                acted[span.start : end + 1] = True
        return acted


def _may_touch(first: Placed, second: Placed, slack: float) -> BoolArray:
    """(T,) whether the balls round two bodies come within `slack` of each other."""
    if first.outline is None or second.outline is None:
        return np.ones(max(len(first.positions), len(second.positions)), bool)
    between = first.positions + _offset(first) - second.positions - _offset(second)
    apart = np.linalg.norm(between, axis=-1)
    return apart < first.outline.radius + second.outline.radius + slack


def _offset(body: Placed) -> FloatArray:
    """(T, 3) from a body's origin to the middle of its bounding box, world, m."""
    assert body.outline is not None
    return body.matrices @ body.outline.bounds.mean(axis=0)


def _coarse_gaps(first: Placed, second: Placed, count: int) -> FloatArray:
    """Gaps at every fourth step and around the nearest, straight lines in between."""
    if first.half_space is not None or second.half_space is not None:
        return np.broadcast_to(gap(first, second), (count,)).copy()
    rows = np.unique(np.append(np.arange(0, count, 4), count - 1))
    coarse = gap(first.at(rows), second.at(rows))
    nearest = int(rows[coarse.argmin()])
    near = np.arange(max(0, nearest - 4), min(count, nearest + 5))
    values = np.interp(np.arange(count), rows, coarse)
    values[near] = gap(first.at(near), second.at(near))
    return values
