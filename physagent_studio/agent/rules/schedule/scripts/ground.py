"""Along level ground: pushes that get a thing to where it shall be, straight or curved."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.contract.living import is_living
from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import free_way, good_way, way_hidden
from physagent_studio.agent.rules.scene.measures import (
    WAYS,
    FloatArray,
    Layout,
    level,
    place_name,
    unit,
)
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.paths import arc_length, clearance, free_turn
from physagent_studio.agent.rules.schedule.scripts.blows import blow, sent_off, to_the_middle
from physagent_studio.agent.rules.schedule.scripts.carrying import met_across
from physagent_studio.agent.rules.schedule.scripts.stopping import brake, stopping_speed
from physagent_studio.agent.rules.schedule.scripts.task import TASK, Task
from physagent_studio.language import EDGES, Place
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.actions import Action, Directed, Direction
from physagent_studio.program.base import Position
from physagent_studio.program.scene.state import Slab


@dataclass(frozen=True, slots=True)
class GroundSettings:
    """How things are sent along the ground."""

    max_push_share: float = 0.5  # 0.2..1: of the clip, for which a thing is pushed along
    arrive_share: float = 0.6  # 0.3..0.9: of the clip, after which it is where it shall be
    carried_share: float = 0.75  # 0.4..0.9: of the clip, for which what is carried along moves
    starting_share: float = 0.2  # 0.05..0.5: of its time, in which what goes on has its speed
    max_out_sizes: float = 40.0  # own sizes, 10..100: to leave the picture; farther, it stays in it
    heap_speed_ratio: float = 0.5  # 0.2..1: over that of a fall by half its size: on the spot
    # ratio, 0.02..0.15: below which a thing goes on, as a stone on ice does
    max_glide_friction: float = 0.08
    # cosine, 0.9..1: of what lies ahead of wheels, within 15 degrees
    min_ahead_cosine: float = math.cos(math.radians(15.0))


GROUND = GroundSettings()
_TAKEN = ("pull", "push", "slide", "move", "knock")
_LED = ("push", "pull")
_GOING = words_of("move slide push pull stop settle start")
"""What is said of a thing that is carried along and has nothing else to do."""


def along_ground(task: Task) -> list[Action]:
    """Rolls or slides to where it shall get, fast enough for what it shall do there."""
    target = task.target()
    speed = _ground_speed(task, target)
    # Wheels go straight: what bends its way has none, see `heading`.
    if task.wheels is None and any(
        f.sense in ("curve", "circle") or f.path in ("curve", "circle") for f in task.intent.frames
    ):
        return _curved(task, target, speed)
    if task.wheels is None and (round_it := _way_round(task, target)) is not None:
        return _curved(task, target, speed, *round_it)
    shoved = task.wheels is None and _is_shoved(task, target)
    foot = act.foot_point(task.layout, task.name) if shoved else None
    if _is_carried(task, target):
        return _carried(task, target, foot)
    force = _aimed(task, target, speed)
    duration = _push_steps(task, target, speed)
    start = act.push(task.name, force, start=task.delay, duration=duration, point=foot)
    return [start, *brake(task, _distance(task, target), speed, duration, foot)]


def _push_steps(task: Task, target: Place | None, speed: float) -> int:
    """How long it is pushed: what would come to rest at once, for the whole of its way.

    A hand that goes along: half of distance = speed · time / 2 is gone when it lets go. A kick, a
    blow and what rolls by itself are short.
    """
    if not _is_shoved(task, target):
        return act.STEPS.push_steps
    seconds = min(
        2 * _distance(task, target) / max(speed, 0.05), task.seconds(GROUND.max_push_share)
    )
    return max(round(seconds / task.clip.step_seconds), act.STEPS.push_steps)


def _is_shoved(task: Task, target: Place | None) -> bool:
    """Whether it slides under something that pushes it on, and is not sent off by a blow; on
    wheels, whether it drives: coasting it would stand still long before the clip is over."""
    if task.wheels is not None:
        coasting = math.sqrt(2 * _distance(task, target) / (mech.G * task.wheels.rolling))
        return coasting < task.seconds(GROUND.max_push_share) and not task.intent.hits
    sliding = not task.layout.rolls(task.name)
    pushed = any(f.sense in _LED and task.name not in f.agent for f in task.intent.frames)
    led = task.intent.manner("slow", "gentle") or pushed
    blows = () if led else ("hit", "strike")
    sent = task.intent.has("kick", "throw", "slip", *blows) or bool(task.intent.struck_by)
    sent |= _leaves_what_is_on_it(task)
    free = task.ground_friction() < GROUND.max_glide_friction or task.intent.manner("flicked")
    item = task.layout.state.object(task.name)
    return sliding and bool(item and item.body.kind == "rigid") and not sent and not free


def _leaves_what_is_on_it(task: Task) -> bool:
    """ "Is pulled out from under the apple", "is pulled away": what stays would go along slowly."""
    place, above = task.intent.place("off", "from", senses=_TAKEN), task.layout.above(task.name)
    away = any(f.sense == "pull" and f.direction == "off" for f in task.intent.frames)
    return (place is not None and place.name in above) or (away and bool(above))


def _is_carried(task: Task, target: Place | None) -> bool:
    """Whether what pushes it goes with it to the end of its way, as a hand does, so that it comes
    to rest gently: where nobody says how fast, and nothing happens at the end or beside the way;
    and what walks up to a thing, and not into it."""
    plain = not task.intent.hits and task.speed is None and (target is None) is (task.far is None)
    plain &= target is None or (target.kind == "object" and is_living(task.name))
    plain |= _to_an_edge(task, target) and not task.intent.hits and task.speed is None
    out = task.intent.manner("offscreen") and not is_living(task.name)
    hows = task.intent.manner("fast", "hard", "rhythmic", "slow", "gentle")
    told = target is None and (out or hows)
    further = any(f.sense not in _GOING for f in task.intent.frames)
    on_level = task.layout.ramp_below(task.name) is None
    return plain and on_level and not told and not further and _is_shoved(task, target)


def _to_an_edge(task: Task, target: Place | None) -> bool:
    """Whether it shall stop at an edge, over which it would slide on."""
    return target is not None and target.part in EDGES and task.intent.has("stop", "settle")


def _carried(task: Task, target: Place | None, foot: Position | None) -> list[Action]:
    """Faster for half of its time and slower for the other half; what walks or drives and is not
    said to stop soon has its speed, and keeps it."""
    distance, stops = _distance(task, target), task.intent.has("stop", "settle")
    if stops or target or not (task.wheels is not None or is_living(task.name)):
        # What goes up to a thing does something there.
        early = target is not None and not stops
        seconds = task.seconds(GROUND.max_push_share if early else GROUND.carried_share)
        first, second = (round(seconds / 2 / task.clip.step_seconds),) * 2
        speed, then = 2 * distance / seconds, 0.0
    else:
        seconds = task.seconds(1.0) - task.delay * task.clip.step_seconds
        first = round(GROUND.starting_share * seconds / task.clip.step_seconds)
        second = task.clip.steps - task.delay - first
        speed = then = distance / (seconds * (1 - GROUND.starting_share / 2))
    aim = _aimed(task, target, min(max(speed, 0.02), TASK.max_speed_mps))
    start = act.push(task.name, aim, start=task.delay, duration=first, point=foot)
    aim = aim.model_copy(update={"magnitude": then and aim.magnitude})
    on = act.push(
        task.name, aim, start=0, duration=second, point=foot, when=act.after(start),
        label="go_on" if then else "slow",
    )  # fmt: skip
    return [start, on]


def _distance(task: Task, target: Place | None) -> float:
    """How far it shall go, m: to where it is told, else a good part of the way that is free."""
    if task.far is not None and not task.intent.hits:
        return task.far
    ahead = _heading(task)
    if task.intent.manner("offscreen"):
        free, size = free_way(task.layout, task.name, ahead), task.layout.size(task.name)
        return min(free, GROUND.max_out_sizes * size) + task.way_out(ahead)
    if target is not None:
        distance = task.way_to(target)
        if task.intent.hits:
            distance -= task.layout.extent(task.name, ahead)
            if task.layout.has(task.intent.hits[0]):
                distance -= task.layout.extent(task.intent.hits[0], -ahead)
        elif _to_an_edge(task, target):
            # Its front, and not its middle, is at the edge then.
            distance -= task.layout.extent(task.name, ahead)
        return max(distance, 0.3 * task.layout.size(task.name))
    return max(good_way(task.layout, task.name, ahead), task.clear_along(ahead))


def spared(task: Task, target: Place | None) -> list[str]:
    """Things on the ground that it is not meant to touch on its way."""
    meant = {task.name, *task.intent.hits, target.name if target is not None else ""}
    base = task.layout.carrier(task.name)
    things = [
        item.name
        for item in task.layout.state.objects
        if item.name not in meant and task.layout.carrier(item.name) == base
    ]
    return things + [name for name in _blocks(task.layout, task.name) if name not in meant]


def _blocks(layout: Layout, name: str) -> list[str]:
    """Slabs that stand in the way of what moves on the ground: tables without room below."""
    if layout.carrier(name) != layout.ground():
        return []
    top = float(layout.position(name)[2]) + layout.height(name) / 2
    return [
        support.name
        for support in layout.state.supports
        if isinstance(support.shape, Slab)
        and support.shape.position[2] - support.shape.size[2] / 2 < top
        and support.shape.position[2] + support.shape.size[2] / 2 > top / 2
    ]


def _way_round(task: Task, target: Place | None) -> tuple[float, float] | None:
    """Side and turn of an arc round what stands in the way; None where the way is free."""
    if target is None or target.kind == "support":
        return None
    goal, others = task.layout.position(place_name(target)), spared(task, target)
    only_by = task.passes() is not None and place_name(target) not in task.intent.hits
    if only_by or clearance(task.layout, task.name, goal, 0.0, others) > 0:
        return None
    found = []
    for sign in (1.0, -1.0):
        turn = free_turn(task.layout, task.name, goal, sign, others)
        found.append((clearance(task.layout, task.name, goal, sign * turn, others), sign, turn))
    gap, sign, turn = max(found, key=lambda row: (row[0] > 0, -row[2], row[0]))
    return (sign, turn) if gap > 0 else None


def way_ahead(task: Task) -> FloatArray:
    """Level unit direction (3,) in which the prompt has it go along the ground."""
    aim, layout = _aimed(task, task.target(), 1.0), task.layout
    if isinstance(aim.toward, str):
        way = level(layout.position(aim.toward) - layout.position(task.name))
    else:
        way = WAYS[aim.direction or "right"]
    x, y, _ = unit(level(way))
    cos, sin = math.cos(math.radians(aim.azimuth)), math.sin(math.radians(aim.azimuth))
    return np.array([cos * x - sin * y, sin * x + cos * y, 0.0])


def _on_wheels(task: Task, axis: FloatArray, target: Place | None, speed: float) -> Directed:
    """A push along its axis, to what lies ahead or straight on."""
    if target is not None and target.kind == "object" and task.passes() is None:
        place = place_name(target)
        if float(task.way_onto(place) @ axis) > GROUND.min_ahead_cosine:
            return act.toward_or_along(speed, toward=place)
    return act.toward_or_along(speed, vector=axis)


def _aimed(task: Task, target: Place | None, speed: float) -> Directed:
    if (axis := task.axis_way()) is not None:
        return _on_wheels(task, axis, target, speed)
    way = task.way()
    behind = task.intent.place("away_from")
    if behind is not None and task.layout.is_known(place_name(behind)):
        return task.away_from(place_name(behind), speed)
    if (other := task.passes()) is not None and target is not None:
        return act.toward_or_along(speed, toward=other, azimuth=_beside(task, other))
    down = task.down_the_steps()
    if down is not None and way in (None, "down") and not task.intent.hits:
        return act.toward_or_along(speed, vector=unit(down))
    if target is not None and (way is None or task.intent.hits or target.kind == "landmark"):
        aside = to_the_middle(task.layout, task.intent)
        return act.toward_or_along(speed, toward=place_name(target), azimuth=aside)
    return act.toward_or_along(speed, way=way or _open_way(task))


def _heading(task: Task) -> FloatArray:
    if (axis := task.axis_way()) is not None:
        return axis
    target, way = task.target(), task.way() or _open_way(task)
    if target is None or way in (task.way(),):
        return WAYS[way]
    return task.way_onto(place_name(target))


def _beside(task: Task, other: str) -> float:
    """Least angle off the line to a thing with which it goes by it, and by whatever else it
    shall pass, without touching, degrees."""
    layout = task.layout
    start, aim = layout.position(task.name), layout.position(other)
    ahead = unit(level(aim - start))
    left = np.array([-ahead[1], ahead[0], 0.0])
    across = WAYS["right"]
    own = layout.extent(task.name, across)
    taken: list[tuple[float, float]] = []
    for name in task.passed():
        offset = level(layout.position(name) - start)
        room = 1.25 * (own + layout.extent(name, across))
        middle = math.degrees(math.atan2(float(offset @ left), float(offset @ ahead)))
        distance = max(float(np.linalg.norm(offset)), 1e-3)
        half = math.degrees(math.asin(min(room / distance, 0.9)))
        taken.append((middle - half, middle + half))
    signs = (-1.0, 1.0) if task.way() == "right" else (1.0, -1.0)
    free = [s * a for a in range(75) for s in signs if all(not lo < s * a < hi for lo, hi in taken)]
    return float(free[0]) if free else 0.0


def _open_way(task: Task) -> Direction:
    """Away from the camera on a field, else to the side that has more of the picture; what shall
    leave that goes by the nearer side."""
    if task.intent.manner("offscreen"):
        ways: tuple[Direction, ...] = ("left", "right")
        return min(ways, key=lambda way: _way_out(task, way))
    if task.layout.rolls(task.name) or task.intent.has("kick", "throw", "roll"):
        return "away"
    return "right" if task.layout.position(task.name)[0] <= 0 else "left"


def _way_out(task: Task, way: Direction) -> tuple[bool, float]:
    """Whether anything stands in a way out of the picture, and how long that is, m."""
    far, size = free_way(task.layout, task.name, WAYS[way]), task.layout.size(task.name)
    reach = min(far, GROUND.max_out_sizes * size) + way_hidden(task.layout, task.name, WAYS[way])
    return bool(met_across(task.layout, task.name, reach * WAYS[way])), far


def _ground_speed(task: Task, target: Place | None) -> float:
    size = task.layout.size(task.name)
    item = task.layout.state.object(task.name)
    if item is not None and item.body.kind == "granular":
        # A heap is pushed over; faster, and all of its grains fly off together.
        return GROUND.heap_speed_ratio * math.sqrt(mech.G * size)
    friction = task.ground_friction()
    rolls = task.layout.rolls(task.name)
    slowing = mech.rolling_slowing(task.ground_rolling()) if rolls else mech.G * friction
    distance = _distance(task, target)
    if task.speed is not None:
        return task.speed
    if task.passes() is not None:
        distance *= 1.6
    # What is told no end rolls on for the whole clip, and shall still be seen then.
    share = GROUND.arrive_share if target is not None or task.intent.hits else 0.95
    arrive = mech.speed_to_arrive(distance, task.seconds(share), slowing)
    if _is_shoved(task, target):
        # At the end of a push that lasts for the whole way, enough for what it shall do.
        speed = 2 * distance / task.seconds(GROUND.max_push_share)
        return min(max(speed, blow(task.layout, task.intent), 0.05), TASK.max_speed_mps)
    if (task.intent.has("stop", "settle") or task.ends_short) and not rolls:
        return stopping_speed(task, distance, friction)
    speed = min(max(arrive, math.sqrt(2 * slowing * distance) * 1.05, 0.05), TASK.max_speed_mps)
    if task.intent.manner("slow", "gentle"):
        speed = max(min(speed, 0.8), 0.2)
    needed = blow(task.layout, task.intent)
    return max(speed, sent_off(needed, slowing, distance) if needed else 0.0)


def way_to_go(task: Task) -> float:
    """Way along the ground that it shall cover, m."""
    return _distance(task, task.target())


def _turn_to(task: Task, target: Place | None, sign: float) -> float:
    """The flattest arc that leaves alone what stands beside the way."""
    if target is None or target.kind == "support":
        return 24.0
    goal = task.layout.position(place_name(target))
    return free_turn(task.layout, task.name, goal, sign, spared(task, target))


def _curved(
    task: Task, target: Place | None, speed: float, side: float = 0.0, turn: float = 0.0
) -> list[Action]:
    """Starts beside the straight line and is drawn back to it by a force across the path.

    side, turn: which way it bends and by how many degrees, where that is settled.
    """
    distance = (
        task.distance_to(target)
        if target is not None
        else max(5 * task.layout.size(task.name), 1.0)
    )
    circles = any(f.sense == "circle" or f.path == "circle" for f in task.intent.frames)
    said = next(
        (f.direction for f in task.intent.frames if f.direction in ("left", "right")), "left"
    )
    sign = side or (1.0 if said == "left" else -1.0)
    if not turn:
        turn = 200.0 if circles else _turn_to(task, target, sign)
    distance = arc_length(distance, turn) if turn < 180 else distance
    rolling = 1.4 if task.layout.rolls(task.name) else 1.0
    force = task.layout.mass(task.name) * mech.arc_acceleration(speed, distance, turn) * rolling
    steps = int(distance / max(speed, 0.1) / task.clip.step_seconds)
    duration = int(
        np.clip(steps - act.STEPS.push_steps, 10, task.clip.steps - 2 * act.STEPS.push_steps)
    )
    aim = target if target is not None and target.kind != "support" else None
    way = None if aim is not None else ("away" if task.layout.rolls(task.name) else task.way())
    start = act.push(
        task.name,
        act.toward_or_along(
            speed, toward=place_name(aim) if aim else None, way=way or (None if aim else "away"),
            azimuth=-sign * turn / 2 if aim else 0.0,
        ),
    )  # fmt: skip
    return [
        start,
        act.bend(
            task.name,
            force,
            90.0 * sign,
            start=act.STEPS.first_step + act.STEPS.push_steps,
            duration=duration,
        ),
    ]
