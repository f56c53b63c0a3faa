"""JSON Schema for structured output, made from the pydantic models.

Servers that enforce a schema know a subset of the language: every object closed, every property
required (an optional one may be null), no defaults, no tuples, no `oneOf`. `strict_schema` says
the same in that subset; `without_nulls` undoes it in a reply, so that defaults apply again.
"""

import functools
import types
import typing
from typing import Any

from pydantic import BaseModel

_DROPPED = frozenset({"title", "default", "discriminator", "description", "pattern", "examples"})
_DROPPED |= {"minLength", "maxLength", "exclusiveMinimum", "exclusiveMaximum"}


@functools.cache
def strict_schema(model: type[BaseModel]) -> dict[str, Any]:
    """The model's JSON Schema in the subset that structured output enforces; not to be changed."""
    return _strict(model.model_json_schema())


def _strict(node: Any) -> Any:
    if isinstance(node, list):
        return [_strict(item) for item in node]
    if not isinstance(node, dict):
        return node
    found = {key: value for key, value in node.items() if key not in _DROPPED}
    if "oneOf" in found:
        found["anyOf"] = found.pop("oneOf")
    if "const" in found:
        found["enum"] = [found.pop("const")]
    if "prefixItems" in found:
        found["items"] = _one_of(found.pop("prefixItems"))
    for room in ("properties", "$defs"):
        if room in found:
            found[room] = {name: _strict(value) for name, value in found[room].items()}
    for key in ("anyOf", "items"):
        if key in found:
            found[key] = _strict(found[key])
    if found.get("type") == "object":
        _close(found, set(node.get("required", ())))
    return found


def _one_of(items: list[Any]) -> Any:
    different = [item for index, item in enumerate(items) if item not in items[:index]]
    return different[0] if len(different) == 1 else {"anyOf": different}


def _close(found: dict[str, Any], required: set[str]) -> None:
    properties = found.setdefault("properties", {})
    for name, value in properties.items():
        # A tag with a single value stays as it is: null would say nothing.
        if name not in required and len(value.get("enum", ())) != 1:
            properties[name] = _nullable(value)
    found["additionalProperties"] = False
    found["required"] = list(properties)


def _nullable(value: dict[str, Any]) -> dict[str, Any]:
    options = value.get("anyOf", [value])
    if {"type": "null"} in options:
        return value
    return {"anyOf": [*options, {"type": "null"}]}


def without_nulls(data: Any, model: type[BaseModel]) -> Any:
    """The reply with every null left out where the field has a default that is not null.

    Only fields whose own value is null in the model keep it, so that a null that means
    something (an open field, no landmark) survives.
    """
    if not isinstance(data, dict):
        return data
    kept: dict[str, Any] = {}
    for name, value in data.items():
        field = model.model_fields.get(name)
        if value is None and field is not None and not field.is_required():
            continue
        inner = [] if field is None else _models(field.annotation)
        kept[name] = _inner(value, inner)
    return kept


def _inner(value: Any, models: list[type[BaseModel]]) -> Any:
    if isinstance(value, list):
        return [_inner(item, models) for item in value]
    if not isinstance(value, dict) or not models:
        return value
    return without_nulls(value, _meant(value, models))


def _meant(value: dict[str, Any], models: list[type[BaseModel]]) -> type[BaseModel]:
    """The member of a union that the tags of a reply name, else the one that shares most fields."""
    for model in models:
        for tag in ("operator", "kind", "op"):
            field = model.model_fields.get(tag)
            if field is not None and tag in value and field.default == value[tag]:
                return model
    return max(models, key=lambda model: len(model.model_fields.keys() & value.keys()))


def _models(annotation: Any) -> list[type[BaseModel]]:
    """All model classes in an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if typing.get_origin(annotation) in (
        typing.Union,
        types.UnionType,
        tuple,
        list,
        typing.Annotated,
    ):
        return [found for arg in typing.get_args(annotation) for found in _models(arg)]
    return []
