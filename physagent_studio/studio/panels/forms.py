"""A form as a tree of fields, made from a pydantic model's schema, and what a field holds at first
when a person has chosen another kind for it.

First values are of the size of the thing at hand and speak of things that exist, so that a choice
is a valid program at once and there is something to change.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import BaseModel, TypeAdapter

from physagent_studio.program import PhysicalProgram, SceneObject, Support
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.program.scene.state import MeshedSupport, Ramp, Shape, Slab, Vessel
from physagent_studio.studio.panels.words import unit_of

Schema = dict[str, Any]
Size = tuple[float, float, float]


def name_list(key: str) -> str:
    """Which list of names a text field of that key offers; "" for none."""
    return {
        "material": "materials", "support": "supports", "on": "supports", "toward": "places",
        "a": "places", "b": "places", "action": "actions", "name": "objects",
        "subject": "objects", "other": "places", "landmark": "places", "near": "places",
        "before": "places", "clause": "clauses", "first": "statements", "second": "statements",
    }.get(key, "")  # fmt: skip


def resolved(schema: Schema, definitions: Schema) -> Schema:
    """The schema that a reference stands for."""
    while "$ref" in schema:
        schema = definitions[schema["$ref"].rpartition("/")[2]]
    return schema


@dataclass(frozen=True, slots=True)
class Seeds:
    """What there is to speak of: names of objects first, then of places; other actions; a size."""

    objects: tuple[str, ...]
    places: tuple[str, ...]
    actions: tuple[str, ...]
    size: Size
    middle: Size
    fixed: bool

    def value(self, key: str, schema: Schema, definitions: Schema) -> Any:
        """A first value of a kind; None where there is none to be had."""
        schema = resolved(schema, definitions)
        nested = schema.get("anyOf") or schema.get("oneOf")
        if nested:
            return self.value(key, nested[0], definitions)
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return schema["enum"][0]
        kind = schema.get("type")
        if kind == "object":
            return self._object(key, schema, definitions)
        if kind == "string":
            return self._name(key)
        if kind == "boolean":
            return False
        if kind in ("number", "integer"):
            return max(schema.get("minimum", 0), 1 if "exclusiveMinimum" in schema else 0)
        if kind == "array" and "prefixItems" in schema:
            return [0.0] * len(schema["prefixItems"])
        return None

    def _object(self, key: str, schema: Schema, definitions: Schema) -> Any:
        properties = schema.get("properties", {})
        tag = properties.get("kind", {}).get("const")
        if key == "shape":
            return (support_like if self.fixed else shape_like)(str(tag), self.size, self.middle)
        if schema.get("title") == "Directed":
            return {"magnitude": 1.0, "direction": "right"}
        made = {} if tag is None else {"kind": tag}
        for name in schema.get("required", ()):
            made[name] = self.value(name, properties[name], definitions)
            if made[name] is None:
                return None
        return made

    def _name(self, key: str) -> str | None:
        """A name that fits a field: the other thing is another one where there are two."""
        if key == "id":
            return "condition"
        if key == "action":
            return next(iter(self.actions), None)
        if name_list(key) == "objects" or key == "a":
            return next(iter(self.objects), None)
        first = next(iter(self.objects), None)
        return next((one for one in self.places if one != first), None)


def seeds_for(item: BaseModel, program: PhysicalProgram) -> Seeds:
    """What a form of an item of the program begins with."""
    scene = program.scene
    mine = getattr(item, "name", None)
    objects = tuple(one.name for one in scene.objects)
    if not isinstance(item, SceneObject | Support) and mine in objects:
        objects = (str(mine), *(one for one in objects if one != mine))
    places = (*objects, *(one.name for one in (*scene.supports, *scene.landmarks)))
    actions = tuple(one.id for one in program.event.actions if one.id != getattr(item, "id", None))
    size, middle = (0.2, 0.2, 0.2), (0.0, 1.5, 0.1)
    if isinstance(item, SceneObject | Support) and item.shape is not None:
        size, middle = _extent(item)
    return Seeds(objects, places, actions, size, middle, isinstance(item, Support))


def _extent(item: SceneObject | Support) -> tuple[Size, Size]:
    """Size and middle of a thing, m; of half-spaces something to look at."""
    if isinstance(item, SceneObject):
        assert item.shape is not None
        size = _sides(item.shape)
        return size, item.position or (0.0, 1.5, size[2] / 2)
    shape = item.shape
    if isinstance(shape, Slab | MeshedSupport):
        return shape.size, shape.position
    if isinstance(shape, Vessel):
        return _sides(shape.body), shape.position
    if isinstance(shape, Ramp):
        x, y, z = shape.toe
        return (shape.run, shape.width, shape.rise), (x + shape.run / 2, y, z + shape.rise / 2)
    return (1.0, 0.6, 0.4), (0.0, 1.5, 0.2)


def _sides(shape: Shape) -> Size:
    """Edges of the box around a shape, m."""
    x, y, z = (_neat(float(part)) for part in outline_of(shape).size)
    return x, y, z


def shape_like(kind: str, size: Size, _middle: Size) -> dict[str, Any] | None:
    """A shape of an object that fills about that box, m."""
    x, y, z = size
    wide = _neat(max(x, y) / 2)
    made: dict[str, dict[str, Any]] = {
        "sphere": {"radius": _neat(max(size) / 2)},
        "ellipsoid": {"radii": [_neat(part / 2) for part in size]},
        "box": {"size": list(size)},
        "cylinder": {"radius": wide, "height": z},
        "capsule": {"radius": _neat(min(wide, z / 2)), "height": z},
        "torus": {"radius": _neat(0.75 * wide), "tube": _neat(0.25 * wide)},
        "frustum": {"bottom_radius": wide, "top_radius": _neat(0.6 * wide), "height": z},
    }
    return {"kind": kind, **made[kind]} if kind in made else None


def support_like(kind: str, size: Size, middle: Size) -> dict[str, Any] | None:
    """A shape of a support where one of that size is, m."""
    x, y, z = middle
    low = _neat(z - size[2] / 2)
    made: dict[str, dict[str, Any]] = {
        "floor": {"height": 0.0},
        "wall": {"point": [x, y, 0.0], "yaw": _neat(-math.pi / 2)},
        "box": {"position": [x, y, z], "size": list(size)},
        "ramp": {
            "toe": [_neat(x - size[0] / 2), y, low], "yaw": 0.0, "run": size[0],
            "rise": size[2], "width": size[1],
        },
        "vessel": {
            "position": [x, y, z], "yaw": 0.0,
            "body": {"kind": "box", "size": list(size), "wall": _neat(0.05 * min(size))},
        },
    }  # fmt: skip
    return {"kind": kind, **made[kind]} if kind in made else None


def _neat(value: float) -> float:
    return float(f"{value:.4g}")


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
    "tether": "Hangs by a thread of",
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
