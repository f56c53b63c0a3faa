"""Numbers that decide something are fields of settings, which say their unit, range and reason."""

from __future__ import annotations

import ast
import io
import math
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import physagent_studio

PACKAGE = Path(physagent_studio.__file__).parent
ROOMS = ("agent/rules", "reconstruction")
"""Rooms without a bare number."""
WITH_UNIT = re.compile(
    r".+_(px|rad|deg|m|mm|s|mps|kg|n|count|steps|levels|rgb|lab|log|percent|shares?|ratios?|factor|sigmas|bytes)"
)
"""Names of fields that end in their unit; other fields say it before their range."""
SAID = re.compile(r"(?:([^:,]+), )?(-?[\d.e-]+?)\.\.(-?[\d.e-]+): (.+)")
MODULES = sorted(path for room in ROOMS for path in (PACKAGE / room).rglob("*.py"))


def is_number(value: ast.expr | None) -> bool:
    """Whether a value is made of numbers alone; coordinates in an array are a shape."""
    match value:
        case ast.Constant(value=number):
            return isinstance(number, int | float) and not isinstance(number, bool)
        case ast.Attribute(attr="pi" | "inf" | "tau"):
            return True
        case ast.UnaryOp(operand=one):
            return is_number(one)
        case ast.BinOp(left=left, right=right):
            return is_number(left) and is_number(right)
        case ast.Call(func=ast.Attribute(attr="array" | "diag" | "eye" | "linspace" | "zeros")):
            return False
        case ast.Tuple(elts=parts) | ast.List(elts=parts) | ast.Call(args=parts):
            return bool(parts) and all(is_number(part) for part in parts)
    return False


def bare_numbers(tree: ast.Module) -> Iterator[str]:
    """Numbers at the level of a module; the version of a format counts and measures nothing."""
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            name, parts = ast.unparse(targets[0]), [node.value]
            if isinstance(targets[0], ast.Tuple) and isinstance(node.value, ast.Tuple):
                parts = node.value.elts
            if any(is_number(part) for part in parts) and name != "VERSION":
                yield name


def comments_of(text: str) -> dict[int, tuple[bool, str]]:
    """Whether a line is all comment, and what it says, by its number."""
    found = {}
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            alone = not token.line[: token.start[1]].strip()
            found[token.start[0]] = alone, token.string.lstrip("# ")
    return found


def said_of(field: ast.AnnAssign, comments: dict[int, tuple[bool, str]]) -> str:
    """What is written behind a field, or in the lines above it."""
    first, last = field.lineno, field.end_lineno or field.lineno
    if not any(line in comments for line in range(first, last + 1)):
        while comments.get(first - 1, (False, ""))[0]:
            first -= 1
    return " ".join(comments[line][1] for line in range(first, last + 1) if line in comments)


def flat(value: object) -> Iterator[float]:
    """The numbers of a default."""
    for part in value if isinstance(value, tuple) else ():
        yield from flat(part)
    if isinstance(value, int | float):
        yield value


def complaints(text: str) -> Iterator[str]:
    """What is wrong with the numbers of a module."""
    tree, comments = ast.parse(text), comments_of(text)
    for name in bare_numbers(tree):
        yield f"{name} is a number of the module; make it a field of settings"
    for node in tree.body:
        if not isinstance(node, ast.ClassDef) or not node.name.endswith("Settings"):
            continue
        made = [ast.unparse(how) for how in node.decorator_list]
        if not any(how.startswith("dataclass(") and "frozen=True" in how for how in made):
            yield f"{node.name} is no frozen dataclass"
        for field in node.body:
            if not isinstance(field, ast.AnnAssign) or field.value is None:
                continue
            name, said = ast.unparse(field.target), SAID.fullmatch(said_of(field, comments))
            if said is None:
                yield f"{node.name}.{name} has no comment 'unit, low..high: reason'"
                continue
            unit, low, high, why = said.groups()
            if not unit and not WITH_UNIT.fullmatch(name):
                yield f"{node.name}.{name} says no unit"
            if "_" not in name or " " not in why:
                yield f"{node.name}.{name} needs words"
            default = eval(ast.unparse(field.value), {"math": math, "np": np})
            if not all(float(low) <= one <= float(high) for one in flat(default)):
                yield f"{node.name}.{name} is out of its range"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_each_number_says_its_unit_range_and_reason(path: Path) -> None:
    assert list(complaints(path.read_text(encoding="utf-8"))) == []


def test_what_is_missing_is_seen() -> None:
    head = "@dataclass(frozen=True)\nclass EdgeSettings:\n    "
    assert list(complaints("MOST, TOP = 3, 'a'")) != []
    assert list(complaints("BENT = math.radians(5.0)")) != []
    assert list(complaints("UP = np.array([0.0, 0.0, 1.0])\nNAMES = ('a', 'b')")) == []
    assert list(complaints(f"{head}max_bend_rad: float = 0.1  # 0..0.5: more is round")) == []
    assert (
        list(complaints(f"{head}# count, 1..9: few\n    # will do\n    max_edges: int = 3")) == []
    )
    for field in (
        "max_bend_rad: float = 0.1",
        "max_bend_rad: float = 0.1  # straight edges alone",
        "max_bend_rad: float = 0.1  # 0.2..0.5: more is round",
        "max_bend: float = 0.1  # 0..0.5: more is round",
        "bend: float = 0.1  # rad, 0..0.5: more is round",
    ):
        assert list(complaints(head + field)) != [], field
    assert (
        list(complaints("class EdgeSettings:\n    max_edges: int = 3  # count, 1..9: a few")) != []
    )
