"""Which way things on wheels face, and what the prompt lets them do on their wheels.

The axis is what the picture shows: the longer side of the rectangle on which it is seen to stand;
else that of the reconstructed outline from above. Its front end is not measured: it is
the end with which the thing goes first, as the prompt has it go, or the other one where the prompt
has it go backwards.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.facing import likely_end, long_axis
from physagent_studio.agent.rules.scene.measures import (
    WAYS,
    FloatArray,
    Layout,
    level,
    named_way,
    unit,
)
from physagent_studio.agent.rules.schedule import scripts
from physagent_studio.agent.rules.schedule.choosing import script_for
from physagent_studio.agent.rules.schedule.ramps import down_ramp, rolling_for
from physagent_studio.agent.rules.schedule.scripts import Task
from physagent_studio.agent.rules.schedule.told_order import is_told_to_back
from physagent_studio.knowledge import kind_of, usual_size
from physagent_studio.program.scene.state import SceneObject, Wheels
from physagent_studio.reconstruction.shapes.prisms import plan_seen


@dataclass(frozen=True, slots=True)
class HeadingSettings:
    """Which way wheels face, and how freely they turn."""

    # cosine, 0..0.7: of axis and way; below, it is moved, not driven
    min_along_cosine: float = math.cos(math.radians(75.0))
    # 5..50: of an axis read off an outline: it may face what it drives to
    axis_error_deg: float = 45.0
    # ratio, 0.005..0.05: resistance of small wheels on a hard floor, .01 to .03
    usual_rolling: float = 0.02
    caster_grip: float = 0.02  # ratio, 0.005..0.1: what goes any way has no more across than along
    # sine, 0.2..0.6: of a direction along a named way, for it to be said
    min_named_sine: float = math.sin(math.radians(22.5))
    stop_share: float = 0.5  # 0.2..0.9: of the clip, in which it comes to rest where it shall
    min_rolling: float = 0.01  # ratio, 0.002..0.05: of a free-running toy
    max_rolling: float = 0.3  # ratio, 0.1..1: of one that is braked


HEADING = HeadingSettings()


OFF_ITS_WHEELS = ("drift", "spin", "flip", "tip_over")
"""Senses in which a thing leaves its axis. Wheels that hold would hinder them, so it gets none: it
slides and turns as its material lets it, from the beginning of the clip on."""


def with_wheels(
    layout: Layout, tasks: list[Task], masks: Mapping[str, np.ndarray]
) -> tuple[tuple[SceneObject, ...], tuple[str, ...]]:
    """The objects with wheels under those whose kind has them, and a sentence for each front
    that is assumed. masks: (H, W) bool of objects, where there is a photo."""
    by_name = {task.name: task for task in tasks}
    found: list[SceneObject] = []
    said: list[str] = []
    for item in layout.state.objects:
        wheels = None
        kind = kind_of(item.name)
        rolls = kind is not None and kind.wheels is not None
        if rolls and item.wheels is None and item.body.kind == "rigid" and layout.has(item.name):
            axis = _seen_axis(item.name, layout, masks.get(item.name))
            wheels, words = _wheels(item, layout, by_name.get(item.name), axis)
            said += words
        found.append(item if wheels is None else item.model_copy(update={"wheels": wheels}))
    return tuple(found), tuple(said)


def _wheels(
    item: SceneObject, layout: Layout, task: Task | None, seen: FloatArray | None
) -> tuple[Wheels | None, tuple[str, ...]]:
    """The wheels of one thing, None where it has or uses none, and what is assumed of it."""
    kind = kind_of(item.name)
    if kind is None or kind.wheels is None:
        return None, ()
    if task is not None and leaves_its_axis(task, kind.wheels != "any_way"):
        return None, ()
    way, bound = (None, False) if task is None else _way(task)
    axis, shown = long_axis(layout, item.name)
    axis, shown = (axis, shown) if seen is None else (seen, True)
    if kind.wheels == "short_axis":
        axis = np.array([-axis[1], axis[0], 0.0])
    # What goes up or down a slope on wheels lies along it.
    on_slope = way is not None and layout.downhill(item.name) is not None
    keeps = shown and not on_slope and kind.wheels != "any_way"
    if way is None and task is not None and scripts.turns_off(task):
        axis = scripts.room_ahead(layout, item.name, axis)
    backwards = task is not None and task.backwards
    if task is not None and task.goes_its_own_way and not on_slope:
        # The outline says less than the sides on which it is seen to stand.
        front = likely_end(layout, item.name, axis if shown else None)
        way = -front if backwards else front
    goes = axis if way is None else _facing(axis, way, keeps, bound)
    front = -goes if backwards else goes
    heading = round(math.degrees(math.atan2(front[1], front[0])), 1) % 360
    rolling = None if task is None else rolling_for(task) or _rolling_to_stop(task)
    wheels = Wheels(heading=heading, rolling=HEADING.usual_rolling if rolling is None else rolling)
    if kind.wheels == "any_way":
        return wheels.model_copy(update={"known": True, "grip": HEADING.caster_grip}), ()
    why = _reason(way is not None, backwards, shown)
    text = f"which way {item.name} faces is not seen in the picture; taken to face {_said(front)}"
    return wheels, (f"{text}, {why}",)


def _said(way: FloatArray) -> str:
    """A level unit direction in words: one named way, or two where it lies well between them."""
    parts = [
        level(way) * np.eye(3)[axis] for axis in (0, 1) if abs(way[axis]) > HEADING.min_named_sine
    ]
    return " and ".join(named_way(part).replace("_", " the ") for part in parts)


def _reason(goes: bool, backwards: bool, shown: bool) -> str:
    if backwards:
        return "as it goes backwards"
    if goes:
        return "the way it goes" if shown else "the way it goes, for its outline shows no axis"
    return "along its longer side" if shown else "for its outline shows no axis"


def leaves_its_axis(task: Task, steered: bool) -> bool:
    """Whether the prompt has it skid, drift, be turned or tipped, so that its wheels do not hold.

    steered: whether its wheels can be turned.
    """
    intent, on_slope = task.intent, task.layout.ramp_below(task.name) is not None
    if intent.manner("skidding") or intent.has(*OFF_ITS_WHEELS):
        return True
    if scripts.turns_off(task) and (on_slope or not steered):
        return True
    sideways = any(f.direction == "sideways" for f in intent.frames)
    tipped = intent.has("topple", "lose_balance", "knock_over") and not intent.hits
    return sideways or tipped or (intent.has("reverse") and on_slope)


def _seen_axis(name: str, layout: Layout, mask: np.ndarray | None) -> FloatArray | None:
    """Level unit axis (3,) of the longer side on which it is seen to stand; None if unclear."""
    camera, slope = layout.state.camera, layout.ramp_below(name)
    if mask is None or camera is None or slope is not None or layout.carrier(name) is None:
        return None
    foot = float(layout.position(name)[2]) - layout.extent(name, -WAYS["up"])
    usual = usual_size(name)
    plan = plan_seen(mask, camera, foot, usual.depth, usual.aspect[0] if usual.aspect else None)
    return None if plan is None else np.array([*plan.axes[0], 0.0])


def _facing(axis: FloatArray, way: FloatArray, keeps: bool, bound: bool) -> FloatArray:
    """Level unit direction in which it sets out: that of its axis, the end nearer to the way.

    way: as the prompt has it, (3,) level. keeps: whether it has to keep to its axis at all.
    bound: whether the way is exact: to a thing, down a slope.
    """
    if not keeps or abs(float(axis @ way)) < HEADING.min_along_cosine:
        return way
    nearer = axis if float(axis @ way) >= 0 else -axis
    close = float(nearer @ way) > math.cos(math.radians(HEADING.axis_error_deg))
    return way if bound and close else nearer


def _way(task: Task) -> tuple[FloatArray | None, bool]:
    """Level unit direction (3,) in which the prompt has it go, None where it has it go nowhere;
    and whether that is exact: to a thing or along a slope, and no direction by its name."""
    script, ramp = script_for(task), task.ramp_ahead()
    if is_told_to_back(task):
        return _way_back(task), False
    if scripts.turns_off(task):
        return scripts.way_before_turn(task), False
    if script is scripts.up_ramp and ramp is not None:
        return np.array([math.cos(ramp.yaw), math.sin(ramp.yaw), 0.0]), True
    if script is down_ramp:
        downhill = task.layout.downhill(task.name)
        return (None, False) if downhill is None else (unit(level(downhill)), True)
    if script is scripts.off_edge:
        return unit(level(scripts.way_off(task)[0])), False
    if script is scripts.turn_back and task.target() is None and task.way() is None:
        return None, False
    if script in (scripts.along_ground, scripts.turn_back):
        target = task.target() is not None and (task.way() is None or bool(task.intent.hits))
        return scripts.way_ahead(task), target
    return None, False


def _way_back(task: Task) -> FloatArray | None:
    """ "Rolls back to the right, then drives on": the way that is said of the one or the other."""
    told = [WAYS.get(f.direction) for f in task.intent.frames if not f.negated]  # type: ignore[arg-type]
    ahead = next((-way for way in told[1:] if way is not None), None)
    return ahead if told[0] is None else told[0]


_STOPS = ("stop", "settle")


def _rolling_to_stop(task: Task) -> float | None:
    """Resistance with which it is at rest half through the clip where it shall stop on level
    ground: way d in time t needs 2 d / t². None where it shall not, or hits something first."""
    stops = task.intent.has(*_STOPS) or task.ends_short
    # What stops and drives on does so on its way, and not in the end.
    stops = stops and (task.intent.frames[-1].sense in _STOPS or not is_told_to_back(task))
    if not stops or task.intent.hits or task.layout.downhill(task.name) is not None:
        return None
    slowing = 2 * scripts.way_to_go(task) / task.seconds(HEADING.stop_share) ** 2
    return round(min(max(slowing / mech.G, HEADING.min_rolling), HEADING.max_rolling), 4)
