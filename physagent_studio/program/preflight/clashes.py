"""What preflight says, and of two actions on one object what excludes or repeats the other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from physagent_studio.program import actions
from physagent_studio.program.base import Frozen
from physagent_studio.program.edits import Edit, RemoveItem, SetField
from physagent_studio.program.preflight.mechanics import vector_of


def path_of_action(action: actions.Action) -> str:
    """The dotted path of an action."""
    return f"event.actions.{action.id}"


def _span(action: actions.Action) -> tuple[int, int] | None:
    """First and last step of an action that starts at a step; None for a condition."""
    if action.when is not None:
        return None
    return action.start_step, action.start_step + actions.duration_of(action) - 1


def clashes(first: actions.Action, second: actions.Action) -> Iterator[PreflightFinding]:
    """What two actions on the same object do to each other where their windows overlap."""
    one, two = _span(first), _span(second)
    if one is None or two is None or max(one[0], two[0]) > min(one[1], two[1]):
        return
    for fixed, other, span in ((first, second, one), (second, first, two)):
        if isinstance(fixed, actions.FixObject) and not isinstance(other, actions.FixObject):
            yield _fixed(fixed, other, span)
            return
    if isinstance(first, actions.FixObject):
        message = f"it overlaps {first.id}, which fixes the same object"
        edits = _as_one(first, second, (one[0], two[0]), (one[1], two[1]))
        yield finding("overlapping", path_of_action(second), message, edits)
    elif _same_quantity(first, second):
        message = f"{first.id} and {second.id} set the same quantity on step {max(one[0], two[0])}"
        edits = (RemoveItem(path=path_of_action(first)),)
        yield finding("contradiction", path_of_action(second), message, edits)
    elif _cancel(first, second):
        message = f"{first.id} and {second.id} push against each other and cancel out"
        edits = (RemoveItem(path=path_of_action(second)),)
        yield finding("contradiction", path_of_action(second), message, edits)


def _as_one(
    first: actions.Action, second: actions.Action, starts: tuple[int, int], ends: tuple[int, int]
) -> tuple[Edit, ...]:
    """One hold over both windows: the earlier one, made as long as it takes."""
    kept, dropped = (first, second) if starts[0] <= starts[1] else (second, first)
    duration = max(ends) - min(starts) + 1
    longer = SetField(path=f"{path_of_action(kept)}.duration", value=duration)
    return (longer, RemoveItem(path=path_of_action(dropped)))


def _fixed(
    fixed: actions.FixObject, other: actions.Action, span: tuple[int, int]
) -> PreflightFinding:
    end = span[1] + 1
    message = f"{other.name} is held by {fixed.id} until step {end}, so this has no effect then"
    edits = (SetField(path=f"{path_of_action(other)}.start_step", value=end),)
    return finding("fixed_target", path_of_action(other), message, edits)


_SETTERS = (
    (actions.SetVelocity, actions.SetPosition, actions.SetOrientation),
    (actions.SetAngularVelocity,),
    (actions.SetPosition,),
    (actions.SetOrientation,),
)


def _same_quantity(first: actions.Action, second: actions.Action) -> bool:
    """Whether both assign what only one can; placing or turning also stops the object."""
    return (
        any(isinstance(first, group) and isinstance(second, group) for group in _SETTERS[1:])
        or (isinstance(first, actions.SetVelocity) and isinstance(second, _SETTERS[0]))
        or (isinstance(second, actions.SetVelocity) and isinstance(first, _SETTERS[0]))
    )


def _cancel(first: actions.Action, second: actions.Action) -> bool:
    if not isinstance(first, actions.ApplyForce) or not isinstance(second, actions.ApplyForce):
        return False
    one, two = vector_of(first.force), vector_of(second.force)
    if one is None or two is None or first.point != second.point:
        return False
    left, size = np.add(one, two), max(float(np.linalg.norm(one)), float(np.linalg.norm(two)))
    return size > 0 and float(np.linalg.norm(left)) < 0.05 * size


Code = Literal[
    "fixed_target", "past_end", "below_friction", "contradiction", "overlapping", "collision",
    "in_the_air", "not_on_support", "tunnelling", "cannot_act", "never_starts",
    "implausible_density", "implausible_size", "implausible_speed", "no_effect", "untestable",
    "unplaced",
]  # fmt: skip


class PreflightFinding(Frozen):
    """Something that will probably not do what was meant.

    path: the field it is about. message: what is wrong and why, in a sentence with figures.
    edits: a suggestion that settles it; empty where only a person can know what was meant.
    """

    code: Code
    path: str
    message: str
    edits: tuple[Edit, ...] = ()


def finding(code: Code, path: str, message: str, edits: tuple[Edit, ...]) -> PreflightFinding:
    """The finding with its parts in order."""
    return PreflightFinding(code=code, path=path, message=message, edits=edits)
