"""A form as a tree of fields, made from a pydantic model's schema."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import BaseModel, TypeAdapter

from physagent_studio.studio.panels.seeds import Schema, Seeds, name_list, resolved
from physagent_studio.studio.panels.words import unit_of

HIDDEN = frozenset({"grounding", "source", "kind", "operator", "id", "name", "form"})
"""Fields that a form leaves out: what the photo's tools set, and what names the thing."""

LABELS = {
    "start_step": "Starts at",
    "duration": "Lasts",
    "when": "Starts",
    "muted": "Muted",
    "position": "Position",
    "rotation": "Rotation (w, x, y, z)",
    "density": "Density",
    "friction": "Friction",
    "restitution": "Bounciness",
    "rolling": "Rolling resistance",
    "wheels": "Runs on wheels",
    "heading": "Front points to",
    "grip": "Grip across",
    "known": "Front is certain",
    "support": "Stands on",
    "material": "Material",
    "shape": "Shape",
    "body": "Held together as",
    "a": "One thing",
    "b": "The other",
    "timeout": "Not later than",
    "delay": "Later by",
    "from_step": "Counts from",
    "to_step": "Counts up to",
    "focal": "Focal length",
    "principal": "Optical centre",
    "horizon_sigma": "Horizon, give or take",
    "confirmed": "Known for certain",
    "negated": "Must not happen",
    "clause": "Serves the words",
    "subject": "Who",
    "other": "With what",
    "on": "Lies on",
    "playback_fps": "Frames a second",
    "point": "At the point",
    "point_frame": "Counted from",
}
KINDS = {
    "on_contact": "when two things touch",
    "after": "after another action",
    "when": "when something has happened",
    "sphere": "ball",
    "frustum": "cone or cup",
    "torus": "ring",
    "revolved": "round, by its outline",
    "inflated": "its outline, rounded",
    "Wheels": "wheels",
    "floor": "level ground",
    "Directed": "strength and aim",
    "vector": "three numbers",
}
"""Kinds of values in words, where their own name says too little."""
UNSEEDED = frozenset({"revolved", "inflated", "mesh"})
"""Shapes that come from a photo or a file, so that they cannot be chosen from nothing."""


@cache
def _schema(model: type[BaseModel]) -> tuple[Schema, Schema]:
    schema = TypeAdapter(model).json_schema()
    return schema, schema.get("$defs", {})


@dataclass(frozen=True, slots=True)
class Form:
    """The form of a model. Every field carries the path of the edit that it makes.

    seeds: the values that a field begins with when another kind is chosen for it.
    """

    model: type[BaseModel]
    seeds: Seeds

    def fields(self, path: str, data: dict[str, Any]) -> list[dict[str, Any]]:
        """The fields of a value of the model that lies at a path of the program."""
        schema, _ = _schema(self.model)
        return [
            self._field(f"{path}.{key}", key, part, data.get(key))
            for key, part in schema["properties"].items()
            if key not in HIDDEN
        ]

    def _field(self, path: str, key: str, schema: Schema, value: Any) -> dict[str, Any]:
        """One field, with its choices where the model allows several kinds of value."""
        field: dict[str, Any] = {
            "path": path,
            "label": LABELS.get(key, key.replace("_", " ").capitalize()),
            "value": value,
            "unit": unit_of(path),
        }
        options = self._alternatives(schema)
        field["optional"] = any(one.get("type") == "null" for one in options)
        kinds = [one for one in options if one.get("type") != "null"]
        # What may be absent as a whole is chosen before there are parts of it to change.
        whole = field["optional"] and len(kinds) == 1 and kinds[0].get("type") == "object"
        if len(kinds) == 1 and not whole:
            field.update(self._one_kind(path, key, kinds[0], value))
        else:
            choices = [self._choice(path, key, one, value) for one in kinds]
            field["choices"] = [one for one in choices if one["seed"] is not None]
            field["kind"] = "choice"
        return field

    def _alternatives(self, schema: Schema) -> list[Schema]:
        """What a value may be, with choices inside of choices laid side by side."""
        schema = resolved(schema, self._definitions)
        nested = schema.get("anyOf") or schema.get("oneOf")
        return [flat for one in nested for flat in self._alternatives(one)] if nested else [schema]

    @property
    def _definitions(self) -> Schema:
        return _schema(self.model)[1]

    def _one_kind(self, path: str, key: str, schema: Schema, value: Any) -> dict[str, Any]:
        kind = schema.get("type")
        if "const" in schema:
            return {"kind": "const", "value": schema["const"]}
        if "enum" in schema:
            return {"kind": "pick", "options": schema["enum"]}
        if kind == "boolean":
            return {"kind": "tick"}
        if kind in ("number", "integer"):
            return {"kind": "number", "whole": kind == "integer", **_bounds(schema)}
        if kind == "array" and "prefixItems" in schema:
            parts = [resolved(one, self._definitions) for one in schema["prefixItems"]]
            if all(one.get("type") in ("number", "integer") for one in parts):
                return {"kind": "vector", "count": len(parts), **_bounds(parts[0])}
        if kind == "object":
            return {"kind": "group", "fields": self._group(path, schema, value)}
        if kind == "string":
            return {"kind": "text", "names": name_list(key)}
        return {"kind": "data"}

    def _group(self, path: str, schema: Schema, value: Any) -> list[dict[str, Any]]:
        data = value if isinstance(value, dict) else {}
        return [
            self._field(f"{path}.{name}", name, part, data.get(name, part.get("default")))
            for name, part in schema.get("properties", {}).items()
            if name not in ("kind", "id")
        ]

    def _choice(self, path: str, key: str, schema: Schema, value: Any) -> dict[str, Any]:
        properties = schema.get("properties", {})
        tag = properties.get("kind", {}).get("const")
        chosen = isinstance(value, dict) and (tag is None or value.get("kind") == tag)
        # What is not chosen is only offered: fields of it would never be shown.
        if chosen or schema.get("type") != "object":
            made = self._one_kind(path, key, schema, value)
        else:
            made = {"kind": "group", "fields": []}
        names = {"group": schema.get("title", ""), "text": "name"}
        title = tag or names.get(made["kind"], made["kind"])
        made["title"] = KINDS.get(title, title.replace("_", " "))
        made["tag"] = tag
        seed = None if tag in UNSEEDED else self.seeds.value(key, schema, self._definitions)
        made["seed"] = value if chosen and seed is None else seed
        return made


def _bounds(schema: Schema) -> dict[str, Any]:
    low = schema.get("minimum", schema.get("exclusiveMinimum"))
    high = schema.get("maximum", schema.get("exclusiveMaximum"))
    return {"min": low, "max": high}
