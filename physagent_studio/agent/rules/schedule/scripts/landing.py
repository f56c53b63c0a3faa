"""What goes on after a fall, and falling past a thing instead of onto it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.measures import UP, WAYS, FloatArray, level, unit
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.task import TASK, Task
from physagent_studio.agent.rules.schedule.scripts.turns import tip
from physagent_studio.program.actions import Action, Directed, Direction, FixObject
from physagent_studio.program.scene.stairs import profile_of


@dataclass(frozen=True, slots=True)
class LandingSettings:
    """How what stands rocks."""

    rocking_pushes: int = 4  # count, 2..8: to one side and the other in turn
    rocking_steps: int = 10  # 4..20: of each of them
    rocking_share: float = 0.4  # 0.2..0.7: of the angle at which it would fall over
    max_rocking_deg: float = 8.0  # degrees, 5..15: of what is wide; more, and it jumps
    # .4..1: of the speed that an edge takes to that angle: what still rocks adds its own
    pushing_ratio: float = 0.6
    wobbling_share: float = 0.5  # 0.3..0.7: of the clip, after which what wobbles falls over
    shove_share: float = 0.6  # 0.4..0.8: of the clip, for which a hand pushes up a slope
    wafting_mps: float = 0.3  # m/s, 0.1..0.6: of a cloth towards the camera, as it comes loose
    settling_ratio: float = 1.5  # 1..3: of the time up and down, until the next push


LANDING = LandingSettings()
ONWARD = ("roll", "slide", "move", "slip", "bounce", "land", "fall", "leave", "strike")


def waft(task: Task) -> list[Action]:
    """A cloth comes loose with a little air in it: it does not come down like a board, nor stand
    on its edge."""
    force = act.toward_or_along(LANDING.wafting_mps, way="toward_camera")
    held, kick = act.STEPS.hang_steps, act.STEPS.kick_steps
    pushed = act.push(task.name, force, start=held, duration=kick, label="waft")
    return [act.hold(task.name, held), pushed]


def landed_on(task: Task) -> str | None:
    """The thing that it falls onto before it goes on; None where its fall is all."""
    frames = task.intent.frames
    for index, frame in enumerate(frames):
        place = frame.place("on")
        if place is None or frame.sense not in ("fall", "land", "descend"):
            continue
        known = task.layout.has(place.name) and place.name != task.name
        if known and any(later.sense in ONWARD for later in frames[index + 1 :]):
            return place.name
    return None


def off_what_it_fell_on(task: Task) -> list[Action]:
    """Hangs for a moment and falls; once it has landed, a push gets it over the edge of what it
    landed on."""
    other = landed_on(task)
    if other is None:
        return []
    way = WAYS[_way(task)]
    distance = task.layout.extent(other, way) + task.layout.extent(task.name, way)
    force = act.toward_or_along(max(distance / 0.6, 0.5), way=_way(task))
    when = act.on_contact(task.name, other, 10)
    pushed = act.push(task.name, force, duration=15, when=when, label="roll_off")
    return [act.hold(task.name, act.STEPS.hang_steps), pushed]


def _way(task: Task) -> Direction:
    said = task.way()
    return said if said in ("left", "right", "away", "toward_camera") else "right"


def past_what_is_below(task: Task) -> list[Action]:
    """A push sideways that has it beside a thing by the time it is at its height."""
    missed = [
        place.name
        for frame in task.intent.frames
        for relation, place in frame.places
        if task.layout.has(place.name) and (frame.sense == "miss" or relation == "past")
    ]
    if not missed:
        return []
    way = WAYS[_way(task)]
    other = missed[0]
    beside = task.layout.extent(other, way) + task.layout.extent(task.name, way)
    beside -= float((task.layout.position(task.name) - task.layout.position(other)) @ way)
    gap = task.layout.gap(task.name, other)
    seconds = mech.time_to_fall(max(gap if math.isfinite(gap) else 0.5, 0.05))
    force = act.toward_or_along(1.5 * max(beside, 0.05) / seconds, way=_way(task))
    return [act.push(task.name, force, start=0, duration=act.STEPS.kick_steps)]


def let_go(task: Task) -> list[Action]:
    """Held where it was for a moment, then it falls: what carried it has been taken away."""
    held_steps = 24  # 5..60: that a thing stays before what carried it is gone
    return [act.hold(task.name, held_steps)]


def up_ramp(task: Task) -> list[Action]:
    """A push up the slope with speed enough for a good part of its height."""
    ramp = task.ramp_ahead()
    if ramp is None:
        return []
    uphill = np.array([math.cos(ramp.yaw), math.sin(ramp.yaw), 0.0])
    slope = math.atan2(ramp.rise, ramp.run)
    friction = task.layout.friction(task.name, task.layout.carrier(task.name) or "")
    foot = float(task.layout.position(task.name)[2]) - task.layout.extent(task.name, -UP)
    left = max(ramp.rise - max(foot - ramp.toe[2], 0.0), 0.0)
    climb = min(max(0.4 * ramp.rise, 0.5 * task.layout.size(task.name)), max(0.6 * left, 0.02))
    approach = max(float(level(np.array(ramp.toe) - task.layout.position(task.name)) @ uphill), 0.0)
    energy = mech.G * climb * (1 + friction / max(math.tan(slope), 0.05))
    speed = math.sqrt(2 * (energy + mech.G * friction * approach))
    if task.off_the_top() is not None:
        # All the way up, over what is flat behind the edge, and fast enough to get clear of it.
        along = float(level(task.layout.position(task.name) - np.array(ramp.toe)) @ uphill)
        end = max(x for x, _ in profile_of(ramp))
        flat = max(end - max(ramp.run, along), 0.0)
        energy = mech.G * (left + friction * (flat + left / max(math.tan(slope), 0.05)))
        energy += mech.G * task.layout.size(task.name)
        speed = math.sqrt(2 * energy)
    elif task.wheels is not None or not task.layout.rolls(task.name):
        # Its front is at the slope before its middle is.
        there = max(approach - task.layout.extent(task.name, uphill), 0.0)
        return _shoved_up(task, uphill, slope, (there, climb / math.sin(slope)))
    on_it = task.layout.downhill(task.name) is not None
    elevation = math.degrees(slope) if on_it else 0.0
    force = act.toward_or_along(speed, vector=unit(uphill), elevation=elevation)
    return [act.push(task.name, force, label="push")]


def _shoved_up(
    task: Task, uphill: FloatArray, slope: float, ways: tuple[float, float]
) -> list[Action]:
    """A hand goes along with what slides: to the slope, up it, and stays there.

    ways: m, on the ground before the slope, and on the slope.
    """
    approach, climb = ways
    seconds = task.seconds(LANDING.shove_share)
    speed = min((2 * approach + 2 * climb) / seconds, TASK.max_speed_mps)

    def along(magnitude: float, elevation: float) -> Directed:
        return act.toward_or_along(magnitude, vector=unit(uphill), elevation=elevation)

    step, steep = task.clip.step_seconds, math.degrees(slope)
    there = max(round(2 * approach / speed / step), act.STEPS.push_steps)
    up = max(round(climb / speed / step), act.STEPS.push_steps)
    first = act.push(task.name, along(speed, 0.0 if approach else steep), duration=there)
    climbing = act.push(
        task.name, along(speed, steep), start=0, duration=up, when=act.after(first), label="climb"
    )
    slowing = act.push(
        task.name, along(0.0, steep), start=0, duration=act.STEPS.push_steps,
        when=act.after(climbing), label="slow",
    )  # fmt: skip
    stays = FixObject(
        id=f"hold_{task.name}"[:64], name=task.name, start_step=0, duration=task.clip.steps,
        when=act.after(slowing),
    )  # fmt: skip
    return [first, climbing, slowing, stays]


def rock(task: Task) -> list[Action]:
    """A stiff thing is tilted to one side and to the other in turn, and falls back each time."""
    sides: tuple[Direction, Direction] = ("right", "left")
    found: list[Action] = []
    start = task.delay
    for number in range(LANDING.rocking_pushes):
        push, back = _tilted(task, sides[number % 2], start)
        found.append(push)
        start += back
    return found


def rock_over(task: Task) -> list[Action]:
    """Wobbles for less than half of the clip, and only then falls over."""
    rocked, later = rock_first(task)
    over = [a.model_copy(update={"start_step": a.start_step + later}) for a in tip(task)]
    return [*rocked, *over]


def rock_first(task: Task) -> tuple[list[Action], int]:
    """The pushes of a wobble that something follows, and after how many steps that begins."""
    later = round(LANDING.wobbling_share * task.clip.steps)
    rocked = [a for a in rock(task) if a.start_step + LANDING.rocking_steps < later]
    return rocked[: LANDING.rocking_pushes - 1], later


def _tilted(task: Task, side: Direction, start: int) -> tuple[Action, int]:
    """A push at the top that lifts one edge a little, and the steps until it stands again."""
    layout, way = task.layout, WAYS[side]
    height, width = layout.height(task.name), layout.extent(task.name, way)
    corner = math.atan2(2 * width, height)
    angle = min(LANDING.rocking_share * corner, math.radians(LANDING.max_rocking_deg))
    lifted = (math.cos(corner - angle) - math.cos(corner)) / (1 - math.cos(corner))
    speed = LANDING.pushing_ratio * math.sqrt(lifted) * mech.speed_to_topple(height, width) / 2
    # Up and down again about that edge, against its weight.
    slowing = 0.75 * mech.G * math.sin(corner)
    back = LANDING.settling_ratio * 2 * speed / slowing / task.clip.step_seconds
    force = act.toward_or_along(speed, way=side, elevation=math.degrees(corner))
    point = act.rear_top_point(layout, task.name, way)
    steps = LANDING.rocking_steps
    push = act.push(task.name, force, start=start, duration=steps, point=point, label="rock")
    return push, steps + round(back)


def swing(task: Task) -> list[Action]:
    """What hangs swings from a point above it, set going from the side.

    It hangs by its thread where one is seen; else a round thing by a stem as long as itself,
    anything else by its upper end.
    """
    layout = task.layout
    item, reach = layout.state.object(task.name), layout.extent(task.name, UP)
    seen = None if item is None else item.tether
    length = seen or (3 * reach if layout.rolls(task.name) else reach)
    angle = 8.0 if task.intent.manner("gentle", "slow") else 18.0
    angle = 30.0 if task.intent.manner("hard", "fast") else angle
    way = act.toward_or_along(1.0, way=_way(task))
    hits = [name for name in task.intent.hits if layout.has(name)]
    if hits:
        # It reaches beyond what it shall hit, at once or on its way back.
        beyond = 1.5  # 1.1..3: times the way there
        across = min(beyond * layout.gap(task.name, hits[0]) / length, 0.9)
        angle = max(angle, math.degrees(math.asin(max(across, 0.0))))
        way = way if task.way() is not None else act.toward_or_along(1.0, toward=hits[0])
    speed = 2 * math.sqrt(mech.G * length) * math.sin(math.radians(angle) / 2)
    x, y, z = (round(float(part), 4) for part in layout.position(task.name) + length * UP)
    return [
        FixObject(
            id=f"hang_{task.name}"[:64],
            name=task.name,
            start_step=0,
            point=(x, y, z),
            point_frame="world",
            duration=task.clip.steps,
        ),
        act.push(task.name, way.model_copy(update={"magnitude": round(speed, 4)}), label="swing"),
    ]
