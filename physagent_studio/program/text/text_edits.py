"""Edits applied to a person's own text: only the lines concerned change.

Each edit is cut into the text by the places of its nodes. After each cut the text is read again;
where a layout is too unusual for the cut, the smallest collection around it is written anew, and
comments and order outside it still stay.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from physagent_studio.errors import ProgramError
from physagent_studio.program.edits import AddItem, Edit, MoveItem, RemoveItem, SetField, apply
from physagent_studio.program.text.document import (
    dump_entry,
    dump_flow,
    dump_program,
    dump_value,
    program_of,
)
from physagent_studio.program.text.plain_edits import Trail, edit_plain
from physagent_studio.program.text.yaml_nodes import Node, Plain, parse


def edit_text(text: str, edits: Iterable[Edit]) -> str:
    """The text with all edits applied, so that `load_program` of it is `apply` of the edits.

    Raises `EditError` or `ProgramError` as `apply` does, and then nothing is changed.
    """
    edits = tuple(edits)
    root = parse(text)
    program = program_of(root)
    target = apply(program, edits)
    data = program.model_dump(mode="json")
    for edit in edits:
        edit_plain(data, edit, data)
        text = _edited(text, edit, data)
    try:
        same = program_of(parse(text)) == target
    except ProgramError:
        same = False
    return text if same else dump_program(target)


def _edited(text: str, edit: Edit, data: Any) -> str:
    """The text after one edit; `data` is the whole program after it, defaults written out."""
    root = parse(text)
    expected = root.plain()
    trail = edit_plain(expected, edit, data)
    for attempt in _attempts(text, root, edit, expected, trail):
        if _means(attempt, expected):
            return attempt
    assert isinstance(expected, dict)
    return "".join(dump_entry(key, value) for key, value in expected.items())


def _means(text: str, expected: Plain) -> bool:
    try:
        return parse(text).plain() == expected
    except ProgramError:
        return False


def _attempts(text: str, root: Node, edit: Edit, expected: Plain, trail: Trail) -> Iterator[str]:
    """The finest cut first, then ever larger collections written anew."""
    cut = _Cut(text, root)
    local = cut.apply(edit, expected, trail)
    if local is not None:
        yield local
    for depth in range(len(trail) - 1, 0, -1):
        value = _follow(expected, trail[:depth])
        rewritten = cut.replace(trail[:depth], value, in_block=True)
        if rewritten is not None:
            yield rewritten


def _follow(data: Any, trail: Trail) -> Any:
    for key in trail:
        data = data[key]
    return data


# --- the edit on the text ----------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class _Cut:
    """A text and its tree; every method gives the new text, or None where it does not apply."""

    text: str
    root: Node

    @property
    def newline(self) -> str:
        """How lines end here."""
        return "\r\n" if "\r\n" in self.text else "\n"

    def node(self, trail: Trail) -> Node | None:
        """The node at a trail."""
        node: Node | None = self.root
        for key in trail:
            if node is None:
                return None
            if isinstance(key, str):
                node = node.get(key) if node.kind == "mapping" else None
            else:
                inside = node.kind == "sequence" and key < len(node.children)
                node = node.children[key] if inside else None
        return node

    def apply(self, edit: Edit, expected: Plain, trail: Trail) -> str | None:
        """The finest cut for an edit whose result is `expected`."""
        if not trail:
            return None
        match edit:
            case SetField():
                return self.replace(trail, _follow(expected, trail))
            case AddItem() if isinstance(trail[-1], int):
                return self.insert(trail[:-1], trail[-1], _follow(expected, trail))
            case RemoveItem() if isinstance(trail[-1], int):
                return self.remove(trail[:-1], trail[-1])
            case MoveItem() if isinstance(trail[-1], int):
                return self.move(trail[:-1], trail[-1], edit.index)
        return self.replace(trail, _follow(expected, trail))

    # Values of mappings and items, written in place or anew.

    def replace(self, trail: Trail, value: Any, in_block: bool = False) -> str | None:
        """Puts a value where another stands, or adds the key that the text leaves out."""
        parent, key = self.node(trail[:-1]), trail[-1]
        if parent is None:
            return None
        node = self.node(trail)
        if node is None:
            return self._new_key(parent, str(key), value) if isinstance(key, str) else None
        one_line = dump_flow(value)
        simple = "\n" not in value if isinstance(value, str) else True
        if isinstance(value, dict | list):
            simple = self._fits(node, one_line, in_block)
        if parent.flow or (node.flow and simple and "\n" not in one_line):
            gap = " " if node.start == node.end and not parent.flow else ""
            return self._spliced(node.start, node.end, gap + one_line)
        if isinstance(key, int):
            block = self._shifted(dump_value(value), node.column, first=False)
            return self._spliced(node.start, node.end, block)
        name = next(one for one in parent.keys if one.value == key)
        block = self._shifted(dump_entry(str(key), value), name.column, first=False)
        return self._spliced(name.start, node.end, block)

    def _fits(self, node: Node, one_line: str, in_block: bool) -> bool:
        """Whether a collection written in one line may stay so."""
        column = node.start - self._line_start(node.start)
        return not in_block and node.kind != "scalar" and column + len(one_line) <= 100

    def _new_key(self, parent: Node, key: str, value: Any) -> str | None:
        if parent.kind != "mapping":
            return None
        if parent.flow:
            entry = dump_flow({key: value})[1:-1]
            last = parent.children[-1].end if parent.children else parent.start + 1
            return self._spliced(last, last, f", {entry}" if parent.children else entry)
        block = self._shifted(dump_entry(key, value), parent.column, first=True)
        return self._line_after(parent.end, block)

    # Items of sequences.

    def insert(self, trail: Trail, index: int, value: Any) -> str | None:
        """Adds an item to a sequence."""
        node = self.node(trail)
        if node is None or node.kind != "sequence":
            return None
        if not node.children:
            return self.replace(trail, [value], in_block=True)
        if node.flow:
            return self._insert_flow(node, index, dump_flow(value))
        return self._insert_block(node, index, self._item(value, node.column))

    def _insert_flow(self, node: Node, index: int, piece: str) -> str:
        if index < len(node.children):
            start = node.children[index].start
            return self._spliced(start, start, f"{piece}, ")
        end = node.children[-1].end
        return self._spliced(end, end, f", {piece}")

    def _insert_block(self, node: Node, index: int, block: str) -> str | None:
        if index > 0:
            return self._line_after(node.children[index - 1].end, block)
        start = self._item_start(node, 0)
        return None if start is None else self._spliced(start, start, block + self.newline)

    def _item(self, value: Any, column: int) -> str:
        lines = dump_value(value).rstrip("\n").split("\n")
        text = "\n".join(f"{'- ' if row == 0 else '  '}{line}" for row, line in enumerate(lines))
        return self._shifted(text, column, first=True)

    def remove(self, trail: Trail, index: int) -> str | None:
        """Takes an item out of a sequence."""
        node = self.node(trail)
        if node is None or node.kind != "sequence":
            return None
        if len(node.children) == 1:
            return self.replace(trail, [])
        span = self._span(node, index)
        return None if span is None else self._spliced(span[0], span[1], "")

    def move(self, trail: Trail, index: int, to: int) -> str | None:
        """Moves an item, its own comments included."""
        node = self.node(trail)
        if node is None or node.kind != "sequence" or len(node.children) < 2:
            return None
        if node.flow:
            child = node.children[index]
            piece = self.text[child.start : child.end]
        else:
            span = self._span(node, index)
            if span is None:
                return None
            piece = self.text[span[0] : span[1]].rstrip("\r\n")
        without = self.remove(trail, index)
        if without is None:
            return None
        rest = _Cut(without, parse(without))
        left = rest.node(trail)
        if left is None:
            return None
        return (
            rest._insert_flow(left, to, piece) if node.flow else rest._insert_block(left, to, piece)
        )

    def _span(self, node: Node, index: int) -> tuple[int, int] | None:
        """Characters of an item with its separator or its lines."""
        child = node.children[index]
        if node.flow:
            if index + 1 < len(node.children):
                return child.start, node.children[index + 1].start
            return node.children[index - 1].end, child.end
        start = self._item_start(node, index)
        if start is None:
            return None
        return start, self._after_line(child.end)

    def _item_start(self, node: Node, index: int) -> int | None:
        """Start of the line with an item's dash, if nothing else stands before the dash."""
        before = self.text[: node.children[index].start].rstrip()
        start = self._line_start(len(before))
        if not before.endswith("-") or before[start:-1].strip():
            return None
        return start

    # Lines.

    def _line_start(self, index: int) -> int:
        return self.text.rfind("\n", 0, index) + 1

    def _after_line(self, index: int) -> int:
        """The first character of the line after the one that holds `index`."""
        if index > 0 and self.text[index - 1 : index] == "\n":
            return index
        end = self.text.find("\n", index)
        return len(self.text) if end < 0 else end + 1

    def _line_after(self, index: int, block: str) -> str:
        at = self._after_line(index)
        lead = "" if at == 0 or self.text[at - 1] == "\n" else self.newline
        return self._spliced(at, at, lead + block + self.newline)

    def _shifted(self, text: str, column: int, first: bool) -> str:
        lines = text.rstrip("\n").split("\n")
        pad = " " * column
        rows = [
            pad + line if line and (first or row > 0) else line for row, line in enumerate(lines)
        ]
        return self.newline.join(rows)

    def _spliced(self, start: int, end: int, piece: str) -> str:
        # A block scalar ends after its last line break, which then has to stay.
        if end > start and self.text[end - 1] == "\n" and piece and not piece.endswith("\n"):
            piece += self.newline
        return self.text[:start] + piece + self.text[end:]
