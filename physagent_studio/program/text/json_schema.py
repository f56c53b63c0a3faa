"""The published JSON Schema of a program, and the names that it allows at a place."""

import functools
from typing import Any

from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.text.yaml_nodes import Location


@functools.cache
def _schema() -> dict[str, Any]:
    return PhysicalProgram.model_json_schema()


def json_schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of `PhysicalProgram`; VLM structured output uses the same one."""
    schema = dict(_schema())
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return schema


def fields_at(location: Location, data: Any) -> tuple[str, ...]:
    """Names of the fields that a program has at a location of the plain `data`."""
    found: list[str] = []
    for branch in _branches(_at(location, data), _value(location, data)):
        found += [name for name in branch.get("properties", {}) if name not in found]
    return tuple(found)


def tags_at(location: Location, data: Any) -> tuple[str, ...]:
    """The kinds (or operators) that the value at a location of the plain `data` may have."""
    pending, found = [_at(location, data)], list[str]()
    while pending:
        node = pending.pop()
        found += node.get("discriminator", {}).get("mapping", {})
        if not found:
            pending += [part for word in ("oneOf", "anyOf") for part in node.get(word, ())]
    return tuple(found)


def _value(location: Location, data: Any) -> Any:
    for key in location:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _at(location: Location, data: Any) -> dict[str, Any]:
    """The schema of the value at a location, branches chosen by what the data say there."""
    node = _schema()
    for depth, key in enumerate(location):
        value = _value(location[:depth], data)
        for branch in _branches(node, value):
            child = _child(branch, key)
            if child is not None:
                node = child
                break
        else:
            return {}
    return node


def _child(branch: dict[str, Any], key: str | int) -> dict[str, Any] | None:
    if isinstance(key, str):
        return branch.get("properties", {}).get(key)
    prefix = branch.get("prefixItems", [])
    return prefix[key] if key < len(prefix) else branch.get("items")


def _branches(node: dict[str, Any], value: Any) -> list[dict[str, Any]]:
    """The schemas that a node stands for; of a tagged union only the one that the data name."""
    if "$ref" in node:
        return _branches(_schema()["$defs"][node["$ref"].rpartition("/")[2]], value)
    if "discriminator" in node and isinstance(value, dict):
        tag = value.get(node["discriminator"]["propertyName"])
        target = node["discriminator"]["mapping"].get(tag) if isinstance(tag, str) else None
        if target is not None:
            return _branches({"$ref": target}, value)
    for word in ("oneOf", "anyOf", "allOf"):
        if word in node:
            return [branch for part in node[word] for branch in _branches(part, value)]
    return [node]
