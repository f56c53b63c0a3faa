"""What a peer's file says of motion, as edits of a program whose scene is reconstructed."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import JsonValue

from physagent_studio.program.edits import AddItem, Edit, RemoveItem, SetField
from physagent_studio.program.program import Clip, PhysicalProgram

FASTEST = 100.0
"""m/s that a push gives at most: what a picture says of far things is rough."""
_LEAST_SEEN = 0.2
"""Pixels by which a metre has to move a thing, as a share of its largest, for a direction of the
ground to be told from the picture."""


@dataclass(frozen=True, slots=True)
class Push:
    """A velocity at the start, as the picture shows it. way: (x, y) pixels, y down, in `seconds` of
    simulated time or, where None, over the clip. level: along the ground, else upright. weight:
    gravity in those pixels, /s²; speeds then keep their ratio to it rather than to the picture."""

    name: str
    way: tuple[float, float]
    seconds: float | None = None
    level: bool = True
    weight: float = 0.0


@dataclass(frozen=True, slots=True)
class Motion:
    """What happens in a peer's clip.

    actions: operators as plain data; `object` and `toward` are numbers of its objects. lifts: m by
    which an object stands elsewhere at the start.
    """

    actions: tuple[Mapping[str, Any], ...] = ()
    lifts: tuple[tuple[int, tuple[float, float, float]], ...] = ()
    pushes: tuple[Push, ...] = ()


NO_MOTION = Motion()


def motion_edits(
    program: PhysicalProgram, motion: Motion, names: Sequence[str], clip: Mapping[str, float]
) -> tuple[Edit, ...]:
    """Edits that put a peer's motion in the place of a program's schedule, in its clip."""
    whole = program.clip.model_copy(update=dict(clip))
    edits: list[Edit] = [
        SetField(path=f"clip.{field}", value=value)
        for field, value in clip.items()
        if getattr(program.clip, field) != value
    ]
    edits += _windows(program, whole)
    if motion.actions or motion.pushes:
        edits += [RemoveItem(path=f"event.actions.{one.id}") for one in program.event.actions]
        items = [_named(one, names) for one in motion.actions]
        items += [_pushed(program, one, whole) for one in motion.pushes]
        inside = [item for one in items if (item := _cut(one, whole.steps)) is not None]
        edits += [
            AddItem(path="event.actions", item={"id": f"peer_{number + 1}", **item})
            for number, item in enumerate(inside)
        ]
    for index, lift in motion.lifts:
        item = program.scene.object(names[index])
        if item is not None and item.position is not None:
            place = [float(a + b) for a, b in zip(item.position, lift, strict=True)]
            edits.append(SetField(path=f"scene.objects.{item.name}.position", value=list(place)))
    return tuple(edits)


def beyond(motion: Motion, steps: int) -> tuple[str, ...]:
    """Actions that begin after the clip's end, and so do not happen."""
    late = [one for one in motion.actions if one["start_step"] >= steps]
    return tuple(f"{one['operator']} at step {one['start_step']}, after the end" for one in late)


def _windows(program: PhysicalProgram, clip: Clip) -> list[Edit]:
    """The contract's windows keep their seconds."""
    ratio = program.clip.step_seconds / clip.step_seconds
    found: list[Edit] = []
    for statement in program.contract.statements:
        for field in ("from_step", "to_step"):
            step = getattr(statement, field)
            if step is not None:
                wanted = min(round(step * ratio), clip.steps)
                path = f"contract.statements.{statement.id}.{field}"
                found += [SetField(path=path, value=wanted)] if wanted != step else []
    return found


def _named(action: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """The action with the names of its things."""
    found: dict[str, Any] = {key: value for key, value in action.items() if key != "object"}
    for key, value in found.items():
        if isinstance(value, Mapping) and "toward" in value:
            found[key] = {**value, "toward": names[value["toward"]]}
    return {"name": names[action["object"]], **found}


def _pushed(program: PhysicalProgram, push: Push, clip: Clip) -> dict[str, JsonValue]:
    """A velocity that moves the thing so on the picture."""
    camera, item = program.scene.camera, program.scene.object(push.name)
    velocity = np.zeros(3)
    if camera is not None and item is not None and item.position is not None:
        place = np.array(item.position, float)
        here = camera.project(place[None])[0][0]
        # How a metre along each axis moves it on the picture.
        moves = (camera.project(place + 1e-4 * np.eye(3))[0] - here) / 1e-4
        axes = [0, 1] if push.level else [0, 2]
        basis = moves[axes].T
        sizes = np.linalg.svd(basis, compute_uv=False)
        if sizes[1] < _LEAST_SEEN * sizes[0]:
            axes, basis = [0, 2], moves[[0, 2]].T
        seconds = clip.seconds if push.seconds is None else push.seconds
        velocity[axes] = np.linalg.solve(basis, np.array(push.way)) / max(seconds, 1e-6)
        if push.weight:
            # The same v² over gravity and length, of which a pixel there is so many metres here.
            metres = 1 / float(np.linalg.norm(moves[0]))
            velocity *= math.sqrt(9.81 / (push.weight * metres))
        velocity *= min(1.0, FASTEST / max(float(np.linalg.norm(velocity)), 1e-9))
    return {
        "name": push.name,
        "operator": "SetVelocity",
        "start_step": 0,
        "velocity": [float(v) for v in velocity],
    }


def _cut(action: dict[str, Any], steps: int) -> dict[str, Any] | None:
    """The action as far as it lies within the clip."""
    start = action["start_step"]
    if start >= steps:
        return None
    if "duration" in action:
        return action | {"duration": min(action["duration"], steps - start)}
    return action
