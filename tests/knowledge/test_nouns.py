"""What is known of kinds of things stands in the catalogue alone; the code names none of them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import physagent_studio
from physagent_studio.knowledge import kinds


def _listed(text: str) -> list[str]:
    """The words of a list."""
    return text.split()


PACKAGE = Path(physagent_studio.__file__).parent
ELSEWHERE = ("knowledge", "benchmark")
"""Where names of things may stand: the tables, and the scenes that the measuring commands build."""
SHAPES = frozenset(
    [
        "box",
        "sphere",
        "cylinder",
        "bowl",
        "ring",
        "tube",
        "board",
        "vessel",
        "ramp",
        "floor",
        "wall",
        "slab",
        "stairs",
        "rail",
        "wedge",
        "slope",
        "cloth",
        "rope",
        "cone",
        "cup",
    ]
)
"""Kinds of shapes, supports and bodies: words of the program, and what the studio calls them."""
FIELDS = frozenset(
    [
        # What Mitsuba calls a lamp that is round and flat, and the rim of a texture.
        "disk",
        "clamp",
        "camera",
        "person",
        "step",
        "steps",
        "roll",
        "case",
        "key",
        "pin",
        "log",
        "folder",
        "string",
        "token",
        "figure",
        "present",
        "fork",
        "stage",
        "target",
        "lane",
        "sheet",
        "window",
        "brush",
        "scissors",
        "bench",
        "plate",
        "ground",
        "goal",
        "gap",
        "wrench",
        "table",
        "trash",
        "notebook",
        "workbench",
        "ball",
        "plane",
        "robot",
        "torch",
        "cat",
    ]
)
"""Fields, sources, files, commands and widgets of the program itself and of the formats that it

reads, modules, and what is computed.
"""
VERBS = frozenset(
    _listed(
        """
    slide sink stand swing rock roll can stack pile
    """
    )
)
"""Words that the reader knows as verbs or as arrangements."""
ALLOWED = SHAPES | FIELDS | VERBS


def literals(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and text of each string of a program, but for what documents it and what it says."""
    passed: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            passed.add(id(node.value))
        if isinstance(node, ast.JoinedStr):
            passed |= {id(value) for value in node.values}
        if (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in passed
        ):
            yield node.lineno, node.value


def test_no_code_names_a_kind_of_thing() -> None:
    names = {word for kind in kinds() for word in (kind.name, *kind.synonyms)} - ALLOWED
    found: list[str] = []
    for path in sorted(PACKAGE.rglob("*.py")):
        where = path.relative_to(PACKAGE)
        if where.parts[0] in ELSEWHERE:
            continue
        for line, text in literals(ast.parse(path.read_text(encoding="utf-8"))):
            said = re.findall(r"[a-z_]+", text)
            # A list of words in one string counts word by word, a sentence does not.
            listed = [word for word in said if word in names]
            is_list = bool(re.fullmatch(r"[a-z_ |]+", text)) and len(listed) >= 0.3 * len(said)
            if text.replace(" ", "_") in names or (is_list and len(listed) > 1):
                found.append(f"{where}:{line}: {text}")
    assert found == []


def test_no_word_is_allowed_for_nothing() -> None:
    names = {word for kind in kinds() for word in (kind.name, *kind.synonyms)}
    assert sorted(word for word in ALLOWED if word not in names) == []
