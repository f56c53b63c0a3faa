"""How an event goes as a whole: gentler or harder, slower or faster, a thing *this way*, and how a
thing is held when it begins."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field, JsonValue

from physagent_studio.agent.rules.planner.parameters import action_knobs
from physagent_studio.arrays import FloatArray
from physagent_studio.errors import InputError
from physagent_studio.program import Action, AddItem, Directed, Edit, PhysicalProgram, SetField
from physagent_studio.program.base import Name, Pixel, free_name
from physagent_studio.program.scene.aloft import Carriage
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.program.timing import retimed
from physagent_studio.studio.commands.asking import asked
from physagent_studio.studio.commands.program import Pace, carry, open_program
from physagent_studio.workbench import commands
from physagent_studio.workbench.aloft_edits import carriage_edits, ground_edits, height_edits

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio

STRAIGHT_UP = 1e-3
"""A line of sight, m, that goes less far along the ground points nowhere on it."""
FIRST_PUSH = {"magnitude": 1.0, "quantity": "target_speed", "direction": "right"}
"""What a thing is given that nothing pushes yet when it is told to go somewhere: m/s."""


@asked("scale")
def scale(
    studio: Studio,
    browser: int,
    effort: Annotated[float, Field(ge=0.1, le=10)] = 1.0,
    pace: Pace | None = None,
    keep: bool = False,
) -> None:
    """All efforts of the event by one ratio, or another pace; only tried unless `keep`."""
    program = open_program(studio)
    if keep and pace is not None:
        studio.workbench.post(commands.Retime(pace))
        return
    edits = retimed(program, pace) if pace else scaled(program, effort)
    if not edits and keep:
        raise InputError("nothing pushes or moves a thing here, so there is no effort to change")
    carry(studio, edits, "gentler" if effort < 1 else "harder", keep=keep)


@asked("aim")
def aim(studio: Studio, browser: int, name: Name, end: Pixel, keep: bool = False) -> None:
    """A thing goes towards a pixel of the photo; only tried unless `keep`."""
    edits = aimed(open_program(studio), name, end)
    carry(studio, edits, f"{name.replace('_', ' ')} goes this way", keep=keep)


@asked("hold")
def hold(studio: Studio, browser: int, name: Name, how: Carriage) -> None:
    """A thing stands, hangs, floats, or nothing holds it."""
    edits = carriage_edits(open_program(studio), studio.snapshot.state.pinned, name, how)
    if edits:
        carry(studio, edits, f"{name.replace('_', ' ')} {how}", keep=True)


@asked("ground")
def ground(studio: Studio, browser: int, name: Name, end: Pixel, keep: bool = False) -> None:
    """The ground below a thing in the air is seen at that pixel; only tried unless `keep`."""
    edits = ground_edits(open_program(studio), name, end)
    carry(studio, edits, f"ground line of {name.replace('_', ' ')}", keep=keep)


@asked("raise")
def lift(
    studio: Studio, browser: int, name: Name, height: Annotated[float, Field(ge=0, le=1e4)]
) -> None:
    """A thing so many metres above the ground, in its place in the photo."""
    edits = height_edits(open_program(studio), name, height)
    carry(studio, edits, f"height of {name.replace('_', ' ')}", keep=True)


def scaled(program: PhysicalProgram, ratio: float) -> tuple[Edit, ...]:
    """Edits that make every push, spin and wind of the event stronger by one ratio."""
    knobs = (one for one in action_knobs(program) if one.factor == "magnitude")
    return tuple(edit for one in knobs for edit in one.edits(one.value * ratio))


def aimed(program: PhysicalProgram, name: str, end: tuple[float, float]) -> tuple[Edit, ...]:
    """Edits that send a thing towards a pixel of the photo, along its level.

    A thing on wheels is turned there with what drives it.
    """
    item = program.scene.object(name)
    if item is None or item.position is None or program.scene.camera is None:
        raise InputError(f"there is no '{name}' in a photo that could be sent anywhere")
    degrees = round(heading_to(program, item, end), 1)
    edits = [edit for action in program.event.actions if action.name == name
             for edit in _turned(action, degrees)]  # fmt: skip
    if not edits:
        force: JsonValue = {**FIRST_PUSH, "azimuth": degrees}
        taken = {one.id for one in program.event.actions}
        push: JsonValue = {"id": free_name(f"push_{name}", taken), "name": name, "start_step": 4,
                           "operator": "ApplyForce", "force": force, "duration": 12}  # fmt: skip
        edits.append(AddItem(path="event.actions", item=push))
    if item.wheels is not None:
        edits.append(SetField(path=f"scene.objects.{name}.wheels.heading", value=degrees))
    return tuple(edits)


def heading_to(program: PhysicalProgram, item: SceneObject, end: tuple[float, float]) -> float:
    """Degrees, seen from above, from a thing to what is seen at a pixel on its own level.

    0 is right, 90 away from the camera. Above the horizon it is where that line of sight goes.
    """
    camera = program.scene.camera
    assert camera is not None
    assert item.position is not None
    ray, eye = camera.rays(np.array([end], float))[0], np.array(camera.position)
    place = np.array(item.position)
    share = (place[2] - eye[2]) / ray[2] if abs(ray[2]) > STRAIGHT_UP else -1.0
    way = eye + share * ray - place if share > 0 else ray
    if math.hypot(way[0], way[1]) < STRAIGHT_UP:
        raise InputError("drag the arrow away from the thing, to where it should go")
    return math.degrees(math.atan2(way[1], way[0]))


def _turned(action: Action, degrees: float) -> Iterator[Edit]:
    for field in ("force", "velocity"):
        value = getattr(action, field, None)
        path = f"event.actions.{action.id}.{field}"
        if isinstance(value, Directed):
            told = {"toward": None, "along": None, "direction": "right", "azimuth": degrees}
            yield SetField(path=path, value=value.model_dump(mode="json") | told)
        elif value is not None:
            yield SetField(path=path, value=_rotated(np.array(value, float), degrees))


def _rotated(vector: FloatArray, degrees: float) -> list[JsonValue]:
    flat, angle = math.hypot(vector[0], vector[1]), math.radians(degrees)
    parts = (flat * math.cos(angle), flat * math.sin(angle), float(vector[2]))
    return [float(f"{part:.5g}") for part in parts]
