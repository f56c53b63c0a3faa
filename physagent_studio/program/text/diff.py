"""What differs between two programs, in hunks that can be taken one by one."""

from collections.abc import Iterator
from typing import Any

from physagent_studio.program.edits import AddItem, Edit, Hunk, MoveItem, RemoveItem, SetField
from physagent_studio.program.program import PhysicalProgram

_REST = (
    "clip",
    "scene.camera",
    "scene.horizon",
    "scene.roll",
    "scene.gravity",
    "scene.scale",
    "scene.flags",
    "event.prompt",
    "contract.not_understood",
)
_NOUNS = {
    "scene.objects": "object",
    "scene.supports": "support",
    "scene.landmarks": "landmark",
    "event.actions": "action",
    "contract.clauses": "clause",
    "contract.statements": "statement",
}


def diff(before: PhysicalProgram, after: PhysicalProgram) -> tuple[Hunk, ...]:
    """One hunk for each object, support, landmark, action, clause and statement that differs,
    and for each of the remaining sections.

    Applied in order, all of them lead from `before` to `after`; one by one each applies as long
    as it names nothing that only another brings.
    """
    old, new = before.model_dump(mode="json"), after.model_dump(mode="json")
    hunks: list[Hunk] = []
    for path in _REST:
        edits = tuple(_changes(path, _at(old, path), _at(new, path)))
        if edits:
            hunks.append(Hunk(id=path, summary=_summary(path, edits), edits=edits))
    for path in _NOUNS:
        hunks += _list_hunks(path, _at(old, path), _at(new, path))
    return tuple(hunks)


def _at(data: Any, path: str) -> Any:
    for part in path.split("."):
        data = data[part]
    return data


def _label(item: Any) -> str:
    return str(item.get("id", item.get("name")))


def _changes(path: str, old: Any, new: Any) -> Iterator[Edit]:
    """The fewest fields that lead from one value to the other."""
    if old == new:
        return
    alike = isinstance(old, dict) and isinstance(new, dict) and old.keys() == new.keys()
    if alike and all(old.get(tag) == new.get(tag) for tag in ("kind", "operator", "id", "name")):
        for key in old:
            yield from _changes(f"{path}.{key}", old[key], new[key])
    else:
        yield SetField(path=path, value=new)


def _list_hunks(path: str, old: list[Any], new: list[Any]) -> list[Hunk]:
    noun = _NOUNS[path]
    before = {_label(item): item for item in old}
    after = {_label(item): item for item in new}
    hunks: list[Hunk] = []
    common = [name for name in before if name in after]
    retyped = {name for name in common if _type_of(before[name]) != _type_of(after[name])}
    for name in before:
        if name not in after:
            edits: tuple[Edit, ...] = (RemoveItem(path=f"{path}.{name}"),)
            hunks.append(Hunk(id=f"{path}.{name}", summary=f"remove {noun} {name}", edits=edits))
    for name in common:
        edits = tuple(_item_changes(path, name, old, before, after, retyped))
        if edits:
            summary = _summary(f"{path}.{name}", edits)
            hunks.append(Hunk(id=f"{path}.{name}", summary=f"{noun} {summary}", edits=edits))
    hunks += _order(path, common, [name for name in after if name in before])
    # From the last to the first, each behind the common items that precede it, so that any
    # part of these hunks finds its place.
    for name in reversed([name for name in after if name not in before]):
        preceding = list(after)[: list(after).index(name)]
        index = sum(other in before for other in preceding)
        edits = (AddItem(path=path, item=after[name], index=index),)
        hunks.append(Hunk(id=f"{path}.{name}", summary=f"add {noun} {name}", edits=edits))
    return hunks


def _type_of(item: Any) -> Any:
    """What decides which fields an item has."""
    return item.get("operator", item.get("kind")) if "id" in item else None


def _item_changes(
    path: str,
    name: str,
    old: list[Any],
    before: dict[str, Any],
    after: dict[str, Any],
    retyped: set[str],
) -> Iterator[Edit]:
    if name in retyped:
        index = [_label(item) for item in old].index(name)
        # Earlier hunks may have removed items before it.
        index -= sum(_label(item) not in after for item in old[:index])
        yield RemoveItem(path=f"{path}.{name}")
        yield AddItem(path=path, item=after[name], index=index)
    else:
        yield from _changes(f"{path}.{name}", before[name], after[name])


def _order(path: str, old: list[str], new: list[str]) -> list[Hunk]:
    """Moves that bring the common items into their new order."""
    current, edits = list(old), list[Edit]()
    for index, name in enumerate(new):
        if current[index] != name:
            current.insert(index, current.pop(current.index(name)))
            edits.append(MoveItem(path=f"{path}.{name}", index=index))
    if not edits:
        return []
    return [Hunk(id=f"{path}.order", summary=f"reorder {path}", edits=tuple(edits))]


def _summary(path: str, edits: tuple[Edit, ...]) -> str:
    """ "kick: velocity, duration": the fields in words."""
    fields = list(dict.fromkeys(_field(path, edit) for edit in edits))
    name = path.rpartition(".")[2]
    return f"{name}: {', '.join(fields)}" if any(fields) else name


def _field(path: str, edit: Edit) -> str:
    if isinstance(edit, RemoveItem | AddItem):
        return "kind"
    return edit.path.removeprefix(path).lstrip(".")
