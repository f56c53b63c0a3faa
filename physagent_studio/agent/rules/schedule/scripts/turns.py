"""Falling over and turning."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import free_way
from physagent_studio.agent.rules.scene.measures import UP, WAYS, FloatArray, level, named_way, unit
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.edges import way_off
from physagent_studio.agent.rules.schedule.scripts.ground import along_ground, way_ahead, way_to_go
from physagent_studio.agent.rules.schedule.scripts.task import TASK, Task
from physagent_studio.program.actions import Action, Direction, duration_of


@dataclass(frozen=True, slots=True)
class TurnSettings:
    """How things are brought to fall over."""

    # 0.5..1: of the friction that holds its foot back, up to which a level push tips a thing
    grip_share: float = 0.8
    tip_s: float = 0.25  # s, 0.05..0.5: that a thing is tipped for
    sure_factor: float = 1.05  # 1..1.5: of the push that just suffices
    # 0.1..0.6: over the root of gravity by its reach, of the rate at which a hand tilts a thing
    tilt_ratio: float = 0.25
    tilted_factor: float = 1.05  # 1..1.3: of the angle at which it balances, to which it is tilted
    out_share: float = 0.4  # 0.2..0.45: of the clip, in which a thing gets to where it turns back
    over_share: float = 0.35  # 0.2..0.5: of the clip, after which it lies and is sent on
    on_share: float = 0.4  # 0.2..0.6: of the clip, in which it gets there then
    long_ratio: float = 1.5  # 1.2..3: of a long thing's width to its height
    narrow_ratio: float = 0.7  # 0.3..0.9: of its depth to its width, up to which it is narrow
    # cosine, 0.5..0.95: of its way and the side to which it tips over: its axis lies across
    max_along_cosine: float = math.cos(math.radians(50.0))
    turned_share: float = 1 / 3  # 0..1: of a turn below a ramp, after which it is driven back
    pause_share: float = 0.03  # 0..0.1: of the clip, for which it stands there
    # 0..1: of its first rate, in equal times one after the other, where its spin dies away
    slower_shares: tuple[float, ...] = (1.0, 0.75, 0.5, 0.25)


TURNS = TurnSettings()
_THERE = ("on", "along", "over", "atop")
"""Of what something rolls about on, that tells no way."""


def tip(task: Task, said: Direction | None = None) -> list[Action]:
    """A push at the top that brings its centre over its lower edge.

    said: which way, where that is not the way that is told of it.
    """
    layout = task.layout
    way = WAYS[said or task.way() or _free_way(task)]
    if abs(way[2]) > 0.5:
        way = WAYS["right"]
    onto = task.onto()
    way = way if onto is None else task.way_onto(onto)
    height = layout.height(task.name)
    width = layout.extent(task.name, way)
    wide = width > TURNS.grip_share * task.ground_friction() * height
    if wide and not task.intent.has("flip"):
        return [_tilted(task, way, height, width)]
    named = named_way(way) if onto is None else None
    push = mech.push_to_topple(height, width, TURNS.tip_s)
    point, lift, speed = act.top_point(layout, task.name), 0.0, TURNS.sure_factor * push.speed
    slope = math.atan2(2 * width, height)
    if wide:
        # Pushed along the level it would slide: its rear edge is lifted, square to the lever.
        point, lift = act.rear_top_point(layout, task.name, way), math.degrees(slope)
    else:
        speed *= math.cos(slope)
    force = act.toward_or_along(speed, toward=onto, way=named, elevation=lift)
    steps = max(round(push.seconds / task.clip.step_seconds), 2)
    return [act.push(task.name, force, start=task.delay, duration=steps, point=point, label="tip")]


def _tilted(task: Task, way: FloatArray, height: float, width: float) -> Action:
    """Slowly, as a hand does, to where it balances over its lower edge and a little on: pushed at
    its top it would slide, and thrown over it would turn on."""
    rate = TURNS.tilt_ratio * math.sqrt(mech.G / math.hypot(height / 2, width))
    seconds = TURNS.tilted_factor * math.atan2(width, height / 2) / rate
    steps = math.ceil(seconds / task.clip.step_seconds)
    axis = np.cross(UP, way)
    return act.spin(task.name, axis, rate, start=task.delay, duration=steps, label="tip")


def _free_way(task: Task) -> Direction:
    """The side on which there is most room for all that fall over with it, in the picture and on
    what carries them; elsewhere where something would be knocked down that shall not be. A long
    thing goes over its long side, as a shoe or a train does."""
    layout = task.layout
    meant = {name for frame in task.intent.frames for name in (*frame.patient, *frame.agent)}
    others = [o.name for o in layout.state.objects if o.name not in meant and layout.has(o.name)]
    falling = {n for f in task.intent.frames if task.name in f.patient for n in f.patient}
    row = [name for name in sorted(falling | {task.name}) if layout.has(name)]

    def room(side: Direction) -> float:
        return min(min(free_way(layout, n, WAYS[side]) / layout.height(n), 1.0) for n in row)

    sides: list[Direction] = sorted(("right", "left"), key=room, reverse=True)
    wide, deep = (2 * layout.extent(task.name, WAYS[way]) for way in ("right", "away"))
    long = wide > TURNS.long_ratio * layout.height(task.name) and deep < TURNS.narrow_ratio * wide
    # What is long and narrow goes over its long side; nearer, for its base is never in a picture.
    across: tuple[Direction, ...] = ("toward_camera", "away")
    for side in (*across, *sides) if long else (*sides, *across):
        if not any(_in_the_way(task, other, WAYS[side]) for other in others):
            return side
    return across[0] if long else sides[0]


def _in_the_way(task: Task, other: str, way: FloatArray) -> bool:
    """Whether it would fall onto another thing that stands as low as it does."""
    layout = task.layout
    offset = layout.position(other) - layout.position(task.name)
    across = np.array([-way[1], way[0], 0.0])
    reach = layout.height(task.name) + layout.extent(task.name, way) + layout.extent(other, way)
    width = layout.extent(task.name, across) + layout.extent(other, across)
    beside = 0 < float(offset @ way) < 1.1 * reach and abs(float(offset @ across)) < width
    return beside and layout.carrier(other) == layout.carrier(task.name)


def spin_about(task: Task) -> list[Action]:
    """Turns about the vertical, or where it lies, about its own middle."""
    turns = next((f.count for f in task.intent.frames if f.count), 1) or 1
    said = next((f.angle for f in task.intent.frames if f.angle is not None), None)
    slight = any("slight" in f.manner for f in task.intent.frames)
    half = task.intent.has("turn_around") and not any(f.count for f in task.intent.frames)
    angle = said or (30.0 if slight else 180.0 if half else 360.0 * turns + 30.0)
    rate = mech.spin_for_flip(angle, task.seconds(0.5))
    steps = int(task.seconds(0.5) / task.clip.step_seconds)
    clockwise = any("clockwise" in f.manner for f in task.intent.frames)
    sign = -1.0 if task.way() == "right" or clockwise else 1.0
    if task.intent.has("stop", "settle", "slow"):
        return _spun_out(task, UP * sign, rate, steps)
    return [act.spin(task.name, UP * sign, rate, duration=steps)]


def _spun_out(task: Task, axis: FloatArray, rate: float, steps: int) -> list[Action]:
    """As far as with that rate, slower and slower, to a stand."""
    shares = TURNS.slower_shares
    part, start = steps // len(shares), act.STEPS.first_step
    found: list[Action] = []
    for number, share in enumerate((*shares, 0.0)):
        turning = rate * share * len(shares) / sum(shares)
        label = "stop" if not share else f"spin_{number}" if number else "spin"
        duration = part if share else act.STEPS.hang_steps
        found.append(
            act.spin(task.name, axis, turning, start=start, duration=duration, label=label)
        )
        start += duration
    return found


def there_and_back(task: Task) -> list[Action]:
    """Goes one way, stands for a moment, and comes back along it: each time faster for half of its
    time and slower for the other half, as what drives or is led."""
    seconds, rolls = task.seconds(TURNS.out_share), task.layout.rolls(task.name)
    speed = task.speed or min(2 * way_to_go(task) / seconds, TASK.max_speed_mps)
    half = round(seconds / 2 / task.clip.step_seconds)
    foot = None if rolls or task.wheels else act.foot_point(task.layout, task.name)
    ahead, found, wait = way_ahead(task), [], 0
    for way, label in ((ahead, ""), (-ahead, "back")):
        for share in (1.0, 0.0):
            aim = act.toward_or_along(max(speed, 0.05), vector=way)
            aim = aim.model_copy(update={"magnitude": share * aim.magnitude})
            when = act.after(found[-1], wait) if found else None
            name = label or "push" if share else f"slow_{label}".rstrip("_")
            found.append(
                act.push(
                    task.name, aim, start=0 if found else task.delay, duration=half, point=foot,
                    when=when, label=name,
                )
            )  # fmt: skip
            wait = 0 if share or label else round(TURNS.pause_share * task.clip.steps)
    return found


def turn_back(task: Task) -> list[Action]:
    """Turns half round, then goes back or another way; after it reached the ground, if it fell."""
    layout = task.layout
    ramp = layout.ramp_below(task.name)
    if ramp is None and not task.intent.has("turn_around"):
        return there_and_back(task)
    steps = 45
    when = act.on_contact(task.name, layout.ground(), 5) if ramp is not None else None
    start = act.STEPS.first_step if when is not None else int(0.4 * task.clip.steps)
    turned = act.spin(
        task.name, UP, math.radians(170.0) / (steps * task.clip.step_seconds), start=start,
        duration=steps, when=when, label="turn",
    )  # fmt: skip
    heading = layout.downhill(task.name)
    way = -unit(level(heading)) if heading is not None else -WAYS[task.way() or "away"]
    away = act.toward_or_along(max(0.4, 3 * layout.size(task.name)), vector=way, azimuth=30.0)
    later = act.after(turned, 0)
    if ramp is not None:
        # What it has from the ramp takes it on until then, out of the picture where that is long.
        turning = round(TURNS.turned_share * steps)
        later = act.on_contact(task.name, layout.ground(), 5 + turning)
    back = act.push(task.name, away, duration=30, when=later, label="back")
    return [turned, back]


def spin_over(task: Task) -> list[Action]:
    """Spins, and only then falls over."""
    spun = spin_about(task)
    later = max(action.start_step + duration_of(action) for action in spun)
    return spun + [a.model_copy(update={"start_step": a.start_step + later}) for a in tip(task)]


def go_over(task: Task) -> list[Action]:
    """Goes along the ground, and when it is slow again falls over to the side, where it is thin.

    Who pushes it lets go after a quarter of the clip, and it falls in the middle of it.
    """
    push, *rest = along_ground(task)
    most = round(task.seconds(0.25) / task.clip.step_seconds)
    push = push.model_copy(update={"duration": min(duration_of(push), most)})
    later = round(task.seconds(0.5) / task.clip.step_seconds)
    sides: tuple[Direction, ...] = ("toward_camera", "away", "right", "left")
    thin = min(sides, key=lambda side: task.layout.extent(task.name, WAYS[side]))
    over = [a.model_copy(update={"start_step": later}) for a in tip(task, thin)]
    return [push, *rest, *over]


def over_and_on(task: Task) -> list[Action]:
    """Tips over, and rolls on when it lies: to where it shall get, or across the side to which it
    is told to fall, where nothing tells which way it rolls."""
    ahead, distance, fallen = way_ahead(task), way_to_go(task), _falls_to(task)
    rolls = [f for f in task.intent.frames if f.sense == "roll"]
    aimed = any(where not in _THERE for f in rolls for where, _ in f.places)
    if fallen is not None and not aimed and not any(f.direction for f in rolls):
        ways = {e: free_way(task.layout, task.name, WAYS[e]) for e in _across(fallen)}
        end = max(_across(fallen), key=lambda e: ways[e])
        ahead, distance = WAYS[end], min(distance, ways[end])
    return _over_then(task, ahead, distance)


def _across(fallen: Direction) -> tuple[Direction, ...]:
    """Ways in which something rolls that has fallen to that side."""
    return ("toward_camera", "away") if fallen in ("left", "right") else ("right", "left")


def over_and_off(task: Task) -> list[Action]:
    """Tips over, and rolls off what it stands on: where it is said to which side it falls, over
    the edge to which it rolls then."""
    ahead, distance = way_off(task)
    fallen = _falls_to(task)
    if fallen is not None and abs(float(WAYS[fallen] @ ahead)) > TURNS.max_along_cosine:
        # Of an edge that is not seen nobody sees that it rolls off.
        ends: list[Direction] = [e for e in _across(fallen) if e != "away"]
        end = min(ends, key=lambda e: task.layout.way_to_edge(task.name, WAYS[e]))
        ahead, distance = WAYS[end], task.layout.way_to_edge(task.name, WAYS[end])
    return _over_then(task, ahead, distance)


def _falls_to(task: Task) -> Direction | None:
    """The side to which it is told to fall, before it rolls."""
    over = (f for f in task.intent.frames if f.sense in ("topple", "tip_over", "lose_balance"))
    said = next((f.direction for f in over if f.direction), None)
    return said if said in ("left", "right", "away", "toward_camera") else None


def _over_then(task: Task, ahead: FloatArray, distance: float) -> list[Action]:
    """Tips over across a level way (3,), and is sent that far along it, m, when it lies."""
    layout, target = task.layout, task.target()
    sides: tuple[Direction, ...] = ("toward_camera", "away", "left", "right")
    across: list[Direction] = [
        side for side in sides if abs(float(WAYS[side] @ ahead)) < TURNS.max_along_cosine
    ]
    height = layout.height(task.name)
    free = max(across, key=lambda s: min(free_way(layout, task.name, WAYS[s]) / height, 1.0))
    fallen = _falls_to(task)
    onto = target.name if target is not None and target.kind == "object" else None
    speed = task.speed or distance / task.seconds(TURNS.on_share)
    roll = act.push(
        task.name, act.toward_or_along(max(speed, 0.1), toward=onto, vector=ahead),
        start=round(task.seconds(TURNS.over_share) / task.clip.step_seconds), label="roll",
    )  # fmt: skip
    return [*tip(task, fallen if fallen in across else free), roll]


def spin_along(task: Task) -> list[Action]:
    """Spins upright all along its way, as a top does."""
    spun = [a.model_copy(update={"duration": 2 * duration_of(a)}) for a in spin_about(task)]
    return [*spun, *along_ground(task)]
