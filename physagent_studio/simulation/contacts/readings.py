"""Readings of the engine's contacts during a run, kept in tables that grow."""

from bisect import bisect_left
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from physagent_studio.simulation.mj import Data
from physagent_studio.simulation.model.contact_view import ContactView
from physagent_studio.simulation.surfaces import FloatArray, IntArray

NONE = -(1 << 60)
"""Where the forces of a reading begin that has none."""

Mark = tuple[int, int, int, int]
"""Lengths of tables, see `Readings.mark`."""

T = TypeVar("T", np.float64, np.int32)


class Readings:
    """Contacts at chosen engine steps, one row each, and the forces of the constraint solver.

    ticks: engine step of each reading; counts: how many contacts it has. starts: where its
    forces begin, for the readings with contacts.
    """

    def __init__(self, view: ContactView) -> None:
        self._view = view
        self.ticks: list[int] = []
        self.counts: list[int] = []
        self.starts: list[int] = []
        self._numbers: FloatArray = np.empty((0, 0))
        self._integers: IntArray = np.empty((0, 0), np.int32)
        self._forces: FloatArray = np.empty(0)
        self._end = self._stop = 0

    def add(self, data: Data, count: int, tick: int, forces: bool) -> None:
        """Takes down all contacts there are now, `count`. forces: whether the solver's too."""
        if count:
            view, start = self._view, self._end
            end = start + count
            if end > len(self._numbers):
                view.bind()
                self._room(count)
            self._numbers[start:end] = view.numbers[:count]
            self._integers[start:end] = view.integers[:count]
            self._end = end
            if forces:
                self._add_forces(data)
            else:
                self.starts.append(NONE)
        self.ticks.append(tick)
        self.counts.append(count)

    def add_apart(
        self, tick: int, geoms: tuple[int, int], gap: float, point: FloatArray, normal: FloatArray
    ) -> None:
        """Takes down a pair that has come apart: close, but not acting."""
        end, at = self._room(1), self._view.at
        numbers, integers = self._numbers[self._end], self._integers[self._end]
        numbers[:], integers[:] = 0, -1
        numbers[at["dist"]] = gap
        numbers[at["pos"] : at["pos"] + 3] = point
        numbers[at["frame"] : at["frame"] + 3] = normal
        integers[at["geom"] : at["geom"] + 2] = geoms
        self._end = end
        self.starts.append(self._stop)
        self.ticks.append(tick)
        self.counts.append(1)

    def add_some(self, data: Data, tick: int, keep: NDArray[np.bool_]) -> None:
        """Takes down the contacts in `keep`, (ncon,)."""
        count = int(keep.sum())
        if count:
            end = self._room(count)
            self._numbers[self._end : end] = self._view.numbers[: len(keep)][keep]
            self._integers[self._end : end] = self._view.integers[: len(keep)][keep]
            self._end = end
            self._add_forces(data)
        self.ticks.append(tick)
        self.counts.append(count)

    def mark(self) -> Mark:
        """How much there is now."""
        return len(self.ticks), len(self.starts), self._end, self._stop

    def forget(self, mark: Mark) -> None:
        """Drops what has come since `mark`."""
        readings, starts, self._end, self._stop = mark
        del self.ticks[readings:], self.counts[readings:], self.starts[starts:]

    def _add_forces(self, data: Data) -> None:
        forces = data.efc_force
        stop = self._stop + len(forces)
        if stop > len(self._forces):
            self._forces = _grown(self._forces, 2 * stop + 1024)
        self._forces[self._stop : stop] = forces
        self.starts.append(self._stop)
        self._stop = stop

    def _room(self, count: int) -> int:
        """Makes room for `count` more contacts; returns where they end."""
        end = self._end + count
        if end > len(self._numbers):
            if not self._end:
                self._numbers = np.empty((0, self._view.widths[0]))
                self._integers = np.empty((0, self._view.widths[1]), np.int32)
            self._numbers = _grown(self._numbers, 2 * end + 256)
            self._integers = _grown(self._integers, 2 * end + 256)
        return end

    def since(self, tick: int) -> tuple[int, int]:
        """The first reading from engine step `tick` on, and the first of its contacts."""
        first = bisect_left(self.ticks, tick)
        return first, self._end - sum(self.counts[first:])

    def numbers(self, name: str, start: int = 0, width: int = 0) -> FloatArray:
        """A field of the contacts from row `start` on; width: 0 for a plain column."""
        at = self._view.at[name]
        rows = self._numbers[start : self._end]
        return rows[:, at : at + width] if width else rows[:, at]

    def integers(self, name: str, start: int = 0, width: int = 0) -> IntArray:
        """A field of the contacts from row `start` on; width: 0 for a plain column."""
        if start == self._end:
            return np.empty((0, width) if width else 0, np.int32)
        at = self._view.at[name]
        rows = self._integers[start : self._end]
        return rows[:, at : at + width] if width else rows[:, at]

    @property
    def empty(self) -> bool:
        """Whether no reading has a contact."""
        return self._end == 0

    @property
    def forces(self) -> FloatArray:
        """Forces of all readings, N."""
        return self._forces[: self._stop]


def _grown(array: NDArray[T], rows: int) -> NDArray[T]:
    larger = np.empty((rows, *array.shape[1:]), array.dtype)
    larger[: len(array)] = array
    return larger
