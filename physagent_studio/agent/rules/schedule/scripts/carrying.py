"""Picked up and put down: what a hand does with a thing, as forces that carry its weight.

It is raised, brought along on the level and let down, each gaining speed for half of its time and
losing it for the other half, so that it is at rest in between and does not swing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from physagent_studio.agent.rules.contract.specs import ways_of
from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import free_way, good_way
from physagent_studio.agent.rules.scene.measures import (
    UP,
    WAYS,
    FloatArray,
    Layout,
    level,
    place_name,
    unit,
)
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.task import SIDE_WAYS, Task
from physagent_studio.language import Place
from physagent_studio.program.actions import Action, Direction
from physagent_studio.program.scene.state import Slab


@dataclass(frozen=True, slots=True)
class CarryingSettings:
    """How high things are carried, and how long that takes."""

    rise_sizes: float = 0.9  # own sizes, 0.2..1.5: lower is hardly seen to be lifted
    clear_sizes: float = 0.25  # own sizes, 0.1..1: over what it is carried across
    drop_sizes: float = 0.8  # own sizes, 0.3..2: over what it is let fall on, so that it is seen to
    min_clear_m: float = 0.03  # m, 0.01..0.1: likewise, for what is small
    beside_sizes: float = 0.3  # own sizes, 0.1..1: between it and what it is put down beside
    release_m: float = 0.003  # m, 0.001..0.01: above what it is put on, where it is let go
    sunk_share: float = 0.5  # 0..0.9: of a vessel's height, down to which it is let into it
    whole_share: float = 0.85  # of the clip, 0.5..0.9: in which all of it happens
    # 1..2.5: over the time in which it is raised or let down, of that in which it is brought along
    along_ratio: float = 1.4
    tilt_deg: float = 50.0  # 20..90: by which it is tilted in the hand, where no angle is told
    most_sizes: float = 4.0  # own sizes, 1..10: most that it is brought along where none is told


CARRYING = CarryingSettings()
_VESSEL = ("in", "into", "inside")
_TO = ("near", "to", "toward", "at", "against")
_Move = tuple[float, FloatArray, float, str]
"""A way in m, or radians, along or about a unit direction (3,), its share of the time, a label."""
_TURNED = ("turn", "flip", "spin", "lean")
_UPON = ("on", "onto", "atop", *_VESSEL)


@dataclass(frozen=True, slots=True)
class _Goal:
    """Where it ends. offset: (3,) level way, m. base: height of what is under it then, m; None
    where it is held in the air to the end."""

    offset: FloatArray
    base: float | None


def carry(task: Task) -> list[Action]:
    """Raised, brought to where it shall be, and put down, let fall or held there."""
    layout = task.layout
    goal = _goal(task)
    own_base = float(layout.position(task.name)[2]) - layout.height(task.name) / 2
    rise = _rise(task, goal, own_base)
    moves = [(rise, WAYS["up"], 1.0, "lift")]
    at = np.zeros(3)
    for number, there in enumerate((*_over(task), goal.offset), 1):
        way, at = there - at, there
        if (far := float(np.linalg.norm(way))) > 1e-3:
            label = "carry" if number == 1 else "carry_on"
            moves.append((far, unit(way), CARRYING.along_ratio, label))
    moves += _turns(task)
    dropped = _is_let_fall(task)
    if goal.base is not None and not dropped:
        down = rise + own_base - goal.base - CARRYING.release_m
        moves.append((down, WAYS["down"], 1.0, "lower"))
    return _moves(task, moves, held=goal.base is None and not dropped)


def turned_in_hand(task: Task) -> float:
    """By how many degrees it is turned while it is held: tilted, or upside down; else 0."""
    for frame in task.intent.frames:
        if frame.posture == "inverted" and frame.sense in _TURNED:
            return 180.0
        if frame.sense == "lean":
            return frame.angle or CARRYING.tilt_deg
    return 0.0


def _turns(task: Task) -> list[_Move]:
    """Its turning in the hand, and back where it is put down as it stood."""
    degrees = turned_in_hand(task)
    if not degrees:
        return []
    axis = np.cross(UP, WAYS[task.way() or "right"])
    turn: _Move = (math.radians(degrees), axis, 1.0, "turn")
    upright = task.intent.has("set_down", "descend") and degrees < 180.0
    return [turn, (math.radians(degrees), -axis, 1.0, "turn_back")] if upright else [turn]


def _is_let_fall(task: Task) -> bool:
    return task.intent.has("fall", "land") and not task.intent.has("set_down")


def _moves(task: Task, moves: list[_Move], *, held: bool) -> list[Action]:
    """Its weight carried, and forces that bring it by ways or turn it, one after the other with a
    moment between them. held: aloft to the end."""
    dt, first = task.clip.step_seconds, act.STEPS.first_step
    start, pushes = first, []
    total = sum(share for *_, share, _ in moves)
    steps = CARRYING.whole_share * task.clip.steps - (len(moves) - 1) * act.STEPS.hang_steps
    for way, direction, share, label in moves:
        half = max(round(steps * share / total / 2), 2)
        if label.startswith("turn"):
            rate = way / (2 * half * dt)
            pushes += [
                act.spin(task.name, direction, rate, start=start, duration=2 * half, label=label),
                act.spin(
                    task.name, direction, 0.0, start=start + 2 * half,
                    duration=act.STEPS.hang_steps, label=f"{label}_stop",
                ),
            ]  # fmt: skip
            start += 2 * half + act.STEPS.hang_steps
            continue
        gain = way / (half * dt) ** 2
        forward, back = (
            act.toward_or_along(gain, **_along(side * direction), quantity="acceleration")
            for side in (1, -1)
        )
        pushes += [
            act.push(task.name, forward, start=start, duration=half, label=label),
            act.push(task.name, back, start=start + half, duration=half, label=f"{label}_slow"),
        ]
        start += 2 * half + act.STEPS.hang_steps
    end = task.clip.steps if held else start - act.STEPS.hang_steps
    weight = act.toward_or_along(mech.G, way="up", quantity="acceleration")
    return [act.push(task.name, weight, start=first, duration=end - first, label="hold"), *pushes]


def _along(direction: FloatArray) -> dict[str, Any]:
    """How a force along an upright or level unit direction (3,) is told."""
    if abs(direction[2]) > 0.5:
        return {"way": "up" if direction[2] > 0 else "down"}
    return {"vector": direction}


def _over(task: Task) -> tuple[FloatArray, ...]:
    """The level way (3,) to what it is carried across, where that is said."""
    place = task.intent.place("over", "above")
    if place is None or place.kind != "object" or not task.layout.has(place.name):
        return ()
    return (level(task.layout.position(place.name) - task.layout.position(task.name)),)


def _rise(task: Task, goal: _Goal, own_base: float) -> float:
    """How high it is raised, m: over what it is put on and what it is carried across."""
    layout = task.layout
    over = CARRYING.drop_sizes if _is_let_fall(task) else CARRYING.clear_sizes
    clear = max(over * layout.height(task.name), CARRYING.min_clear_m)
    tops = [goal.base] if goal.base is not None else []
    if (place := _into(task)) is not None:
        tops.append(_top(layout, place))
    for way in (*_over(task), goal.offset):
        tops += [_top(layout, other) for other in met_across(task.layout, task.name, way)]
    least = max((top - own_base + clear for top in tops), default=0.0)
    if turned_in_hand(task):
        # Its corners clear what is below as it turns.
        half = (layout.extent(task.name, WAYS["right"]), layout.height(task.name) / 2)
        clear = max(clear, math.hypot(*half) - half[1] + CARRYING.min_clear_m)
    wanted = max(CARRYING.rise_sizes * layout.size(task.name), CARRYING.min_clear_m)
    return max(min(wanted, free_way(layout, task.name, WAYS["up"])), least, clear)


def met_across(layout: Layout, name: str, offset: FloatArray) -> list[str]:
    """The things that a thing would meet on a level way (3,), m."""
    distance = float(np.linalg.norm(offset))
    if distance < 1e-3:
        return []
    way = unit(offset)
    aside = np.array([-way[1], way[0], 0.0])
    found = []
    for item in layout.state.objects:
        if item.name == name or not layout.has(item.name):
            continue
        away = layout.position(item.name) - layout.position(name)
        wide = layout.extent(name, aside) + layout.extent(item.name, -aside)
        reach = layout.extent(name, way) + layout.extent(item.name, -way)
        if -reach < float(away @ way) < distance + reach and abs(float(away @ aside)) < wide:
            found.append(item.name)
    return found


def _top(layout: Layout, name: str) -> float:
    """Height of the top of a thing, m."""
    return float(layout.position(name)[2]) + layout.height(name) / 2


def _into(task: Task) -> str | None:
    """The thing that it shall end in."""
    place = task.intent.place(*_VESSEL)
    known = place is not None and place.kind == "object" and task.layout.has(place.name)
    return place.name if place is not None and known else None


def _goal(task: Task) -> _Goal:
    """Where it is brought: onto a thing or a support, beside a thing, a way along, or nowhere."""
    layout = task.layout
    here = layout.position(task.name)
    under = here[2] - layout.height(task.name) / 2
    put_down = task.intent.has("set_down", "descend", "fall", "land")
    # "The bowl turns upside down": it stands so in the end; what is picked up for it is held.
    put_down |= task.intent.senses == {"turn"}
    nowhere = np.zeros(3)
    for frame in reversed(task.intent.frames):
        for relation, place in frame.places:
            if relation in ("off", "from", "over", "above") or place.name == task.name:
                continue
            if (goal := _at(task, relation, place)) is not None:
                return goal
    if (way := _level_way(task)) is not None and not _over(task):
        far = min(
            good_way(layout, task.name, WAYS[way]),
            CARRYING.most_sizes * layout.size(task.name),
        )
        return _Goal(WAYS[way] * (task.far or far), float(under) if put_down else None)
    beyond = _over(task)
    if beyond and put_down:
        # Over it and down again is on its other side, as far as it was on this one.
        return _Goal(2 * beyond[0], float(under))
    return _Goal(beyond[0] if beyond else nowhere, float(under) if put_down else None)


def _level_way(task: Task) -> Direction | None:
    """The way to the side that is said: "is lifted up and carried off to the left"."""
    said = [frame for frame in task.intent.frames if frame.direction not in (None, "up", "down")]
    # "Tilted to the left" is no way to go.
    for frame in (frame for frame in said if frame.sense not in _TURNED):
        for way in ways_of(frame.direction, frame, task.name, task.layout):
            return way
    return None


def _at(task: Task, relation: str, place: Place) -> _Goal | None:
    """On, in or beside a thing, or on a support; None where that says nothing of where."""
    layout, name = task.layout, place_name(place)
    here = layout.position(task.name)
    if place.kind == "object" and layout.has(name):
        away = level(layout.position(name) - here)
        top, high = _top(layout, name), layout.height(name)
        if relation in _VESSEL:
            return _Goal(away, top - CARRYING.sunk_share * high)
        if relation in _UPON:
            return _Goal(away, top)
        if relation in SIDE_WAYS or relation in _TO:
            side = WAYS[SIDE_WAYS[relation]] if relation in SIDE_WAYS else -unit(away)
            room = layout.extent(name, side) + layout.extent(task.name, -side)
            room += CARRYING.beside_sizes * layout.size(task.name)
            return _Goal(away + side * room, top - high)
    support = layout.state.support(place.name)
    if relation not in _UPON or support is None or layout.base(task.name) == place.name:
        return None
    if isinstance(support.shape, Slab):
        return _Goal(_onto_slab(layout, task.name, support.shape), _slab_top(support.shape))
    edge = layout.nearest_edge(task.name)
    if edge is None or place.name != layout.ground():
        return None
    way, distance = edge
    return _Goal(way * (distance + 1.5 * layout.extent(task.name, -way)), layout.ground_height())


def _slab_top(slab: Slab) -> float:
    return slab.position[2] + slab.size[2] / 2


def _onto_slab(layout: Layout, name: str, slab: Slab) -> FloatArray:
    """The level way (3,) to the nearest place on a slab where it stands whole, m."""
    turn = np.array([[np.cos(slab.yaw), np.sin(slab.yaw)], [-np.sin(slab.yaw), np.cos(slab.yaw)]])
    middle = np.array(slab.position[:2])
    here = layout.position(name)[:2]
    room = np.maximum(np.array(slab.size[:2]) / 2 - layout.size(name), 0.0)
    there = middle + np.clip(turn @ (here - middle), -room, room) @ turn
    return np.array([*(there - here), 0.0])
