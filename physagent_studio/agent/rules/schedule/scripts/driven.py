"""What is on wheels drives along its axis and is steered: a turn, a circle, round a thing."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import good_way, seen_along
from physagent_studio.agent.rules.scene.measures import WAYS, FloatArray, Layout, level
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.paths import reach
from physagent_studio.agent.rules.schedule.scripts.task import TASK, Task
from physagent_studio.agent.rules.schedule.speeds import speed_range
from physagent_studio.program.actions import Action, Directed


@dataclass(frozen=True, slots=True)
class DrivenSettings:
    """How a thing on wheels is steered."""

    # own lengths, 1..3: radius of the circle on which a car turns: 5.5 m over 4.4 m
    min_radius_lengths: float = 1.25
    radius_ratios: tuple[float, ...] = (1.6, 1.0)  # 1..4: of that radius, the wider one first
    # 0.4..1: of that radius, around a thing: as wide as there is room for
    round_ratios: tuple[float, ...] = (1.0, 0.7, 0.5)
    straight_shares: tuple[float, ...] = (0.45, 0.25)  # 0..1: of the free way, before it turns
    # own sizes, 0.1..1: between it and what it drives around
    clear_sizes: float = 0.35
    drive_share: float = 0.8  # 0.5..0.95: of the clip, for which it drives
    speed_share: float = 0.9  # 0.5..1: of the highest speed that the verb allows
    turn_deg: float = 90.0  # 45..120: of a turn of which nobody says how far
    # cosine, 0.8..1: of its axis and the way to turn to: what it faces already is no turn
    min_side_cosine: float = math.cos(math.radians(20.0))


DRIVEN = DrivenSettings()


@dataclass(frozen=True, slots=True)
class Leg:
    """A part of its way: length, m, and by how much it turns on it, rad, to its left."""

    length: float
    turn: float = 0.0


TURNS = ("turn", "turn_around", "curve", "circle")
"""Senses in which what is on wheels leaves the straight line."""


def turns_off(task: Task) -> bool:
    """Whether the prompt has it leave the straight line."""
    return any(
        f.sense in TURNS or f.path in ("curve", "circle") or f.place("around") is not None
        for f in task.intent.frames
    )


def way_before_turn(task: Task) -> FloatArray | None:
    """Level unit direction (3,) in which it sets out: the one that is said of it before it turns,
    else to what it shall go around; None where neither is said."""
    for frame in task.intent.frames:
        way = None if frame.sense in TURNS else frame.direction
        if way in ("left", "right", "away", "toward_camera"):
            return WAYS[way]
    other = _around_what(task)
    return None if other is None else task.way_onto(other)


def drive(task: Task) -> list[Action]:
    """Pushed to its speed, kept at it against what its wheels lose, and steered leg by leg."""
    legs = _legs(task)
    axis, wheels = task.axis_way(), task.wheels
    assert axis is not None
    assert wheels is not None
    length = sum(leg.length for leg in legs)
    speed = min(task.speed or length / task.seconds(DRIVEN.drive_share), _most(task))
    first = task.delay + act.STEPS.push_steps
    start = act.push(task.name, act.toward_or_along(speed, vector=axis), start=task.delay)
    # Before it is at its speed it has gone half as far.
    gone = speed * act.STEPS.push_steps * task.clip.step_seconds / 2
    last = min(first + _steps(task, length - gone, speed), task.clip.steps - 1)
    force = Directed(
        magnitude=round(wheels.rolling * mech.G, 4), along="velocity", quantity="acceleration"
    )
    kept = act.push(task.name, force, start=first, duration=last - first, label="drive")
    return [start, kept, *_steered(task, legs, speed, gone)]


def _steered(task: Task, legs: Sequence[Leg], speed: float, gone: float) -> Iterator[Action]:
    mass, at = task.layout.mass(task.name), -gone
    for number, leg in enumerate(legs):
        begin = task.delay + act.STEPS.push_steps + _steps(task, max(at, 0.0), speed)
        at += leg.length
        end = task.delay + act.STEPS.push_steps + _steps(task, max(at, 0.0), speed)
        if leg.turn and end > begin and begin < task.clip.steps:
            # The turn that it shall make, in the whole steps that there are for it.
            rate = leg.turn / ((end - begin) * task.clip.step_seconds)
            force, side = mass * speed * abs(rate), math.copysign(90.0, leg.turn)
            bent = act.bend(task.name, force, side, start=begin, duration=end - begin)
            yield bent.model_copy(update={"id": f"{bent.id[:60]}_{number}"})


def _steps(task: Task, way: float, speed: float) -> int:
    return max(round(way / speed / task.clip.step_seconds), 0)


def _most(task: Task) -> float:
    """The highest speed that its verbs allow, m/s."""
    size = task.layout.size(task.name)
    found = [row[1] for f in task.intent.frames if (row := speed_range(f, size)) is not None]
    return DRIVEN.speed_share * max(found, default=TASK.max_speed_mps)


def _legs(task: Task) -> Sequence[Leg]:
    """The first way of those that the prompt may mean that is seen to its end; else the one of
    which most is seen. What the clip has no time for is left out."""
    room = _most(task) * task.seconds(DRIVEN.drive_share)
    found = [tuple(_within(legs, room)) for legs in _choices(task)]
    shares = [seen_along(task.layout, task.name, _points(task, legs)) for legs in found]
    return found[shares.index(max(shares))]


def _within(legs: Iterable[Leg], room: float) -> Iterator[Leg]:
    """The legs as far as there is room, straight ones first made shorter."""
    legs = tuple(legs)
    bent = sum(leg.length for leg in legs if leg.turn)
    straight = sum(leg.length for leg in legs if not leg.turn)
    part = min(max((room - bent) / max(straight, 1e-9), 0.15), 1.0)
    for leg in legs:
        own = leg if leg.turn else Leg(leg.length * part)
        left = min(own.length, max(room, 0.0))
        room -= own.length
        if left > 0:
            yield Leg(left, own.turn * left / own.length)


def _points(task: Task, legs: Sequence[Leg]) -> FloatArray:
    """(n, 2) where its centre comes by along its way, offsets from where it stands, m."""
    axis = task.axis_way()
    assert axis is not None
    angle, at, found = math.atan2(axis[1], axis[0]), np.zeros(2), [np.zeros(2)]
    for leg in legs:
        for _ in range(12):
            angle += leg.turn / 24
            at = at + leg.length / 12 * np.array([math.cos(angle), math.sin(angle)])
            angle += leg.turn / 24
            found.append(at)
    return np.array(found)


def _choices(task: Task) -> Iterator[Sequence[Leg]]:
    """Ways that the prompt may mean, the likeliest first."""
    axis = task.axis_way()
    assert axis is not None
    layout, name = task.layout, task.name
    least = DRIVEN.min_radius_lengths * 2 * layout.extent(name, axis)
    free, around = good_way(layout, name, axis), _around_what(task)
    circles = any("circle" in (f.sense, f.path) for f in task.intent.frames)
    sides = _sides(task)
    if around is not None:
        found = [
            legs
            for ratio in DRIVEN.round_ratios
            for side in sides
            for legs in _round(task, around, side, ratio * least, circles)
        ]
        yield from found
        if found:
            return
    for ratio in DRIVEN.radius_ratios:
        radius = ratio * least
        for side in sides:
            for share in (0.0,) if circles else DRIVEN.straight_shares:
                turn = side * _angle(task, circles)
                after = 0.0 if circles else max(share * free, radius)
                yield (
                    Leg(share * free),
                    Leg(radius * abs(turn), turn),
                    Leg(after),
                )


def _around_what(task: Task) -> str | None:
    for frame in task.intent.frames:
        relations = ("around", "object") if frame.sense in ("circle", "miss") else ("around",)
        place = frame.place(*relations)
        if place is not None and place.kind == "object" and task.layout.has(place.name):
            return place.name
    return None


def _angle(task: Task, circles: bool) -> float:
    """How far it shall turn, rad: as the prompt says, half round, all round, or to a side."""
    said = next((f.angle for f in task.intent.frames if f.angle is not None), None)
    if said is not None:
        return math.radians(said)
    if circles:
        return 2 * math.pi * (next((f.count for f in task.intent.frames if f.count), 1) or 1)
    if task.intent.has("turn_around"):
        return math.pi
    off = _off(task)
    return math.radians(DRIVEN.turn_deg) if off is None else abs(off)


def _sides(task: Task) -> tuple[float, ...]:
    """+1 to its own left, −1 to its right: the one that is said, else either."""
    if (off := _off(task)) is not None:
        return (math.copysign(1.0, off),)
    for frame in task.intent.frames:
        if frame.sense in TURNS and frame.direction in ("left", "right"):
            return (1.0 if frame.direction == "left" else -1.0,)
    return (1.0, -1.0)


def _off(task: Task) -> float | None:
    """Angle, rad, from its axis to the way in depth that it shall turn to; None if none is said."""
    axis = task.axis_way()
    assert axis is not None
    for frame in task.intent.frames:
        if frame.sense in ("turn", "curve") and frame.direction in ("away", "toward_camera"):
            way = WAYS[frame.direction]
            if float(way @ axis) > DRIVEN.min_side_cosine:
                return None
            return math.atan2(float(axis[0] * way[1] - axis[1] * way[0]), float(axis @ way))
    return None


def _round(
    task: Task, other: str, side: float, least: float, circles: bool
) -> Iterator[Sequence[Leg]]:
    """Out of its line, along the circle around a thing, and back into the line, or not as far;
    or all round.

    side: +1 with the thing on its left. It turns away from the thing, then goes straight along
    the tangent that both circles share. Nothing where it stands too near.
    """
    layout, axis = task.layout, task.axis_way()
    assert axis is not None
    clear = DRIVEN.clear_sizes * layout.size(task.name)
    radius = max(reach(layout, task.name) + reach(layout, other) + clear, least)
    left = np.array([-axis[1], axis[0], 0.0])
    to = level(layout.position(other) - layout.position(task.name)) + side * least * left
    apart, sum_of = float(np.hypot(*to[:2])), least + radius
    if apart <= sum_of:
        return
    straight = math.sqrt(apart**2 - sum_of**2)
    heading = math.atan2(to[1], to[0]) - side * math.atan2(sum_of, straight)
    out = (heading - math.atan2(axis[1], axis[0]) + math.pi) % (2 * math.pi) - math.pi
    if out * side > 0:
        # It lies so far aside that nothing has to be turned away from it first.
        return
    ahead = (Leg(least * abs(out), out), Leg(straight))
    if circles:
        yield (*ahead, Leg(2 * math.pi * radius, side * 2 * math.pi))
        return
    back = (Leg(straight), Leg(least * abs(out), out))
    passed = Leg(2 * radius * abs(out), -2 * out)
    yield from ((*ahead, passed, *back), (*ahead, passed, back[0]), (*ahead, passed))


def room_ahead(layout: Layout, name: str, axis: FloatArray) -> FloatArray:
    """The end of an axis, (3,), that has more room before it in the picture."""
    return axis if good_way(layout, name, axis) >= good_way(layout, name, -axis) else -axis
