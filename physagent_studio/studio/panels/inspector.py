"""Inspector: a form for the selected thing, made from its pydantic model.

A form is a tree of fields. Every field carries the path of the edit that it makes, so that the
page only has to send (path, value) back and the program's own validation does the rest.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import BaseModel, TypeAdapter

from physagent_studio.contract import describe
from physagent_studio.program import MATERIALS, PhysicalProgram
from physagent_studio.program.materials import material
from physagent_studio.studio.panels.words import OPERATORS, number, plain, unit_of
from physagent_studio.studio.scene.places import poses_at
from physagent_studio.studio.view import View
from physagent_studio.workbench import Snapshot

Schema = dict[str, Any]
HIDDEN = frozenset({"grounding", "source", "kind", "operator", "id", "name"})
ROOTS = {
    "object": "scene.objects",
    "support": "scene.supports",
    "landmark": "scene.landmarks",
    "action": "event.actions",
    "statement": "contract.statements",
}
LABELS = {
    "start_step": "Starts at step",
    "duration": "Lasts",
    "when": "Starts",
    "muted": "Muted",
    "position": "Position",
    "rotation": "Rotation (w, x, y, z)",
    "density": "Density",
    "friction": "Friction",
    "restitution": "Bounciness",
    "rolling": "Rolling resistance",
    "support": "Stands on",
    "material": "Material",
    "shape": "Shape",
}


def state_of(snapshot: Snapshot, view: View) -> dict[str, Any]:
    """The form of the selection, or an invitation to select."""
    kind, name = view.selection.kind, view.selection.name
    base = {"kind": kind, "name": name, "readOnly": snapshot.read_only, "names": _names(snapshot)}
    if kind == "camera":
        return base | _form(snapshot.program.scene.camera, "scene.camera", snapshot, "Camera")
    item = _item(snapshot.program, kind, name)
    if item is None:
        return base | {"kind": "none", "title": "", "fields": []}
    title = OPERATORS.get(getattr(item, "operator", ""), "") or name
    if kind == "statement":
        title = describe(item, snapshot.program)
    form = base | _form(item, f"{ROOTS[kind]}.{name}", snapshot, title)
    if kind == "action":
        form["target"] = item.name
    if kind == "object":
        form["facts"] = _facts(snapshot, name, view.step)
        form["actions"] = [a.id for a in snapshot.program.event.actions if a.name == name]
    return form


def _item(program: PhysicalProgram, kind: str, name: str) -> Any:
    scene = program.scene
    if kind == "object":
        return scene.object(name)
    if kind == "support":
        return scene.support(name)
    if kind == "landmark":
        return scene.landmark(name)
    if kind == "statement":
        return next((one for one in program.contract.statements if one.id == name), None)
    return program.action(name) if kind == "action" else None


def _names(snapshot: Snapshot) -> dict[str, list[str]]:
    scene = snapshot.program.scene
    objects, supports = [o.name for o in scene.objects], [s.name for s in scene.supports]
    return {
        "objects": objects,
        "supports": supports,
        "places": objects + supports + [one.name for one in scene.landmarks],
        "materials": list(MATERIALS),
        "actions": [action.id for action in snapshot.program.event.actions],
        "clauses": [clause.id for clause in snapshot.program.contract.clauses],
        "statements": [one.id for one in snapshot.program.contract.statements],
    }


def _form(item: BaseModel | None, path: str, snapshot: Snapshot, title: str) -> dict[str, Any]:
    if item is None:
        return {"title": title, "fields": [], "path": path}
    schema, definitions = _schema(type(item))
    data = plain(item)
    fields = [
        _field(f"{path}.{key}", key, part, data.get(key), definitions)
        for key, part in schema["properties"].items()
        if key not in HIDDEN
    ]
    _add_help(fields, item, snapshot)
    return {
        "title": title,
        "path": path,
        "help": (type(item).__doc__ or "").split("\n\n")[0].replace("`", ""),
        "fields": fields,
        "data": data,
    }


@cache
def _schema(model: type[BaseModel]) -> tuple[Schema, Schema]:
    schema = TypeAdapter(model).json_schema()
    return schema, schema.get("$defs", {})


def _field(path: str, key: str, schema: Schema, value: Any, definitions: Schema) -> dict[str, Any]:
    """One field of a form, with its choices where the model allows several kinds of value."""
    field: dict[str, Any] = {
        "path": path,
        "label": LABELS.get(key, key.replace("_", " ").capitalize()),
        "value": value,
        "unit": unit_of(path),
    }
    options = [_resolved(one, definitions) for one in _alternatives(schema)]
    field["optional"] = any(one.get("type") == "null" for one in options)
    kinds = [one for one in options if one.get("type") != "null"]
    if len(kinds) == 1:
        field.update(_one_kind(path, key, kinds[0], value, definitions))
    else:
        field["choices"] = [_choice(path, key, one, value, definitions) for one in kinds]
        field["kind"] = "choice"
    return field


def _alternatives(schema: Schema) -> list[Schema]:
    return schema.get("anyOf") or schema.get("oneOf") or [schema]


def _resolved(schema: Schema, definitions: Schema) -> Schema:
    while "$ref" in schema:
        schema = definitions[schema["$ref"].rpartition("/")[2]]
    return schema


def _one_kind(
    path: str, key: str, schema: Schema, value: Any, definitions: Schema
) -> dict[str, Any]:
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
        parts = [_resolved(one, definitions) for one in schema["prefixItems"]]
        if all(one.get("type") in ("number", "integer") for one in parts):
            return {"kind": "vector", "count": len(parts), **_bounds(parts[0])}
    if kind == "object":
        return {"kind": "group", "fields": _group(path, schema, value, definitions)}
    if kind == "string":
        return {"kind": "text", "names": _name_list(key)}
    return {"kind": "data"}


def _group(path: str, schema: Schema, value: Any, definitions: Schema) -> list[dict[str, Any]]:
    data = value if isinstance(value, dict) else {}
    return [
        _field(f"{path}.{name}", name, part, data.get(name, part.get("default")), definitions)
        for name, part in schema.get("properties", {}).items()
        if name != "kind"
    ]


def _choice(path: str, key: str, schema: Schema, value: Any, definitions: Schema) -> dict[str, Any]:
    made = _one_kind(path, key, schema, value, definitions)
    properties = schema.get("properties", {})
    tag = properties.get("kind", {}).get("const")
    names = {"vector": "Plain vector", "group": schema.get("title", ""), "text": "Name"}
    made["title"] = (tag or names.get(made["kind"], made["kind"])).replace("_", " ")
    made["tag"] = tag
    return made


def _bounds(schema: Schema) -> dict[str, Any]:
    low = schema.get("minimum", schema.get("exclusiveMinimum"))
    high = schema.get("maximum", schema.get("exclusiveMaximum"))
    return {"min": low, "max": high}


def _name_list(key: str) -> str:
    """Which list of names a text field offers."""
    return {
        "material": "materials", "support": "supports", "on": "supports", "toward": "places",
        "a": "places", "b": "places", "action": "actions", "name": "objects",
        "subject": "objects", "other": "places", "landmark": "places", "near": "places",
        "before": "places", "clause": "clauses", "first": "statements", "second": "statements",
    }.get(key, "")  # fmt: skip


def _add_help(fields: list[dict[str, Any]], item: BaseModel, snapshot: Snapshot) -> None:
    """What an empty field stands for: the material's own figure."""
    row = getattr(item, "material", None)
    for field in fields:
        key = field["path"].rpartition(".")[2]
        if row in MATERIALS and key in ("density", "friction", "restitution", "rolling"):
            field["empty"] = f"{number(getattr(material(row), key))} (from {row})"
        field["pinned"] = field["path"] in snapshot.state.pinned


def _facts(snapshot: Snapshot, name: str, step: int) -> list[dict[str, str]]:
    """What is measured of an object at the step on view."""
    rollout = snapshot.rollout
    if rollout is None or name not in rollout.objects:
        place = poses_at(snapshot, 0).get(name)
        return [] if place is None else [{"what": "Position", "is": _vector(place[0]), "unit": "m"}]
    at, row = rollout.objects.index(name), min(step, rollout.steps)
    speed = float((rollout.velocities[row, at] ** 2).sum() ** 0.5)
    spin = float((rollout.angular[row, at] ** 2).sum() ** 0.5)
    return [
        {"what": "Mass", "is": number(float(rollout.masses[at])), "unit": "kg"},
        {"what": "Position", "is": _vector(rollout.positions[row, at]), "unit": "m"},
        {"what": "Speed", "is": number(speed), "unit": "m/s"},
        {"what": "Spin", "is": number(spin), "unit": "rad/s"},
    ]


def _vector(value: Any) -> str:
    return "  ".join(f"{float(part):.2f}".replace("-", "−") for part in value)
