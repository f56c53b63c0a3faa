"""The syntax tree of a handler file, walked with a small vocabulary of our own: nothing is run.

Numbers and vectors are computed; where a thing is, is not known before the simulation and stays a
symbol (`Place`), so that "towards that one" survives as such (`Way`). Whatever is outside of the
vocabulary raises `Unread`, and the caller lists it.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

MOST_STEPS = 400_000
"""Expressions that are looked at in one file; the longest published one needs a tenth."""
LONGEST_LIST = 1000
"""Items of a list or turns of a loop."""
_TINY = 1e-3
"""What is added to a length so that it is not zero."""


class Unread(Exception):
    """An expression or statement without counterpart."""


class TooMuch(Exception):
    """More than `MOST_STEPS`."""


@dataclass(frozen=True, slots=True)
class Thing:
    """An object by its number in the configuration."""

    index: int


@dataclass(frozen=True, slots=True)
class Place:
    """Where a thing is."""

    index: int


@dataclass(frozen=True, slots=True)
class Way:
    """`scale` times the way from one thing to another; `unit`: of length 1 before that."""

    source: int
    target: int
    scale: float = 1.0
    unit: bool = False
    horizontal: bool = False


@dataclass(frozen=True, slots=True)
class Length:
    """How long a way is."""

    way: Way


@dataclass(frozen=True, slots=True)
class Made:
    """A call of one of the releases' classes: name, arguments by position and by name."""

    name: str
    values: tuple[Any, ...]
    named: Mapping[str, Any]


Vector = tuple[float, ...]
_BINARY: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
_COMPARED: dict[type, Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda one, other: one in other,
}
_NUMERIC: dict[str, Callable[..., Any]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "sqrt", "exp", "radians")},
    "deg2rad": math.radians,
    "abs": abs,
    "min": min,
    "max": max,
    "float": float,
    "float32": float,
    "float64": float,
    "int": int,
    "bool": bool,
    "str": str,
    "clip": lambda value, low, high: min(max(value, low), high),
}
_AS_THEY_ARE = {"array", "asarray", "float32", "tensor", "as_tensor", "list", "tuple", "reshape"}
_SAME = {"cpu", "numpy", "detach", "copy", "astype", "reshape", "flatten", "to", "squeeze", "item"}


@dataclass(slots=True)
class Walker:
    """Evaluates expressions. names: what the function knows. own: attributes of `self`. count: how
    many things there are. known: classes whose calls are kept as `Made`."""

    count: int
    config: Mapping[str, Any]
    known: frozenset[str]
    own: dict[str, Any] = field(default_factory=dict)
    names: dict[str, Any] = field(default_factory=dict)
    steps: int = 0

    def value(self, node: ast.expr) -> Any:
        """What an expression means. Raises Unread."""
        self.steps += 1
        if self.steps > MOST_STEPS:
            raise TooMuch
        reader = getattr(self, f"_{type(node).__name__.lower()}", None)
        if reader is None:
            raise Unread(type(node).__name__)
        return reader(node)

    def _constant(self, node: ast.Constant) -> Any:
        if isinstance(node.value, bool | int | float | str) or node.value is None:
            return node.value
        raise Unread("a constant")

    def _name(self, node: ast.Name) -> Any:
        if node.id not in self.names:
            raise Unread(f"'{node.id}'")
        return _found(self.names[node.id])

    def _attribute(self, node: ast.Attribute) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id == "self":
            if node.attr in ("all_objs", "objs"):
                return tuple(Thing(index) for index in range(self.count))
            if node.attr == "all_obj_info":
                return (None,) * self.count
            if node.attr == "config":
                return self.config
            if node.attr in self.own:
                return _found(self.own[node.attr])
        if node.attr == "pi":
            return math.pi
        raise Unread(f"'{ast.unparse(node)[:80]}'")

    def _unaryop(self, node: ast.UnaryOp) -> Any:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return not self.truth(value)
        if isinstance(node.op, ast.USub):
            return times(value, -1.0)
        return value

    def _binop(self, node: ast.BinOp) -> Any:
        return combined(type(node.op), self.value(node.left), self.value(node.right))

    def _boolop(self, node: ast.BoolOp) -> Any:
        every = isinstance(node.op, ast.And)
        for part in node.values:
            if self.truth(self.value(part)) != every:
                return not every
        return every

    def _compare(self, node: ast.Compare) -> Any:
        left = self.value(node.left)
        for sign, part in zip(node.ops, node.comparators, strict=True):
            right = self.value(part)
            way = _COMPARED.get(type(sign))
            if way is None or not (_plain(left) and _plain(right)):
                raise Unread("a comparison of what only the simulation knows")
            try:
                if not way(left, right):
                    return False
            except TypeError as error:
                raise Unread("a comparison") from error
            left = right
        return True

    def _ifexp(self, node: ast.IfExp) -> Any:
        return self.value(node.body if self.truth(self.value(node.test)) else node.orelse)

    def _list(self, node: ast.List | ast.Tuple) -> Any:
        found: list[Any] = []
        for item in node.elts:
            if isinstance(item, ast.Starred):
                part = self.value(item.value)
                found += list(part) if isinstance(part, tuple) else [part]
            else:
                found.append(self.value(item))
        if len(found) > LONGEST_LIST:
            raise Unread("a list that long")
        # [[x, y, z]] is one vector to the peers' engine.
        return found[0] if len(found) == 1 and isinstance(found[0], tuple | Way) else tuple(found)

    _tuple = _list

    def _subscript(self, node: ast.Subscript) -> Any:
        held, key = self.value(node.value), self.value(node.slice)
        if isinstance(held, tuple) and type(key) is int and -len(held) <= key < len(held):
            return held[key]
        if isinstance(held, Mapping) and key in held:
            return _frozen(held[key])
        raise Unread(f"'{ast.unparse(node)[:80]}'")

    def _call(self, node: ast.Call) -> Any:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ast.unparse(node.func)
        base = node.func.value if isinstance(node.func, ast.Attribute) else None
        if name in self.known:
            named = {word.arg: self.value(word.value) for word in node.keywords if word.arg}
            return Made(name, tuple(self.value(one) for one in node.args), named)
        if base is not None and ast.unparse(base) == "self.config":
            return self._configured(node)
        if name == "get_pos" and base is not None and isinstance(held := self.value(base), Thing):
            return Place(held.index)
        library = base is None or ast.unparse(base) in ("np", "numpy", "math", "torch", "np.linalg")
        if base is not None and name in _SAME and not library:
            return self.value(base)
        return self._library(name, node) if library else self._unread(node)

    def _unread(self, node: ast.expr) -> Any:
        raise Unread(f"'{ast.unparse(node)[:80]}'")

    def _configured(self, node: ast.Call) -> Any:
        values = [self.value(one) for one in node.args]
        if not values or not isinstance(values[0], str):
            raise Unread("a key of the configuration")
        return _frozen(self.config.get(values[0], values[1] if len(values) > 1 else None))

    def _library(self, name: str, node: ast.Call) -> Any:
        values = [self.value(one) for one in node.args]
        if name == "norm" and len(values) == 1:
            return length_of(values[0])
        if name == "zeros" and values and values[0] in (3, 6, (3,), (6,), (1, 3)):
            return (0.0,) * (6 if values[0] in (6, (6,)) else 3)
        if name == "len" and isinstance(values[0], tuple):
            return len(values[0])
        if name in ("range", "arange") and all(type(one) is int for one in values):
            found = range(*values[:3])
            if len(found) > LONGEST_LIST:
                raise Unread("a loop that long")
            return tuple(found)
        if name in _AS_THEY_ARE and values and not isinstance(values[0], int | float | str):
            return values[0]
        if name in _NUMERIC and values and all(isinstance(v, int | float) for v in values):
            try:
                return _NUMERIC[name](*values)
            except (ArithmeticError, TypeError, ValueError) as error:
                raise Unread(f"'{ast.unparse(node)[:80]}'") from error
        return self._unread(node)

    def truth(self, value: Any) -> bool:
        """Whether a condition holds. Raises Unread where only the simulation knows."""
        if not _plain(value):
            raise Unread("a condition that only the simulation knows")
        return bool(value)


def combined(sign: type, left: Any, right: Any) -> Any:
    """What a sign between two values means. Raises Unread."""
    if isinstance(left, int | float) and isinstance(right, int | float):
        try:
            return _BINARY[sign](left, right)
        except (ArithmeticError, KeyError) as error:
            raise Unread("arithmetic") from error
    if isinstance(left, Place) and isinstance(right, Place) and sign is ast.Sub:
        return Way(right.index, left.index)
    if isinstance(left, Length) and sign is ast.Add and isinstance(right, int | float):
        return _never_zero(left, right)
    if isinstance(left, Way) and isinstance(right, Length) and sign is ast.Div:
        return _of_length_one(left, right.way)
    if sign in (ast.Mult, ast.Div):
        if isinstance(right, int | float):
            if sign is ast.Div and right == 0:
                raise Unread("a division by zero")
            return times(left, 1 / right if sign is ast.Div else right)
        if isinstance(left, int | float) and sign is ast.Mult:
            return times(right, left)
    if sign in (ast.Add, ast.Sub) and isinstance(left, tuple) and isinstance(right, tuple):
        return _by_parts(_BINARY[sign], left, right)
    raise Unread("arithmetic on what only the simulation knows")


def _by_parts(way: Callable[[float, float], float], left: Vector, right: Vector) -> Vector:
    if not (_numbers(left) and _numbers(right) and len(left) == len(right)):
        raise Unread("arithmetic on vectors of different lengths")
    return tuple(way(a, b) for a, b in zip(left, right, strict=True))


def _never_zero(length: Length, added: float) -> Length:
    if abs(added) < _TINY:
        return length
    raise Unread("arithmetic on what only the simulation knows")


def _of_length_one(way: Way, own: Way) -> Way:
    if replace(way, scale=1.0) != replace(own, scale=1.0):
        raise Unread("a vector by the length of another")
    return replace(way, unit=True, scale=way.scale / own.scale)


def times(value: Any, factor: float) -> Any:
    """A number, vector or way, so many times. Raises Unread."""
    if isinstance(value, int | float):
        return value * factor
    if isinstance(value, Way):
        return replace(value, scale=value.scale * factor)
    if _numbers(value):
        return tuple(part * factor for part in value)
    raise Unread("arithmetic on what only the simulation knows")


def length_of(value: Any) -> Any:
    """How long a vector or a way is. Raises Unread."""
    if isinstance(value, Way):
        return abs(value.scale) if value.unit else Length(value)
    if _numbers(value):
        return math.sqrt(sum(part * part for part in value))
    raise Unread("a length")


def _numbers(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(part, int | float) for part in value)


def _plain(value: Any) -> bool:
    return value is None or isinstance(value, bool | int | float | str | tuple)


def _found(value: Any) -> Any:
    if isinstance(value, Unread):
        raise value
    return value


def _frozen(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_frozen(part) for part in value[:LONGEST_LIST])
    return value
