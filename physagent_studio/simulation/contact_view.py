"""The engine's contact list as three plain arrays that are made once and always show its present.

MuJoCo keeps the contacts of an engine step as records at the start of a fixed block of memory.
Its bindings make a new array for every field that is asked for, which costs more than copying
all contacts. So the places of the fields are asked for once, and the same memory is seen through
one table of numbers and one of integers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided

from physagent_studio.simulation.mj import Data
from physagent_studio.simulation.surfaces import FloatArray, IntArray

NUMBERS = {"dist": 1, "pos": 3, "frame": 9, "includemargin": 1}
INTEGERS = {"dim": 1, "geom": 2, "flex": 2, "efc_address": 1}


class ContactView:
    """Contacts of `data` as they are now: rows [:data.ncon] of both tables are valid.

    numbers: (capacity, A) float64; integers: (capacity, B) int32, both empty until there has been
    a contact. pairs: the columns of the two geoms, −1 for flexes. at: the first column of a field
    in its table.
    """

    def __init__(self, data: Data) -> None:
        self._data = data
        self.numbers: FloatArray = np.empty((0, 0))
        self.integers: IntArray = np.empty((0, 0), np.int32)
        self.pairs: IntArray = np.empty((0, 2), np.int32)
        self.at: dict[str, int] = {}

    def bind(self) -> None:
        """Finds the tables; needs a contact to be there, and does nothing once they are found."""
        if self.at:
            return
        contact = self._data.contact
        fields = {name: getattr(contact, name) for name in (*NUMBERS, *INTEGERS)}
        size = fields["dist"].strides[0]
        capacity = self._data.narena // size
        self.numbers = self._table(fields, NUMBERS, size, capacity)
        self.integers = self._table(fields, INTEGERS, size, capacity)
        column = self.at["geom"]
        self.pairs = self.integers[:, column : column + 2]

    def _table(
        self, fields: dict[str, Any], widths: dict[str, int], size: int, capacity: int
    ) -> np.ndarray:
        first = min(widths, key=lambda name: _address(fields[name]))
        base, unit = _address(fields[first]), fields[first].itemsize
        for name in widths:
            self.at[name] = (_address(fields[name]) - base) // unit
        width = max(self.at[name] + count for name, count in widths.items())
        # The last record must not be read beyond its end.
        return as_strided(fields[first], (capacity - 1, width), (size, unit), writeable=False)

    def geoms(self) -> IntArray:
        """(ncon, 2) ids of the geoms that are close to each other now."""
        count = self._data.ncon
        if count:
            self.bind()
        return self.pairs[:count]


def _address(array: Any) -> int:
    return array.__array_interface__["data"][0]
