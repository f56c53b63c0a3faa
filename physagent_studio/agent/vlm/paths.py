"""Which paths of a program a planner may edit, at which stage, and what an edit entails."""

from typing import Any

from physagent_studio.agent.vlm.facts import rounded
from physagent_studio.program import (
    AddItem,
    Edit,
    MoveItem,
    PhysicalProgram,
    RemoveItem,
    SetField,
    value_at,
)
from physagent_studio.program.base import overlap
from physagent_studio.records.judgement import Stage

_OBJECT_LOOKS = (
    *("material", "density", "friction", "restitution", "rolling", "wheels"),
    *("body", "position", "rotation"),
)
_OBJECT_SCENE = ("grounding", "shape", "position", "rotation", "support")
_SUPPORT_SCENE = ("grounding", "shape")
_SUPPORT_LOOKS = ("material", "friction", "restitution", "rolling", "shape")
_KEPT = frozenset({"given", "person"})


def editable(program: PhysicalProgram, stage: Stage) -> tuple[str, ...]:
    """Beginnings of the paths that a repair of that stage may touch.

    Contract, prompt, clip, gravity and landmarks are never the planner's: they say what has to
    happen, not how.
    """
    scene = program.scene
    if stage == "reconstruction":
        found = ["scene.horizon", "scene.scale", "scene.camera"]
        found += [f"scene.objects.{o.name}.{part}" for o in scene.objects for part in _OBJECT_SCENE]
        found += [
            f"scene.supports.{s.name}.{part}" for s in scene.supports for part in _SUPPORT_SCENE
        ]
        return tuple(found)
    found = [f"event.actions.{action.id}" for action in program.event.actions]
    found += [f"scene.objects.{o.name}.{part}" for o in scene.objects for part in _OBJECT_LOOKS]
    found += [f"scene.objects.{o.name}.support" for o in scene.objects]
    found += [f"scene.supports.{s.name}.{part}" for s in scene.supports for part in _SUPPORT_LOOKS]
    return tuple(found)


def listing(program: PhysicalProgram, stage: Stage) -> str:
    """Every editable path with its present value, one a line."""
    data = program.model_dump(mode="json")
    lines: list[str] = []
    for path in editable(program, stage):
        lines += _leaves(path, _at(data, path))
    if stage == "simulation":
        lines.append("event.actions: add, remove or move actions")
    return "\n".join(lines)


def _at(data: Any, path: str) -> Any:
    for part in path.split("."):
        if isinstance(data, list):
            data = next(item for item in data if part in (item.get("id"), item.get("name")))
        else:
            data = data[part]
    return data


def _leaves(path: str, value: Any) -> list[str]:
    """Mappings are spelled out; a list of numbers stays one value."""
    if isinstance(value, dict) and value:
        return [line for key, inner in value.items() for line in _leaves(f"{path}.{key}", inner)]
    text = repr(rounded(value)).replace("None", "null").replace("'", '"')
    return [f"{path} = {text.replace('True', 'true').replace('False', 'false')}"]


def target(edit: Edit, program: PhysicalProgram) -> str:
    """The path that an edit changes: of an addition, the item that it makes."""
    if isinstance(edit, AddItem):
        item = edit.item if isinstance(edit.item, dict) else {}
        return f"{edit.path}.{item.get('id', item.get('name', len(program.event.actions)))}"
    return edit.path


def allowed(edit: Edit, program: PhysicalProgram, stage: Stage) -> bool:
    """Whether a planner may make this edit at this stage."""
    if isinstance(edit, AddItem):
        return stage == "simulation" and edit.path == "event.actions"
    if isinstance(edit, RemoveItem | MoveItem):
        parts = edit.path.split(".")
        return stage == "simulation" and len(parts) == 3 and edit.path.startswith("event.actions.")
    # An id or a name is what decisions and pins refer to; renaming would slip out of them.
    if edit.path.split(".")[-1] in ("id", "operator") and edit.path.startswith("event."):
        return False
    return any(
        edit.path.startswith(f"{start}.")
        or (edit.path == start and not start.startswith("event.actions."))
        for start in editable(program, stage)
    )


def entailed(program: PhysicalProgram, edits: tuple[Edit, ...]) -> tuple[Edit, ...]:
    """What has to be opened with these edits, so that the picture decides it anew.

    New clicks, another mask or another support of a thing leave its shape and place to be found
    again; another horizon, camera or scale those of everything. What a person or the case gave
    stays, and so does what the edits themselves set.
    """
    own = [edit.path for edit in edits]
    scene = program.scene
    wide = [path for path in own if path.startswith(("scene.horizon", "scene.camera"))]
    wide += [path for path in own if path.startswith("scene.scale")]
    opened: list[str] = []
    if wide and scene.camera is not None and not scene.camera.confirmed:
        if not any(path.startswith("scene.camera") for path in own):
            opened.append("scene.camera")
        if not any(path.startswith("scene.horizon") for path in own) and not (
            any(path.startswith("scene.scale") for path in own)
        ):
            opened.append("scene.horizon")
    for item in scene.objects:
        base = f"scene.objects.{item.name}"
        touched = any(path.startswith((f"{base}.grounding", f"{base}.support")) for path in own)
        if (wide or touched) and item.source not in _KEPT:
            opened += [f"{base}.shape", f"{base}.position"]
    for item in scene.supports:
        base = f"scene.supports.{item.name}"
        touched = any(path.startswith(f"{base}.grounding") for path in own)
        if (wide or touched) and item.source not in _KEPT:
            opened.append(f"{base}.shape")
    return tuple(
        SetField(path=path, value=None)
        for path in opened
        if not any(overlap(path, one) for one in own) and value_at(program, path) is not None
    )
