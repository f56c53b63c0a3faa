"""Typed edits of a program: atomic, validated, invertible.

A path is dotted and names list items by their id or name (`event.actions.kick.velocity.0`,
`scene.objects.ball.density`). The planner, a person and an importer all change a program
through `apply`, so whatever they ask for passes the same validation.
"""

import copy
from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import Field, JsonValue

from physagent_studio.errors import EditError, Problem, ProgramError
from physagent_studio.program.base import Frozen
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.text.document import validate_data
from physagent_studio.program.text.problems import hint, label_of

Path = Annotated[str, Field(min_length=1, max_length=500)]


class SetField(Frozen):
    """Sets the field at `path`, which must exist in the program."""

    op: Literal["set"] = "set"
    path: Path
    value: JsonValue


class AddItem(Frozen):
    """Adds an item to the list at `path`, at `index` or at the end."""

    op: Literal["add"] = "add"
    path: Path
    item: JsonValue
    index: Annotated[int, Field(ge=0, le=10_000)] | None = None


class RemoveItem(Frozen):
    """Removes the list item at `path`."""

    op: Literal["remove"] = "remove"
    path: Path


class MoveItem(Frozen):
    """Moves the list item at `path` to position `index`."""

    op: Literal["move"] = "move"
    path: Path
    index: Annotated[int, Field(ge=0, le=10_000)]


Edit = Annotated[SetField | AddItem | RemoveItem | MoveItem, Field(discriminator="op")]


class Hunk(Frozen):
    """A part of a proposal or of a diff that can be accepted by itself."""

    id: str
    summary: str
    edits: tuple[Edit, ...]


def apply(program: PhysicalProgram, edits: Iterable[Edit]) -> PhysicalProgram:
    """The program with all edits applied in order, or an `EditError` and no change at all."""
    return apply_with_inverse(program, edits)[0]


def apply_with_inverse(
    program: PhysicalProgram, edits: Iterable[Edit]
) -> tuple[PhysicalProgram, tuple[Edit, ...]]:
    """The edited program and the edits that lead back from it to `program`."""
    data: Any = program.model_dump(mode="json")
    inverse: list[Edit] = []
    fresh = False
    for edit in edits:
        data = _completed(data) if fresh else data
        inverse.append(_apply_one(data, edit))
        fresh = _brings_fields(edit)
    return validate_data(data), tuple(reversed(inverse))


def _brings_fields(edit: Edit) -> bool:
    """Whether what it writes may have defaults; a number in the place of another has none."""
    if isinstance(edit, SetField):
        return not isinstance(edit.value, int | float)
    return isinstance(edit, AddItem)


def _completed(data: Any) -> Any:
    """The data with every default written out, so that a later edit finds it, if they are valid.

    Between the edits of a list they need not be.
    """
    try:
        return validate_data(data).model_dump(mode="json")
    except ProgramError:
        return data


def _apply_one(data: Any, edit: Edit) -> Edit:
    """Applies one edit to plain data in place and returns its inverse."""
    if isinstance(edit, AddItem):
        return _add(data, edit)
    parent, key = _locate(data, edit.path)
    if isinstance(edit, SetField):
        old = copy.deepcopy(parent[key])
        parent[key] = copy.deepcopy(edit.value)
        return SetField(path=_renamed(edit, parent, key), value=old)
    if not isinstance(parent, list):
        raise EditError((Problem(edit.path, "is not an item of a list"),))
    item = parent.pop(key)
    if isinstance(edit, RemoveItem):
        return AddItem(path=edit.path.rpartition(".")[0], item=item, index=key)
    if edit.index > len(parent):
        message = f"cannot move to position {edit.index}"
        raise EditError((Problem(edit.path, message, f"0 … {len(parent)}"),))
    parent.insert(edit.index, item)
    return MoveItem(path=edit.path, index=key)


def _add(data: Any, edit: AddItem) -> Edit:
    parent, key = _locate(data, edit.path)
    items = parent[key]
    if not isinstance(items, list):
        raise EditError((Problem(edit.path, "is not a list"),))
    index = len(items) if edit.index is None else edit.index
    if index > len(items):
        message = f"cannot add at position {index}"
        raise EditError((Problem(edit.path, message, f"0 … {len(items)}"),))
    items.insert(index, copy.deepcopy(edit.item))
    label = label_of(edit.item)
    return RemoveItem(path=f"{edit.path}.{index if label is None else label}")


def _renamed(edit: SetField, parent: Any, key: Any) -> str:
    """Where the field is found after the edit: setting an id or name moves its own path."""
    head = edit.path.split(".")
    label = label_of(parent)
    if label is not None and key == ("id" if "id" in parent else "name") and len(head) >= 2:
        return ".".join([*head[:-2], label, head[-1]])
    new = label_of(parent[key]) if isinstance(parent, list) else None
    return edit.path if new is None else ".".join([*head[:-1], new])


def _locate(data: Any, path: str) -> tuple[Any, Any]:
    """The container and key of `path`; an `EditError` names what exists there."""
    parts = path.split(".")
    node, here = data, ""
    for position, part in enumerate(parts):
        key = _key(node, part, here)
        if position == len(parts) - 1:
            return node, key
        node, here = node[key], f"{here}.{part}" if here else part
    raise EditError((Problem(path, "is empty"),))


def _key(node: Any, part: str, here: str) -> Any:
    if isinstance(node, dict):
        if part in node:
            return part
        message = f"has no field '{part}'{hint(part, node)}"
        raise EditError((Problem(here, message, f"fields: {', '.join(node)}"),))
    if isinstance(node, list):
        for index, item in enumerate(node):
            if label_of(item) == part:
                return index
        if part.isdecimal() and int(part) < len(node) and label_of(node[int(part)]) is None:
            return int(part)
        names = [label_of(item) or str(index) for index, item in enumerate(node)]
        message = f"has no item '{part}'{hint(part, names)}"
        known = ", ".join(names) or "none"
        raise EditError((Problem(here, message, f"items: {known}"),))
    raise EditError((Problem(here, f"has no parts, so '{part}' cannot be found in it"),))


def value_at(program: PhysicalProgram, path: str) -> JsonValue:
    """The plain value at a path, or an `EditError` that names what exists there."""
    parent, key = _locate(program.model_dump(mode="json"), path)
    return parent[key]
