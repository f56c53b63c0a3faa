"""The action, statement and material references of the prompts, made from the published schema."""

import functools
import inspect
import typing
from typing import Any

from pydantic import BaseModel

from physagent_studio.program import MATERIALS, Action, Directed, Statement
from physagent_studio.program.actions import Condition
from physagent_studio.program.scene.bodies import Body
from physagent_studio.program.text.json_schema import json_schema

_COMMON_ACTION = ("id", "name", "start_step", "when", "muted")
_COMMON_STATEMENT = ("id", "clause", "negated", "from_step", "to_step")
_TAGS = ("operator", "kind")
MOST_OPTIONS = 8


def members(union: Any) -> tuple[type[BaseModel], ...]:
    """The models of a discriminated union, in order; unions within it are opened."""
    if isinstance(union, type):
        return (union,)
    parts = typing.get_args(union)
    # The first part of an `Annotated` is the type; the others say how to tell members apart.
    wanted = parts[:1] if typing.get_origin(union) is typing.Annotated else parts
    return tuple(found for part in wanted for found in members(part))


@functools.cache
def action_reference() -> str:
    """Every operator with its arguments, bounds and meaning, then directed vectors and starts."""
    common = _fields(members(Action)[0], only=_COMMON_ACTION)
    lines = [f"Every action: {common}", ""]
    lines += [_entry(model, "operator", skip=_COMMON_ACTION) for model in members(Action)]
    lines += ["", "A vector is [x, y, z] in the world frame, or directed:"]
    lines += [f"{{{_fields(Directed)}}}: {_says(Directed)}", "", "`when` replaces start_step:"]
    lines += [_entry(model, "kind") for model in members(Condition)]
    return "\n".join(lines)


@functools.cache
def statement_reference() -> str:
    """Every statement of a contract with its arguments, bounds and meaning."""
    common = _fields(members(Statement)[0], only=_COMMON_STATEMENT)
    lines = [f"Every statement: {common}", ""]
    lines += [_entry(model, "kind", skip=_COMMON_STATEMENT) for model in members(Statement)]
    return "\n".join(lines)


@functools.cache
def material_reference() -> str:
    """The materials table."""
    rows = [
        f"{name}: density {row.density:g} kg/m³, friction {row.friction:g}, "
        f"restitution {row.restitution:g}, rolling {row.rolling:g}"
        for name, row in MATERIALS.items()
    ]
    return "\n".join(rows)


@functools.cache
def body_reference() -> str:
    """How an object may hold together."""
    return "\n".join(_entry(model, "kind") for model in members(Body))


def _entry(model: type[BaseModel], tag: str, skip: tuple[str, ...] = ()) -> str:
    fields = _fields(model, skip=skip)
    value = model.model_fields[tag].default
    return f'- {{"{tag}": "{value}"{", " + fields if fields else ""}}}: {_says(model)}'


def _says(model: type[BaseModel]) -> str:
    return " ".join((inspect.getdoc(model) or "").split())


def _fields(model: type[BaseModel], skip: tuple[str, ...] = (), only: tuple[str, ...] = ()) -> str:
    defs = json_schema()["$defs"]
    schema = defs[model.__name__]
    required = set(schema.get("required", ()))
    parts = []
    for name, node in schema["properties"].items():
        if name in _TAGS or name in skip or (only and name not in only):
            continue
        text = f"{name}: {_type(node, defs)}"
        if name not in required and node.get("default") is not None:
            text += f" = {node['default']}".replace("False", "false").replace("True", "true")
        elif name not in required:
            text += " (optional)"
        parts.append(text)
    return ", ".join(parts)


def _type(node: dict[str, Any], defs: dict[str, Any]) -> str:
    if "enum" in node:
        return "|".join(str(value) for value in node["enum"])
    if "const" in node:
        return str(node["const"])
    for key in ("anyOf", "oneOf"):
        if key in node:
            options = [_type(item, defs) for item in node[key] if item.get("type") != "null"]
            if len(options) > MOST_OPTIONS:
                return "object"
            return " or ".join(dict.fromkeys(options))
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        inner = defs.get(name, {})
        return _type(inner, defs) if "enum" in inner else name
    if node.get("type") == "array":
        inner = node.get("prefixItems")
        if inner:
            kinds = list(dict.fromkeys(_type(item, defs) for item in inner))
            return f"[{len(inner)} × {' or '.join(kinds)}]"
        return f"list of {_type(node.get('items', {}), defs)}"
    return _scalar(node)


def _scalar(node: dict[str, Any]) -> str:
    kind = {"integer": "int", "number": "number", "boolean": "bool", "string": "name"}
    text = kind.get(str(node.get("type")), "value")
    low = node.get("minimum", node.get("exclusiveMinimum"))
    high = node.get("maximum", node.get("exclusiveMaximum"))
    return f"{text} {low:g}…{high:g}" if low is not None and high is not None else text
