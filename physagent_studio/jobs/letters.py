"""Values over a socket: a pickle with its arrays beside it, and what may come back from a task."""

import copyreg
import io
import itertools
import pickle
import select
import socket
import struct
import sys
import weakref
from collections import deque
from collections.abc import Callable
from types import MappingProxyType
from typing import Any

import numpy as np

_COUNTS = struct.Struct("<II")
"""How many buffers belong to the arrays that are new, and how many to the value."""
_LENGTH = struct.Struct("<Q")
_TRUSTED = ("physagent_studio", "numpy")
_PLAIN = {"builtins": {"complex", "frozenset", "set", "slice", "range", "bytearray"}}
_ARRAYS = {"_reconstruct", "_frombuffer", "scalar"}
"""The functions by which NumPy brings arrays and numbers back."""
_PIECE = 2**20
"""Bytes that are handed to the socket at once, between which somebody may cancel."""
WORTH_KEEPING = 4096
"""Bytes from which on an array is known by a number instead of being sent again."""

Array = np.ndarray[Any, Any]
Meanwhile = Callable[[], None]
"""Called every twentieth of a second while the other side is waited for; may raise."""


class Kept:
    """Arrays that both sides have: each crosses once, and goes by its number from then on.

    The side that asks (`weak`) holds none of them: what has gone there is forgotten by both. Arrays
    that have crossed may not be changed any more.
    """

    def __init__(self, *, weak: bool) -> None:
        self._weak = weak
        # Both sides give numbers, so these may not meet.
        self._next = itertools.count(0 if weak else 1, 2)
        self._numbers: dict[int, int] = {}
        self._arrays: dict[int, Any] = {}
        self._gone: deque[int] = deque()

    def hold(self) -> list[Any]:
        """The arrays that are here, so that none goes while an answer may still speak of it."""
        return [one() for one in list(self._arrays.values())] if self._weak else []

    def number_of(self, array: Array) -> int | None:
        """The number that both sides know an array by; None where it has to be sent."""
        number = self._numbers.get(id(array))
        return number if number is not None and self.array(number) is array else None

    def array(self, number: int) -> Array | None:
        """The array of a number; None where it has gone."""
        kept = self._arrays[number]
        return kept() if self._weak else kept

    def add(self, array: Array, number: int | None = None) -> int:
        """Keeps an array under its number, or under the next one, which is returned."""
        given = next(self._next) if number is None else number
        if self._weak:
            self._arrays[given] = weakref.ref(array, lambda _: self._gone.append(given))
        else:
            self._arrays[given] = array
        self._numbers[id(array)] = given
        return given

    def gone(self) -> list[int]:
        """What has gone since the last letter, which the other side may forget as well."""
        numbers = [self._gone.popleft() for _ in range(len(self._gone))]
        self.forget(numbers)
        return numbers

    def forget(self, numbers: list[int]) -> None:
        """Lets go of these arrays."""
        dropped = set(numbers)
        for number in dropped:
            del self._arrays[number]
        if dropped:
            self._numbers = {key: one for key, one in self._numbers.items() if one not in dropped}


def post(
    line: socket.socket, value: Any, kept: Kept | None = None, meanwhile: Meanwhile | None = None
) -> None:
    """Sends a value; arrays go beside the pickle and are copied nowhere."""
    gone = kept.gone() if kept is not None else []
    body = _Pickler(kept)
    text = body.pickled(value)
    # What is new comes first: the value speaks of it by number.
    news = _Pickler(None)
    parts = [news.pickled((gone, body.fresh)), text, *news.buffers, *body.buffers]
    lengths = b"".join(_LENGTH.pack(one.nbytes) for one in parts)
    _write(line, memoryview(_COUNTS.pack(len(news.buffers), len(body.buffers)) + lengths), None)
    for one in parts:
        _write(line, one, meanwhile)


def take(
    line: socket.socket,
    *,
    strict: bool,
    kept: Kept | None = None,
    meanwhile: Meanwhile | None = None,
) -> Any:
    """The next value. strict: only plain data, arrays and classes of this package are made of it.

    Raises EOFError where the other side has gone.
    """
    first, rest = _COUNTS.unpack(_read(line, _COUNTS.size, meanwhile))
    sizes = _read(line, (2 + first + rest) * _LENGTH.size, meanwhile)
    news, text, *buffers = [_read(line, size, meanwhile) for (size,) in _LENGTH.iter_unpack(sizes)]
    gone, fresh = _unpickled(news, buffers[:first], strict, None)
    if kept is not None:
        kept.forget(gone)
        for number, array in fresh:
            kept.add(array, number)
    return _unpickled(text, buffers[first:], strict, kept)


def _write(line: socket.socket, data: memoryview, meanwhile: Meanwhile | None) -> None:
    at = 0
    while at < data.nbytes:
        while meanwhile is not None and not select.select([], [line], [], 0.05)[1]:
            meanwhile()
        at += line.send(data[at : at + _PIECE])


def _read(line: socket.socket, count: int, meanwhile: Meanwhile | None) -> bytearray:
    found = bytearray(count)
    view, at = memoryview(found), 0
    while at < count:
        while meanwhile is not None and not select.select([line], [], [], 0.05)[0]:
            meanwhile()
        came = line.recv_into(view[at:])
        if came == 0:
            raise EOFError
        at += came
    return found


class _Pickler(pickle.Pickler):
    """Puts the buffers of arrays aside, and numbers in place of arrays that are kept."""

    dispatch_table = copyreg.dispatch_table | {
        MappingProxyType: lambda mapping: (frozen, (dict(mapping),))
    }

    def __init__(self, kept: Kept | None) -> None:
        self._stream, self._kept = io.BytesIO(), kept
        self._raw: list[pickle.PickleBuffer] = []
        self.fresh: list[tuple[int, Array]] = []
        super().__init__(self._stream, protocol=5, buffer_callback=self._raw.append)

    def pickled(self, value: Any) -> memoryview:
        self.dump(value)
        return self._stream.getbuffer()

    @property
    def buffers(self) -> list[memoryview]:
        return [one.raw() for one in self._raw]

    def persistent_id(self, obj: Any) -> int | None:
        kept = self._kept
        if kept is None or type(obj) is not np.ndarray or obj.nbytes < WORTH_KEEPING:
            return None
        number = kept.number_of(obj)
        if number is None:
            number = kept.add(obj)
            self.fresh.append((number, obj))
        return number


def frozen(mapping: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    """A mapping that cannot be changed: what the language itself does not pickle."""
    return MappingProxyType(mapping)


def _unpickled(text: bytearray, buffers: list[bytearray], strict: bool, kept: Kept | None) -> Any:
    made = (_Strict if strict else _Unpickler)(io.BytesIO(text), buffers=buffers)
    made.kept = kept
    return made.load()


class _Unpickler(pickle.Unpickler):
    kept: Kept | None = None

    def persistent_load(self, pid: Any) -> Any:
        if self.kept is None:
            raise pickle.UnpicklingError("nothing is kept here")
        return self.kept.array(pid)


class _Strict(_Unpickler):
    """A process that was taken over by what it decoded can make values here, but call nothing."""

    def find_class(self, module: str, name: str) -> Any:
        if name in _PLAIN.get(module, ()):
            return super().find_class(module, name)
        if (module, name) == (__name__, frozen.__name__):
            return frozen
        if module.partition(".")[0] in _TRUSTED and "." not in name and module in sys.modules:
            found = getattr(sys.modules[module], name, None)
            numpys = module.startswith("numpy") and name in _ARRAYS
            if numpys or (isinstance(found, type) and found.__module__.startswith(_TRUSTED)):
                return found
        raise pickle.UnpicklingError(f"a task may not give back {module}.{name}")
