"""YAML 1.2 without surprises: a bounded tree of nodes with their places in the text.

Refused: duplicate keys, keys that are not plain words, anchors and aliases, tags, several
documents, `.inf` and `.nan`, numbers with a leading zero, depth above 24, and texts of more than
250,000 characters.
`yes`, `no`, `on`, `12:30` and dates are words; `1e3` is a number.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Literal

import yaml

from physagent_studio.errors import Problem, ProgramError

MAX_CHARACTERS = 250_000
MAX_DEPTH = 24
MAX_NODES = 100_000

Scalar = str | int | float | bool | None
Plain = Scalar | list["Plain"] | dict[str, "Plain"]
Location = tuple[str | int, ...]

_NULL = {"", "~", "null", "Null", "NULL"}
_TRUE, _FALSE = {"true", "True", "TRUE"}, {"false", "False", "FALSE"}
_INTEGER = re.compile(r"[-+]?[0-9]{1,40}\Z")
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]{1,6})?\Z")
_ENDLESS = re.compile(r"[-+]?\.(inf|Inf|INF)\Z|\.(nan|NaN|NAN)\Z")
_LEADING_ZERO = re.compile(r"[-+]?0[0-9]")


@dataclass(eq=False, slots=True)
class Node:
    """A value and the 0-based line on which it begins.

    keys: of a mapping, in order, each a scalar node. children: values of a mapping or items of a
    sequence. value: of a scalar.
    """

    kind: Literal["scalar", "mapping", "sequence"]
    line: int
    value: Scalar = None
    keys: list[Node] = field(default_factory=list)
    children: list[Node] = field(default_factory=list)

    def lines(self) -> dict[Location, int]:
        """The 1-based line of every node from this one down, by its location.

        The line of a mapping's value is that of its key.
        """
        found: dict[Location, int] = {(): self.line + 1}
        stack: list[tuple[Location, Node]] = [((), self)]
        while stack:
            here, node = stack.pop()
            for index, child in enumerate(node.children):
                name = str(node.keys[index].value) if node.kind == "mapping" else index
                line = node.keys[index].line if node.kind == "mapping" else child.line
                found[*here, name] = line + 1
                stack.append(((*here, name), child))
        return found

    def plain(self) -> Plain:
        """The value as plain data."""
        if self.kind == "scalar":
            return self.value
        if self.kind == "sequence":
            return [child.plain() for child in self.children]
        names = [str(key.value) for key in self.keys]
        return {name: child.plain() for name, child in zip(names, self.children, strict=True)}


@dataclass(eq=False, slots=True)
class _Builder:
    """Grows the tree from parser events, without recursion."""

    root: Node | None = None
    stack: list[Node] = field(default_factory=list)
    count: int = 0

    @property
    def path(self) -> str:
        """Dotted path of where the parser is."""
        parts: list[str] = []
        for depth, node in enumerate(self.stack):
            inside = depth + 1 < len(self.stack)
            if node.kind == "sequence":
                label = _label(self.stack[depth + 1]) if inside else None
                parts.append(label or str(len(node.children) - inside))
            elif node.keys and (inside or len(node.keys) > len(node.children)):
                parts.append(str(node.keys[-1].value))
        return ".".join(parts)

    def place(self, node: Node) -> None:
        """Puts a finished or opened node where it belongs."""
        self.count += 1
        if self.count > MAX_NODES:
            raise self.problem("the program is too long", f"at most {MAX_NODES} values", node.line)
        if not self.stack:
            self.root = node
            return
        parent = self.stack[-1]
        if parent.kind == "mapping" and len(parent.keys) == len(parent.children):
            self._key(parent, node)
        else:
            parent.children.append(node)

    def _key(self, parent: Node, node: Node) -> None:
        if node.kind != "scalar" or not isinstance(node.value, str):
            what = "a list or mapping" if node.kind != "scalar" else repr(node.value)
            raise self.problem(f"a key must be a word, not {what}", "quote it", node.line)
        earlier = next((key for key in parent.keys if key.value == node.value), None)
        parent.keys.append(node)
        if earlier is not None:
            message = f"the key is given twice, first on line {earlier.line + 1}"
            raise self.problem(message, "", node.line)

    def problem(self, message: str, allowed: str, line: int) -> ProgramError:
        """An error at the place where the parser is."""
        return ProgramError((Problem(self.path, message, allowed, line + 1),))


def _label(node: Node) -> str | None:
    """What names a list item in a path: its id, else its name, as far as it was read."""
    known = {key.value: child.value for key, child in zip(node.keys, node.children, strict=False)}
    label = known.get("id", known.get("name"))
    return label if isinstance(label, str) else None


def parse(text: str, limit: int = MAX_CHARACTERS) -> Node:
    """The tree of a YAML text of at most `limit` characters, or a `ProgramError` with path and
    line."""
    if len(text) > limit:
        message = f"the text has {len(text)} characters"
        raise ProgramError((Problem("", message, f"at most {limit}", 1),))
    builder = _Builder()
    try:
        for event in yaml.parse(text, Loader=yaml.SafeLoader):
            _take(builder, event)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = 0 if mark is None else mark.line
        words = " ".join(part for part in (error.context, error.problem) if part)
        raise builder.problem(f"is not valid YAML: {words}", "", line) from error
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position)
        message = f"holds a character that YAML does not allow (U+{ord(text[error.position]):04X})"
        raise builder.problem(message, "", line) from error
    if builder.root is None:
        raise ProgramError((Problem("", "the text is empty", "a mapping", 1),))
    return builder.root


def _take(builder: _Builder, event: yaml.Event) -> None:
    line = event.start_mark.line if event.start_mark is not None else 0
    if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None) is not None:
        raise builder.problem("anchors and aliases are not allowed", "write the value", line)
    if getattr(event, "tag", None) is not None:
        raise builder.problem("tags are not allowed", "write the value without !", line)
    match event:
        case yaml.DocumentStartEvent():
            if builder.root is not None:
                raise builder.problem("there is a second document", "one program a text", line)
        case yaml.ScalarEvent():
            builder.place(_scalar(builder, event))
        case yaml.MappingStartEvent() | yaml.SequenceStartEvent():
            if len(builder.stack) >= MAX_DEPTH:
                raise builder.problem("is nested too deeply", f"{MAX_DEPTH} levels", line)
            kind = "mapping" if isinstance(event, yaml.MappingStartEvent) else "sequence"
            node = Node(kind, line)
            builder.place(node)
            builder.stack.append(node)
        case yaml.MappingEndEvent() | yaml.SequenceEndEvent():
            builder.stack.pop()
        case _:
            pass


def _scalar(builder: _Builder, event: yaml.ScalarEvent) -> Node:
    line = event.start_mark.line
    if event.style is not None:
        return Node("scalar", line, event.value)
    try:
        return Node("scalar", line, resolve(event.value))
    except ValueError as error:
        raise builder.problem(str(error), "", line) from error


def resolve(text: str) -> Scalar:
    """What an unquoted scalar means (the core schema of YAML 1.2, its traps refused)."""
    if text in _NULL:
        return None
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    if _ENDLESS.match(text):
        raise ValueError(f"{text} is not a finite number")
    if not _NUMBER.match(text):
        return text
    if _LEADING_ZERO.match(text):
        raise ValueError(f"{text} has a leading zero; drop it, or quote it if it is a word")
    if _INTEGER.match(text):
        return int(text)
    value = float(text)
    if abs(value) > 1e300:
        raise ValueError(f"{text} is not a finite number")
    return value
