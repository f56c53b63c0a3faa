"""First values: what a field holds when a person has chosen another kind for it.

They are of the size of the thing at hand and speak of things that exist, so that a choice is a
valid program at once and there is something to change.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from physagent_studio.program import PhysicalProgram, SceneObject, Support
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.program.scene.state import MeshedSupport, Ramp, Shape, Slab, Vessel

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
