"""Turns pydantic's findings into `Problem`s with readable paths, allowed values and lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from physagent_studio.errors import Problem


def problems_of(
    error: ValidationError, data: Any, lines: Mapping[tuple[str | int, ...], int] | None = None
) -> tuple[Problem, ...]:
    """Every finding of `error` over the plain `data` that was validated.

    lines: 1-based line of each raw location (keys and indices) in the person's text.
    """
    found: list[Problem] = []
    for item in error.errors(include_url=False):
        location = _real(item["loc"], data)
        line = _line(location, lines)
        if item["type"] == "value_error" and "|" in item["msg"]:
            found += _own(item["msg"], data, lines)
        else:
            found.append(Problem(path_of(location, data), _message(item), _allowed(item), line))
    return tuple(found)


def path_of(location: tuple[str | int, ...], data: Any) -> str:
    """A dotted path that names list items by id or name where they have one."""
    parts, node = [], data
    for key in location:
        try:
            node = node[key]
        except (KeyError, IndexError, TypeError):
            node = None
        label = node.get("id", node.get("name")) if isinstance(node, dict) else None
        parts.append(str(label) if isinstance(key, int) and isinstance(label, str) else str(key))
    return ".".join(parts)


def _real(location: tuple[str | int, ...], data: Any) -> tuple[str | int, ...]:
    """The location without the names of union members that pydantic mixes into it."""
    real: list[str | int] = []
    node = data
    for position, key in enumerate(location):
        last = position == len(location) - 1
        if isinstance(node, dict) and isinstance(key, str) and (key in node or last):
            real.append(key)
            node = node.get(key)
        elif isinstance(node, list) and isinstance(key, int):
            real.append(key)
            node = node[key] if key < len(node) else None
    return tuple(real)


def _line(
    location: tuple[str | int, ...], lines: Mapping[tuple[str | int, ...], int] | None
) -> int | None:
    if lines is None:
        return None
    while location not in lines and location:
        location = location[:-1]
    return lines.get(location)


def _own(
    message: str, data: Any, lines: Mapping[tuple[str | int, ...], int] | None
) -> list[Problem]:
    """The findings of the program's own cross checks: "path|message|allowed" on each line."""
    found = []
    for row in message.removeprefix("Value error, ").splitlines():
        path, text, allowed = (*row.split("|"), "", "")[:3]
        found.append(Problem(path, text, allowed, _line(_location(path, data), lines)))
    return found


def _location(path: str, data: Any) -> tuple[str | int, ...]:
    """Raw keys and indices of a dotted path, as far as they exist."""
    location: list[str | int] = []
    node = data
    for part in path.split("."):
        if isinstance(node, dict) and part in node:
            key: str | int = part
        elif isinstance(node, list):
            labels = [
                item.get("id", item.get("name")) if isinstance(item, dict) else None
                for item in node
            ]
            if part not in labels:
                break
            key = labels.index(part)
        else:
            break
        location.append(key)
        node = node[key]
    return tuple(location)


def _message(item: Any) -> str:
    kind, value = item["type"], item.get("input")
    if kind == "missing":
        return "is missing"
    if kind == "extra_forbidden":
        return "is not a known field"
    text = item["msg"].removeprefix("Value error, ")
    if isinstance(value, bool | int | float | str) and len(str(value)) <= 60:
        return f"{text[0].lower()}{text[1:]}, not {value!r}"
    return f"{text[0].lower()}{text[1:]}"


def _allowed(item: Any) -> str:
    context = item.get("ctx") or {}
    if "expected_tags" in context:
        return f"known: {str(context['expected_tags']).replace(chr(39), '')}"
    return ""
