"""Several hops: on the spot or to a side as often as is told, or to a thing, to end before it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import free_way
from physagent_studio.agent.rules.scene.measures import UP, WAYS, place_name
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.flight import leaps_out
from physagent_studio.agent.rules.schedule.scripts.task import Task
from physagent_studio.language import EventFrame, Place
from physagent_studio.program.actions import Action, Direction


@dataclass(frozen=True, slots=True)
class HoppingSettings:
    """How what gets somewhere by several hops goes."""

    hop_sizes: float = 0.5  # own sizes, 0.2..1.2: how high one of several hops is
    least_hop_m: float = 0.06  # m, 0.02..0.1: the same of small things, so that it is seen
    way_sizes: float = 1.2  # own sizes, 0.5..3: how far one gets, where nobody says how many
    most_hops: int = 8  # count, 3..12: more, and each is over before it is seen
    hold_steps: int = 8  # steps, 4..15: in which it comes to a stand as it lands
    pause_steps: int = 20  # steps, 8..40: on the ground between two; longer, and it has stopped
    before_sizes: float = 0.6  # own sizes, 0.2..1: of the gap at which it ends before a thing
    # degrees, 40..75: how steeply it leaves the ground: flatter, it trips as it comes down
    steep_deg: float = 60.0
    bounce_keeps: float = 0.8  # ratio, 0.6..0.95: of its speed from one bounce to the next
    bounce_steps: int = 6  # steps, 3..9: after which it leaves the ground again
    clip_share: float = 0.6  # 0.5..0.9: of the clip, that all of them take
    room_share: float = 0.8  # 0.4..1: of the way that the picture leaves to a side, to that side


HOPPING = HoppingSettings()


def hops_told(task: Task) -> int:
    """How often it shall leap, where that is more than once; else 0.

    What bounces so many times gently leaps once more, each time a little lower: from the height
    at which it can be seen to, most things would not come up so often by themselves. So does what
    would have to leap out of the picture.
    """
    leaps = (f.count or 0 for f in task.intent.frames if f.sense == "jump")
    most = max(leaps, default=0)
    high = leaps_out(task)
    bounces = (f.count or 0 for f in task.intent.frames if _is_low_bounce(f, high))
    return max(most if most > 1 else 0, *(count + 1 for count in bounces if count), 0)


def _is_low_bounce(frame: EventFrame, leaps_out: bool) -> bool:
    low = leaps_out or bool(frame.manner & {"gentle", "slight"})
    return frame.sense == "bounce" and not frame.places and low


def hop_aim(task: Task) -> Place | None:
    """The thing to which it shall leap and before which it ends; None where it leaps onto it."""
    place = task.intent.place("toward", "at", "near", senses=("jump",))
    known = place is not None and place.kind in ("object", "landmark")
    return place if place and known and task.layout.is_known(place_name(place)) else None


def hop_along(task: Task) -> list[Action]:
    """Hop after hop, each of them taken off from where it stands by then."""
    layout, target, size = task.layout, hop_aim(task), task.layout.size(task.name)
    name, way = None if target is None else place_name(target), _way_to(task, target)
    usual = min(max(math.ceil(way / (HOPPING.way_sizes * size)), 2), HOPPING.most_hops)
    count = hops_told(task) or usual
    side = None if target is not None else _side(task)
    if side is not None:
        room = HOPPING.room_share * free_way(layout, task.name, WAYS[side])
        way = max(min(count * HOPPING.way_sizes * size, room), HOPPING.least_hop_m)
    high = mech.G * max(HOPPING.hop_sizes * size, HOPPING.least_hop_m)
    # What flies 2 u f / g far leaves the ground at a slope of u / f.
    steep = mech.G * way / count * math.tan(math.radians(HOPPING.steep_deg)) / 2
    room = max(free_way(layout, task.name, WAYS["up"]), 0.02)
    longest = task.seconds(HOPPING.clip_share) / count / 2 * mech.G
    upward = min(math.sqrt(max(2 * high, steep)), math.sqrt(2 * mech.G * room), longest)
    flight = 2 * upward / mech.G
    forward, kick = way / count / flight, act.STEPS.kick_steps * task.clip.step_seconds
    speed, elevation = mech.launch(way / count, 0.0, flight, kick)
    aloft = round(flight / task.clip.step_seconds) + act.STEPS.kick_steps
    pause = round(HOPPING.clip_share * task.clip.steps / count) - aloft
    pause = min(max(pause, HOPPING.hold_steps), HOPPING.pause_steps)
    lower = HOPPING.bounce_keeps if task.intent.has("bounce") else 1.0
    found: list[Action] = []
    start = act.STEPS.first_step
    for k in range(count):
        force = (
            act.toward_or_along(speed, toward=name, way=side, elevation=elevation)
            if name is not None or side is not None
            else act.toward_or_along(upward * lower**k, way="up")
        )
        found += [
            act.push(
                task.name, force, start=start, duration=act.STEPS.kick_steps, label=f"hop_{k + 1}"
            ),
            # It comes down on its feet, and holds on to the ground with them.
            *_footing(task, start + aloft, forward, k + 1),
        ]
        start += round((aloft - act.STEPS.kick_steps) * lower**k) + act.STEPS.kick_steps
        start += pause if lower == 1.0 else HOPPING.bounce_steps
    return found


def _side(task: Task) -> Direction | None:
    """The level direction in which it is told to leap; None where it leaps on the spot."""
    told = any(f.direction for f in task.intent.frames if f.sense == "jump")
    way = task.way() if told else None
    return way if way in ("left", "right", "away", "toward_camera") else None


def _way_to(task: Task, target: Place | None) -> float:
    """Level way to where it ends before a thing, m; 0 without one."""
    if target is None:
        return 0.0
    if target.kind != "object":
        return task.distance_to(target)
    before = HOPPING.before_sizes * task.layout.size(task.name)
    return max(task.layout.gap(task.name, target.name) - before, 0.0)


def _footing(task: Task, start: int, forward: float, index: int) -> list[Action]:
    """Stops what comes down: its turning, and its way along the ground."""
    if forward <= 0:
        return []
    brake = act.against(forward / (HOPPING.hold_steps * task.clip.step_seconds))
    hold, name = HOPPING.hold_steps, f"hold_{index}"
    return [
        act.spin(task.name, UP, 0.0, start=start, label=f"land_{index}"),
        act.push(task.name, brake, start=start, duration=hold, label=name),
    ]
