"""YAML as plain data with the line of every value, for case folders.

Of YAML it takes mappings with text keys, lists and scalars of the 1.2 core schema: no tags, no
duplicate keys, no merge keys, a bounded number of nodes (an alias counts every time it is used).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

from physagent_studio.errors import InputError
from physagent_studio.jobs import Limits, within

Place = tuple[str | int, ...]

MAX_BYTES = 1_000_000
HARMLESS = 20_000
"""Characters that are parsed here and now; a longer text might take many seconds."""
LIMITS = Limits(seconds=0.8, memory=128 * 2**20)
"""What parsing a document may take: twenty thousand honest values take half of it."""
_MAX_NODES = 20_000
_MAX_DEPTH = 12
_INT = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_SPECIAL = {
    "": None,
    "~": None,
    "null": None,
    "Null": None,
    "NULL": None,
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
}
_TAGS = {
    f"tag:yaml.org,2002:{kind}"
    for kind in ("map", "seq", "str", "int", "float", "bool", "null", "timestamp", "merge", "value")
}
"""What PyYAML calls the kinds of values that carry no tag of their own."""


@dataclass(frozen=True, slots=True)
class PlainYaml:
    """A document: its data and the 1-based line of each place (keys and indices) in it."""

    data: Any
    lines: Mapping[Place, int]

    def line(self, place: Place) -> int:
        """The line of a place, or of the nearest thing that holds it."""
        while place and place not in self.lines:
            place = place[:-1]
        return self.lines.get(place, 1)


def read_yaml(text: str, name: str, *, last_wins: bool = False) -> PlainYaml:
    """Parse a document called `name` in messages; last_wins allows a key to stand twice.

    Raises:
        InputError: it is no YAML, or uses more of YAML than it may; says on which line.
    """
    if len(text) <= HARMLESS:
        return parsed(text, name, last_wins)
    if text.count("\n") + text.count(",") > 2 * _MAX_NODES:
        raise InputError(f"{name}: there is too much here (at most {_MAX_NODES} values)")
    return within(LIMITS, f"{name} cannot be read", parsed, text, name, last_wins)


def parsed(text: str, name: str, last_wins: bool) -> PlainYaml:
    """The task behind `read_yaml`: trusts the text with time and memory."""
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f", line {mark.line + 1}" if mark else ""
        raise InputError(f"{name}{where}: this is no valid YAML ({error.problem})") from error
    except yaml.YAMLError as error:
        raise InputError(f"{name}: this is no valid YAML (a character that is not text)") from error
    except RecursionError as error:
        raise InputError(f"{name}: it is nested too deeply (at most {_MAX_DEPTH})") from error
    reader = _Reader(name, last_wins)
    data = None if root is None else reader.build(root, ())
    return PlainYaml(data, reader.lines)


@dataclass(slots=True)
class _Reader:
    name: str
    last_wins: bool
    lines: dict[Place, int] = field(default_factory=dict)
    count: int = 0

    def fail(self, node: yaml.Node, what: str) -> InputError:
        return InputError(f"{self.name}, line {node.start_mark.line + 1}: {what}")

    def build(self, node: yaml.Node, place: Place) -> Any:
        self.count += 1
        if self.count > _MAX_NODES:
            raise self.fail(node, f"there is too much here (at most {_MAX_NODES} values)")
        if len(place) > _MAX_DEPTH:
            raise self.fail(node, f"it is nested too deeply (at most {_MAX_DEPTH})")
        self.lines.setdefault(place, node.start_mark.line + 1)
        if node.tag not in _TAGS:
            raise self.fail(node, f"a tag ({node.tag}) is not allowed here")
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, place)
        if isinstance(node, yaml.SequenceNode):
            return [self.build(item, (*place, i)) for i, item in enumerate(node.value)]
        return self._scalar(node)

    def _mapping(self, node: yaml.MappingNode, place: Place) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode) or key.value == "<<":
                raise self.fail(key, "a key must be plain text")
            if key.value in found and not self.last_wins:
                raise self.fail(key, f"'{key.value}' stands here twice")
            self.lines[(*place, key.value)] = key.start_mark.line + 1
            found[key.value] = self.build(value, (*place, key.value))
        return found

    def _scalar(self, node: yaml.Node) -> Any:
        text = node.value
        # PyYAML resolves by YAML 1.1 (1e3 a text, 12:30 a number), so plain scalars are read here.
        if getattr(node, "style", None) is not None:
            return text
        if text in _SPECIAL:
            return _SPECIAL[text]
        if _INT.fullmatch(text):
            return int(text) if len(text) <= 18 else float(text)
        return float(text) if _FLOAT.fullmatch(text) else text
