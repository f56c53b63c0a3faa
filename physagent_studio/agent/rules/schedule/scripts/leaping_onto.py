"""A leap onto the top of something higher: a table, a box, a tin."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import free_way
from physagent_studio.agent.rules.scene.measures import WAYS, FloatArray, level, unit
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.task import Task
from physagent_studio.language import Place
from physagent_studio.program.actions import Action
from physagent_studio.program.scene.state import Slab


@dataclass(frozen=True, slots=True)
class OntoSettings:
    """How what leaps onto a thing gets there."""

    clear_heights: float = 0.25  # own heights, 0.1..0.5: by which its foot clears the edge
    most_clear_m: float = 0.08  # m, 0.03..0.2: no more than that
    arc_ratio: float = 1.25  # ratio, 1.05..1.6: of each arc's height to that tried before it
    # ratio, 0.2..0.6: of its way, by which it comes down at least: flatter, it slides on over it
    steep_ratio: float = 0.35
    arc_tries: int = 8  # count, 4..12: of arcs, until one clears the edge
    hold_steps: int = 10  # steps, 4..20: in which it comes to a stand up there
    beside_sizes: float = 0.3  # own sizes, 0.1..0.8: between it and what stands up there already
    still_steps: int = 60  # steps, 20..120: for which it is held where it came down
    side_spots: int = 9  # count, 5..15: of places along each side of a top, of which one is free


ONTO = OntoSettings()


def top_aim(task: Task) -> Place | None:
    """What it shall leap onto, where the top of that lies higher than its foot; else None."""
    place = task.intent.place("on", "atop", senses=("jump",))
    if place is None or place.part or task.intent.hits or task.layout.carrier(task.name) is None:
        return None
    carried_by = (task.layout.carrier(task.name), task.layout.base(task.name))
    if place.name in (task.name, *carried_by) or any(f.count for f in task.intent.frames):
        return None
    top = _top(task, place)
    return place if top is not None and top > _foot(task) + 1e-3 else None


def leap_onto(task: Task) -> list[Action]:
    """Up and onto it on an arc that clears its edge; where it stands too near for that, straight up
    first, and over once its foot is above the top. There it comes to a stand."""
    layout, place = task.layout, top_aim(task)
    assert place is not None
    way, gap = _way_onto(task, place), max(layout.gap(task.name, place.name), 0.01)
    rise = (_top(task, place) or 0.0) - _foot(task)
    far = float(np.linalg.norm(way))
    clear = rise + min(ONTO.clear_heights * layout.height(task.name), ONTO.most_clear_m)
    kick, dt = act.STEPS.kick_steps, task.clip.step_seconds
    room = max(free_way(layout, task.name, WAYS["up"]), clear)
    # Down onto it, and not along it.
    least = min(max(clear, rise + ONTO.steep_ratio * far), room)
    arcs = [min(least * ONTO.arc_ratio**k, room) for k in range(ONTO.arc_tries)]
    found: list[Action] = []
    arc = next((high for high in arcs if _clears(high, rise, clear, gap, far)), None)
    seconds = _aloft(arcs[0] * ONTO.arc_ratio if arc is None else arc, rise)
    if arc is not None:
        speed, elevation = mech.launch(far, rise, seconds, kick * dt)
        forward = far / seconds
        force = act.toward_or_along(speed, vector=unit(way), elevation=elevation)
        found.append(act.push(task.name, force, start=task.delay, duration=kick, label="jump"))
    else:
        speed, _ = mech.launch(0.0, rise, seconds, kick * dt)
        upward = math.sqrt(2 * mech.G * arcs[0] * ONTO.arc_ratio)
        late = (upward - math.sqrt(max(upward**2 - 2 * mech.G * clear, 0.0))) / mech.G
        forward = far / (seconds - late)
        start = task.delay + kick + round(late / dt)
        found += [
            act.push(
                task.name, act.toward_or_along(speed, way="up"), start=task.delay, duration=kick,
                label="jump",
            ),
            act.push(
                task.name, act.toward_or_along(forward, vector=unit(way)), start=start,
                duration=kick, label="over",
            ),
        ]  # fmt: skip
    landed = act.on_contact(task.name, place.name)
    hold = act.against(forward / (ONTO.hold_steps * dt) + mech.G * task.ground_friction())
    return [
        *found,
        act.push(task.name, hold, start=0, when=landed, duration=ONTO.still_steps, label="land"),
    ]


def _clears(high: float, rise: float, clear: float, gap: float, far: float) -> bool:
    """Whether an arc to that height, which ends `far` away on the top, is above its edge there."""
    at = _aloft(high, rise) * gap / max(far, 1e-6)
    return math.sqrt(2 * mech.G * high) * at - mech.G * at * at / 2 >= clear - 1e-9


def _aloft(high: float, rise: float) -> float:
    """Seconds up to a height and down again to one of `rise`."""
    return math.sqrt(2 * high / mech.G) + math.sqrt(2 * max(high - rise, 0.0) / mech.G)


def _foot(task: Task) -> float:
    return float(task.layout.position(task.name)[2] - task.layout.height(task.name) / 2)


def _top(task: Task, place: Place) -> float | None:
    layout, support = task.layout, task.layout.state.support(place.name)
    if support is not None and isinstance(support.shape, Slab):
        return support.shape.position[2] + support.shape.size[2] / 2
    if place.kind == "object" and layout.has(place.name):
        return float(layout.position(place.name)[2] + layout.height(place.name) / 2)
    return None


def _way_onto(task: Task, place: Place) -> FloatArray:
    """The level way (3,) to the middle of a thing, or to the nearest free place on a slab: nearest
    to it, or to what it shall land beside."""
    layout, support = task.layout, task.layout.state.support(place.name)
    here = layout.position(task.name)
    if support is None or not isinstance(support.shape, Slab):
        return level(layout.position(place.name) - here)
    slab, turn = support.shape, support.shape.yaw
    sides = [np.array([math.cos(a), math.sin(a), 0.0]) for a in (turn, turn + math.pi / 2)]
    rooms = [
        max(size / 2 - layout.extent(task.name, side), 0.0)
        for size, side in zip(slab.size[:2], sides, strict=True)
    ]
    near = task.intent.place("near", "at")
    aim = layout.position(near.name) if near and layout.has(near.name) else here
    off = [float(np.clip((aim - np.array(slab.position)) @ side, -room, room))
           for side, room in zip(sides, rooms, strict=True)]  # fmt: skip
    spread = np.linspace(-1.0, 1.0, ONTO.side_spots)
    spots = [
        np.array(slab.position) + sides[0] * x + sides[1] * y
        for x in (off[0], *(spread * rooms[0]))
        for y in (off[1], *(spread * rooms[1]))
    ]
    best = min(spots, key=lambda spot: (_lack(task, spot), np.linalg.norm(level(spot - aim))))
    return level(best - here)


def _lack(task: Task, spot: FloatArray) -> float:
    """How much room it would lack beside what stands up there already, at this place, m."""
    layout, margin = task.layout, ONTO.beside_sizes * task.layout.size(task.name)
    axes, lack = (WAYS["right"], WAYS["away"]), 0.0
    for item in layout.state.objects:
        if item.name == task.name or not layout.is_raised(item.name):
            continue
        away = level(layout.position(item.name) - spot)
        reach = [layout.extent(task.name, a) + layout.extent(item.name, a) for a in axes]
        free = max(abs(float(away @ a)) - r for a, r in zip(axes, reach, strict=True))
        lack = max(lack, margin - free)
    return lack
