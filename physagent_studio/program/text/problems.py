"""Turns pydantic's findings into `Problem`s with readable paths, allowed values and lines."""

import difflib
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pydantic import ValidationError

from physagent_studio.errors import Problem
from physagent_studio.program.text.yaml_nodes import Location

Fields = Callable[[Location], tuple[str, ...]]
MOST = 50
"""So many problems are told; a text with more has one cause."""


def problems_of(
    error: ValidationError,
    data: Any,
    lines: Mapping[Location, int] | None = None,
    fields: Fields | None = None,
    tags: Fields | None = None,
) -> tuple[Problem, ...]:
    """Every finding of `error` over the plain `data` that was validated.

    lines: 1-based line of each raw location (keys and indices) in the person's text.
    fields: the names that exist at a location, for the nearest known one. tags: the kinds that
    a value at a location may have.
    """
    found: list[Problem] = []
    for item in error.errors(include_url=False)[:MOST]:
        location = _real(item["loc"], data, item["type"] == "missing")
        if item["type"] == "union_tag_invalid":
            location = (*location, item.get("ctx", {})["discriminator"].strip("'"))
        if item["type"] == "value_error" and "|" in item["msg"]:
            found += _own(item["msg"], data, lines)
        else:
            line = line_of(location, lines)
            message, allowed = _told(item, location, fields, tags)
            found.append(Problem(path_of(location, data), message, allowed, line))
    return tuple(found[:MOST])


def path_of(location: Location, data: Any) -> str:
    """A dotted path that names list items by id or name where they have one."""
    parts: list[str] = []
    node: Any = data
    for key in location:
        node = _step(node, key)
        label = label_of(node) if isinstance(key, int) else None
        parts.append(str(key) if label is None else label)
    return ".".join(_short(part) for part in parts)


def _step(node: Any, key: str | int) -> Any:
    """The part of plain data under a key, or None."""
    if isinstance(node, dict):
        return node.get(key)
    if isinstance(node, list) and isinstance(key, int) and -len(node) <= key < len(node):
        return node[key]
    return None


def _short(text: str) -> str:
    return text if len(text) <= 80 else text[:77] + "…"


def _real(raw: Location, data: Any, missing: bool) -> Location:
    """The location without the names of union members that pydantic mixes into it."""
    real: list[str | int] = []
    node = data
    for position, key in enumerate(raw):
        last = missing and position == len(raw) - 1
        if isinstance(node, dict) and isinstance(key, str) and (key in node or last):
            real.append(key)
            node = node.get(key)
        elif isinstance(node, list) and isinstance(key, int):
            real.append(key)
            node = _step(node, key)
    return tuple(real)


def line_of(location: Location, lines: Mapping[Location, int] | None) -> int | None:
    """The line of a location, or of the nearest place above it that is in the text."""
    if lines is None:
        return None
    while location not in lines and location:
        location = location[:-1]
    return lines.get(location)


def _own(message: str, data: Any, lines: Mapping[Location, int] | None) -> list[Problem]:
    """The findings of the program's own cross checks: "path|message|allowed" on each line."""
    found = []
    for row in message.removeprefix("Value error, ").splitlines():
        path, text, allowed = (*row.split("|"), "", "")[:3]
        if allowed.startswith("known: "):
            wanted = re.search(r"'([^']*)'$", text)
            text += hint(wanted.group(1), allowed[7:].split(", ")) if wanted else ""
        line = line_of(location_of(path, data), lines)
        found.append(Problem(path, text, allowed, line))
    return found


def location_of(path: str, data: Any) -> Location:
    """Raw keys and indices of a dotted path, as far as they exist."""
    location: list[str | int] = []
    node: Any = data
    for part in path.split("."):
        key: str | int
        if isinstance(node, dict) and part in node:
            key = part
        elif isinstance(node, list):
            labels = [label_of(item) for item in node]
            if part in labels:
                key = labels.index(part)
            elif part.isdecimal() and int(part) < len(node):
                key = int(part)
            else:
                break
        else:
            break
        location.append(key)
        node = _step(node, key)
    return tuple(location)


def hint(word: str, known: Iterable[str]) -> str:
    """For the end of a message: the known name that `word` most likely means, or ""."""
    lower = {choice.lower(): choice for choice in known}
    found = difflib.get_close_matches(word.lower(), list(lower), n=1, cutoff=0.6)
    return f"; did you mean '{lower[found[0]]}'?" if found else ""


def label_of(item: Any) -> str | None:
    """What names a list item in a path: its id, else its name."""
    label = item.get("id", item.get("name")) if isinstance(item, dict) else None
    return label if isinstance(label, str) else None


# --- one finding ------------------------------------------------------------------------------


def _told(
    item: Any, location: Location, fields: Fields | None, tags: Fields | None
) -> tuple[str, str]:
    """What is wrong and what is allowed."""
    kind, context = item["type"], item.get("ctx") or {}
    if kind == "missing":
        return "is missing", ""
    if kind == "extra_forbidden":
        return _unknown_field(location, fields)
    if kind == "union_tag_not_found":
        tag = context["discriminator"].strip("'")
        known = ", ".join(tags(location)) if tags is not None else ""
        return f"does not say which {tag} it is", f"{tag}: {known}" if known else ""
    if kind == "union_tag_invalid":
        tag, given = context["discriminator"].strip("'"), str(context["tag"])
        meant = hint(given, _names(context))
        return f"there is no {tag} '{_short(given)}'{meant}", f"known: {_listed(context)}"
    return _told_of_value(item, kind, context)


def _unknown_field(location: Location, fields: Fields | None) -> tuple[str, str]:
    known = fields(location[:-1]) if fields is not None and location else ()
    meant = hint(str(location[-1]), known) if location else ""
    return f"is not a known field{meant}", f"fields: {', '.join(known)}" if known else ""


def _names(context: Any) -> list[str]:
    return re.findall(r"'([^']*)'", str(context.get("expected_tags", context.get("expected", ""))))


def _listed(context: Any) -> str:
    return ", ".join(_names(context))


_LIMITS = {
    "greater_than": ("must be more than {gt}", "gt"),
    "greater_than_equal": ("must be at least {ge}", "ge"),
    "less_than": ("must be less than {lt}", "lt"),
    "less_than_equal": ("must be at most {le}", "le"),
}
_TYPES = {
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "int_type": "must be a whole number",
    "int_parsing": "must be a whole number",
    "int_from_float": "must be a whole number",
    "int_parsing_size": "is too large",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
    "string_type": "must be a word",
    "tuple_type": "must be a list",
    "list_type": "must be a list",
    "dict_type": "must be a mapping",
    "model_type": "must be a mapping",
    "model_attributes_type": "must be a mapping",
    "finite_number": "must be a finite number",
    "none_required": "must be left out",
}


def _told_of_value(item: Any, kind: str, context: Any) -> tuple[str, str]:
    """A value of the wrong type, size or wording."""
    given = _given(item.get("input"))
    if kind in _LIMITS:
        words, key = _LIMITS[kind]
        return words.format(**{key: f"{context[key]:g}"}) + given, ""
    if kind in _TYPES:
        return _TYPES[kind] + given, ""
    if kind == "literal_error":
        meant = hint(str(item.get("input")), _names(context))
        return f"must be one of the allowed words{given}{meant}", _listed(context)
    if kind == "string_pattern_mismatch":
        return f"is not a name{given}", "letters, digits, _ and -, at most 64"
    if kind in ("too_long", "too_short"):
        limit = context.get("max_length", context.get("min_length"))
        word = "at most" if kind == "too_long" else "at least"
        return f"has {context.get('actual_length')} items", f"{word} {limit}"
    if kind == "string_too_long":
        return "is too long", f"at most {context['max_length']} characters"
    text = item["msg"].removeprefix("Value error, ")
    return f"{text[:1].lower()}{text[1:]}{given}", ""


def _given(value: Any) -> str:
    """The value itself, where it is short enough to show."""
    shown = isinstance(value, bool | int | float | str) and len(str(value)) <= 60
    return f", not {value!r}" if shown else ""
