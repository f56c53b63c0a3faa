"""The engine's contact list as three plain arrays that are made once and always show its present.

MuJoCo keeps the contacts of an engine step as records at the start of a fixed block of memory.
Its bindings make a new array for every field that is asked for, which costs more than copying
all contacts. So the places of the fields are asked for once, and the same memory is seen through
one table of numbers and one of integers.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from physagent_studio.simulation.mj import Data, mj
from physagent_studio.simulation.surfaces import FloatArray, IntArray

NUMBERS = {"dist": 1, "pos": 3, "frame": 9, "includemargin": 1}
INTEGERS = {"dim": 1, "geom": 2, "flex": 2, "efc_address": 1}


PROBE = """
<mujoco><worldbody>
  <geom type="plane" size="1 1 1"/><body pos="0 0 0.05"><freejoint/><geom size="0.1"/></body>
</worldbody></mujoco>
"""
"""A ball in a floor: one contact, to see how the engine keeps them."""


class ContactView:
    """Contacts of `data` as they are now: rows [:data.ncon] of both tables are valid.

    numbers: (capacity, A) float64; integers: (capacity, B) int32, both empty until there has been
    a contact. widths: A and B. pairs: the columns of the two geoms, −1 for flexes. codes:
    (capacity,) both as one number. at: the first column of a field in its table.
    """

    def __init__(self, data: Data) -> None:
        self._data = data
        self.numbers: FloatArray = np.empty((0, 0))
        self.integers: IntArray = np.empty((0, 0), np.int32)
        self.pairs: IntArray = np.empty((0, 2), np.int32)
        self.codes: NDArray[np.int64] = np.empty(0, np.int64)
        self.at = {**_columns(tuple(NUMBERS)), **_columns(tuple(INTEGERS))}
        self.widths = (_width(self.at, NUMBERS), _width(self.at, INTEGERS))

    def bind(self) -> None:
        """Finds the tables; needs a contact to be there, and does nothing once they are found."""
        if len(self.codes):
            return
        contact = self._data.contact
        size = contact.dist.strides[0]
        capacity = self._data.narena // size - 1
        tables = []
        for names, width in zip((NUMBERS, INTEGERS), self.widths, strict=True):
            field = getattr(contact, next(name for name in names if self.at[name] == 0))
            # The last record must not be read beyond its end.
            rows = as_strided(field, (capacity, width), (size, field.itemsize), writeable=False)
            tables.append(rows)
        self.numbers, self.integers = tables
        column = self.at["geom"]
        self.pairs = self.integers[:, column : column + 2]
        both = contact.geom.view(np.int64)
        self.codes = as_strided(both, (capacity,), (size,), writeable=False)

    def now(self, count: int) -> NDArray[np.int64]:
        """(count,) the codes of the first contacts; count: positive, no more than there are."""
        if not len(self.codes):
            self.bind()
        return self.codes[:count]

    @staticmethod
    def coded(geoms: IntArray) -> NDArray[np.int64]:
        """(n,) the codes of (n, 2) geoms, in this order."""
        return np.ascontiguousarray(geoms, np.int32).view(np.int64).ravel()

    def spot(self, codes: tuple[int, int]) -> tuple[list[float], list[float]] | None:
        """Point and normal of one contact of two geoms, coded both ways round; None if apart."""
        count = self._data.ncon
        for row, code in enumerate(self.now(count).tolist() if count else ()):
            if code in codes:
                values, at, to = self.numbers[row].tolist(), self.at["pos"], self.at["frame"]
                return values[at : at + 3], values[to : to + 3]
        return None

    def geoms(self) -> IntArray:
        """(ncon, 2) ids of the geoms that are close to each other now."""
        count = self._data.ncon
        if count:
            self.bind()
        return self.pairs[:count]


@cache
def _columns(names: tuple[str, ...]) -> dict[str, int]:
    """Where fields of one type begin, counted in numbers of it from the first of them."""
    model = mj.MjModel.from_xml_string(PROBE)
    data = mj.MjData(model)
    mj.mj_forward(model, data)
    fields = {name: getattr(data.contact, name) for name in names}
    first = min(_address(field) for field in fields.values())
    return {name: (_address(field) - first) // field.itemsize for name, field in fields.items()}


def _width(at: dict[str, int], widths: dict[str, int]) -> int:
    return max(at[name] + count for name, count in widths.items())


def _address(array: Any) -> int:
    return array.__array_interface__["data"][0]
