"""Edits applied to plain data that leaves out defaults, as a person's text does."""

from __future__ import annotations

import copy
from typing import Any

from physagent_studio.program.edits import AddItem, Edit, MoveItem, RemoveItem, SetField

Trail = tuple[str | int, ...]


def _label(item: Any) -> str | None:
    if not isinstance(item, dict):
        return None
    label = item.get("id", item.get("name"))
    return label if isinstance(label, str) else None


def _key_in(node: Any, part: str) -> str | int | None:
    """The key or index of a path's part in plain data, or None where the text leaves it out."""
    if isinstance(node, dict):
        return part if part in node else None
    if isinstance(node, list):
        for index, item in enumerate(node):
            if _label(item) == part:
                return index
        if part.isdecimal() and int(part) < len(node):
            return int(part)
    return None


def edit_plain(data: Any, edit: Edit, full: Any) -> Trail:
    """Applies an edit to plain data in place; the trail to what changed.

    What the text leaves out is taken from `full`, the data with every default.
    """
    parts = edit.path.split(".")
    node, trail = data, []
    for position, part in enumerate(parts[:-1]):
        key = _key_in(node, part)
        if key is None:
            node[part] = _given_only(edit, parts[position:], full, parts[:position])
            return (*trail, part)
        trail.append(key)
        node = node[key]
    key = _key_in(node, parts[-1])
    match edit:
        case SetField():
            key = parts[-1] if key is None else key
            node[key] = copy.deepcopy(edit.value)
        case AddItem():
            if key is None:
                node[parts[-1]] = []
                key = parts[-1]
            index = len(node[key]) if edit.index is None else edit.index
            node[key].insert(index, copy.deepcopy(edit.item))
            return (*trail, key, index)
        case RemoveItem():
            del node[key]
        case MoveItem():
            node.insert(edit.index, node.pop(key))
    return (*trail, key) if key is not None else tuple(trail)


def _given_only(edit: Edit, rest: list[str], full: Any, above: list[str]) -> Any:
    """The value of the first part that the text leaves out, no longer than it has to be."""
    if isinstance(edit, SetField) and not any(part.isdecimal() for part in rest):
        value: Any = copy.deepcopy(edit.value)
        for part in reversed(rest[1:]):
            value = {part: value}
        return value
    node = full
    for part in (*above, rest[0]):
        key = _key_in(node, part)
        node = node[key if key is not None else part]
    return copy.deepcopy(node)
