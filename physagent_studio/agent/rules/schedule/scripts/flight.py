"""Through the air: throws, leaps, slow sinking, and wind."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import free_way, good_way
from physagent_studio.agent.rules.scene.measures import WAYS, FloatArray, level, place_name, unit
from physagent_studio.agent.rules.scene.steps import descents
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.task import Task
from physagent_studio.language import Place
from physagent_studio.program.actions import Action, Directed, Direction
from physagent_studio.program.scene.bodies import FLUTTER, Cloth
from physagent_studio.program.scene.materials import density_of
from physagent_studio.program.scene.plants import FOLIAGE, sway_frequency
from physagent_studio.program.scene.state import SceneObject, Slab


@dataclass(frozen=True, slots=True)
class FlightSettings:
    """How high what leaps or is lifted goes, however little room the picture leaves above it."""

    min_rise_sizes: float = 0.25  # own sizes, 0.1..1: lower, and it is hardly seen to rise
    min_rise_m: float = 0.03  # m, 0.01..0.1: likewise, for what is small
    seen_hop_m_s: float = 0.7  # m/s, 0.3..1.5: after the last of several hops: it is seen
    gentle_hop_sizes: float = 0.6  # own sizes, 0.3..1: how high what bounces gently goes
    step_hop_sizes: float = 0.6  # own sizes, 0.3..1.5: how high it hops to a lower step
    # 1..1.6: of the time of a flight that comes down at 45 degrees, for a leap onto a thing
    steep_leap_ratio: float = 1.3
    # 0.5..1: of the way that is to be gone by hops: while it is kicked it is carried on
    hop_way_share: float = 0.9
    bounced_share: float = 0.6  # 0.4..0.8: of the clip, after which it goes on, if not before
    # own sizes, 0.3..2: from a thing, of what flies off above it and comes down beside it
    beside_sizes: float = 0.8
    last_hop_m_s: float = 0.55  # m/s, 0.2..1: the same of what has to get somewhere by its hops


FLIGHT = FlightSettings()


def through_air(task: Task) -> list[Action]:
    """Thrown or kicked so that it is at its target after a comfortable flight."""
    hurdle = task.intent.place("over", senses=("throw", "kick", "fly"))
    if hurdle is not None and hurdle.kind == "object" and task.layout.has(hurdle.name):
        return [_over(task, hurdle.name)]
    target = task.target()
    if target is None:
        return [_off_somewhere(task)]
    layout = task.layout
    distance = task.distance_to(target)
    rise = float(layout.position(place_name(target))[2] - layout.position(task.name)[2])
    support = layout.state.support(target.name)
    if support is not None and isinstance(support.shape, Slab) and not target.part:
        # Onto its top.
        rise += (support.shape.size[2] + layout.height(task.name)) / 2
    if target.kind == "object" and task.intent.has("land", "jump", "fall"):
        # Onto its top, and not against its side.
        rise += (layout.height(target.name) + layout.height(task.name)) / 2
    beside = _beside(task, target)
    if beside is not None:
        distance, rise = float(np.hypot(beside[0], beside[1])), float(beside[2])
    if (hops := _hops(task)) > 1:
        distance, rise = distance / hops, 0.0
    seconds = float(np.clip(0.35 + 0.06 * distance, 0.4, task.seconds(0.35)))
    if target.kind == "object" and task.intent.has("jump") and rise > 0:
        # Down onto it, and not along it: what comes flat pushes it away or slides on over it.
        steep = FLIGHT.steep_leap_ratio * math.sqrt(2 * (distance + rise) / mech.G)
        seconds = max(seconds, min(steep, _longest_leap(task, rise)))
    kick = act.STEPS.kick_steps * task.clip.step_seconds
    speed, elevation = mech.launch(distance, rise, seconds, kick)
    if elevation < 10.0:
        speed, elevation = mech.launch(distance, rise, seconds * 1.4, kick)
    if beside is None:
        force = act.toward_or_along(speed, toward=place_name(target), elevation=elevation)
    else:
        force = act.toward_or_along(speed, vector=unit(level(beside)), elevation=elevation)
    return [act.push(task.name, force, duration=act.STEPS.kick_steps, label="kick")]


def _beside(task: Task, target: Place) -> FloatArray | None:
    """Way (3,), m, of what flies off over a thing to the ground beside it, on the side that is
    said; None for what does not begin above the thing, or shall not get beside it."""
    layout, near = task.layout, task.intent.place("near")
    if near is None or near.name != target.name or not layout.has(target.name):
        return None
    way = WAYS[side if (side := task.way()) in ("left", "right", "toward_camera") else "right"]
    off = layout.position(target.name) - layout.position(task.name)
    half = layout.extent(target.name, way) + layout.extent(task.name, way)
    if float(np.hypot(off[0], off[1])) > half or off[2] > 0:
        return None
    aside = half + FLIGHT.beside_sizes * layout.size(task.name)
    foot = layout.ground_height() + layout.height(task.name) / 2
    return level(off) + aside * way + WAYS["up"] * (foot - layout.position(task.name)[2])


def _longest_leap(task: Task, rise: float) -> float:
    """Seconds of a leap to a place that lies `rise` m higher that the picture shows to its top."""
    room = free_way(task.layout, task.name, WAYS["up"])
    if room <= rise:
        return 0.0
    upward = math.sqrt(2 * mech.G * min(room, rise + 3 * task.layout.height(task.name)))
    return (upward + math.sqrt(upward**2 - 2 * mech.G * rise)) / mech.G


def _off_somewhere(task: Task) -> Action:
    """A kick that way which is said, to come down where it is still seen."""
    speed, elevation = (4.0 if not task.intent.manner("gentle", "slow") else 2.0), 35.0
    if any(frame.posture == "airborne" for frame in task.intent.frames):
        elevation = 60.0
    way = task.way() or "away"
    room = good_way(task.layout, task.name, WAYS[way])
    if way == "up":
        elevation = 0.0
    elif math.isfinite(room):
        speed = min(speed, math.sqrt(mech.G * room / math.sin(2 * math.radians(elevation))))
    force = act.toward_or_along(speed, way=way, elevation=elevation)
    return act.push(task.name, force, duration=act.STEPS.kick_steps, label="kick")


def leap(task: Task) -> list[Action]:
    """Jumps up, and forward where that is said; over a thing, as high and as far as that takes."""
    hurdle = task.intent.place("over", senses=("jump", "bounce"))
    if hurdle is not None and hurdle.kind == "object" and task.layout.has(hurdle.name):
        return [_over(task, hurdle.name)]
    speed = _hop_speed(task, FLIGHT.seen_hop_m_s)
    if (down := task.down_the_steps()) is not None:
        return [_down_a_step(task, down)]
    way = task.way()
    elevation = 65.0 if way not in (None, "up") else 0.0
    named = way if way not in (None, "up") else "up"
    force = act.toward_or_along(speed, way=named, elevation=elevation)
    return [act.push(task.name, force, duration=act.STEPS.kick_steps, label="jump")]


def _down_a_step(task: Task, down: FloatArray) -> Action:
    """A hop that comes down in the middle of a lower step."""
    lower = descents(task.layout, task.name)[: task.steps][-1]
    upward = math.sqrt(
        2 * mech.G * seen_up(task, FLIGHT.step_hop_sizes * task.layout.size(task.name))
    )
    seconds = (upward + math.sqrt(upward**2 + 2 * mech.G * lower)) / mech.G
    forward = float(np.linalg.norm(down)) / seconds
    force = act.toward_or_along(
        math.hypot(upward, forward), vector=unit(down),
        elevation=math.degrees(math.atan2(upward, forward)),
    )  # fmt: skip
    return act.push(task.name, force, duration=act.STEPS.kick_steps, label="jump")


def _hop_speed(task: Task, last: float) -> float:
    """How fast it leaves the ground, m/s. last: what is left after as many rebounds as are told."""
    gentle = task.intent.manner("gentle", "slight")
    high = (FLIGHT.gentle_hop_sizes if gentle else 1.0) * max(task.layout.size(task.name), 0.1)
    speed = math.sqrt(2 * mech.G * seen_up(task, high))
    hops = _hops(task)
    return min(max(speed, last / _kept(task) ** hops), 7.0) if hops > 1 else speed


def leaps_out(task: Task) -> bool:
    """Whether one leap after which it comes up as often as is told would leave the picture."""
    high = _hop_speed(task, FLIGHT.seen_hop_m_s) ** 2 / (2 * mech.G)
    return _hops(task) > 1 and high > free_way(task.layout, task.name, WAYS["up"])


def _kept(task: Task) -> float:
    """The share of its speed that a rebound from the ground leaves it."""
    return max(task.layout.touch(task.name, task.layout.ground()).restitution, 0.2)


def bounced_steps(task: Task, leaps: list[Action]) -> int:
    """After how many steps what leaps on the spot has come down as often as is told, and once
    more, for the last time that it is seen to come up."""
    last = leaps[-1]
    force = getattr(last, "force", None)
    if not isinstance(force, Directed):
        return 0
    times = max(_hops(task), 1) if len(leaps) == 1 else 1
    flights = sum(_kept(task) ** k for k in range(times + (len(leaps) == 1)))
    steps = round(2 * force.magnitude / mech.G * flights / task.clip.step_seconds)
    return min(last.start_step + steps, round(FLIGHT.bounced_share * task.clip.steps))


def hop_onto(task: Task) -> list[Action]:
    """Hops along the ground, as often as that is told, and then reaches what it shall hit."""
    upward, target = _hop_speed(task, FLIGHT.last_hop_m_s), task.intent.hits[0]
    # Where it first comes down it begins to roll, which takes two sevenths of a ball's speed.
    kept, hops, rolling = _kept(task), max(_hops(task), 1), 5 / 7
    flights = 1 + rolling * (sum(kept**k for k in range(1, hops)) + kept**hops / 2)
    way = FLIGHT.hop_way_share * task.layout.gap(task.name, target)
    forward = way * mech.G / (2 * upward * flights)
    elevation = math.degrees(math.atan2(upward, forward))
    force = act.toward_or_along(math.hypot(upward, forward), toward=target, elevation=elevation)
    return [act.push(task.name, force, duration=act.STEPS.kick_steps, label="jump")]


def seen_up(task: Task, height: float) -> float:
    """How high it goes, m: less than a wanted height where its top would leave the picture."""
    free = free_way(task.layout, task.name, WAYS["up"])
    least = max(FLIGHT.min_rise_sizes * task.layout.size(task.name), FLIGHT.min_rise_m)
    return max(min(height, free), least)


def _hops(task: Task) -> int:
    """How often it shall bounce, where that is said; else 0."""
    return max((f.count or 0 for f in task.intent.frames if f.sense == "bounce"), default=0)


def _over(task: Task, hurdle: str) -> Action:
    """A leap over a thing, that comes down where it shall; else as far behind it as it began
    before."""
    layout = task.layout
    away = layout.position(hurdle) - layout.position(task.name)
    distance = float(np.hypot(away[0], away[1]))
    way = np.array([away[0], away[1], 0.0]) / max(distance, 1e-6)
    lowest = layout.position(task.name)[2] - layout.height(task.name) / 2
    top = layout.position(hurdle)[2] + layout.height(hurdle) / 2
    half = layout.extent(hurdle, way) + layout.extent(task.name, way)
    clearance = max(float(top - lowest), 0.0) + 0.5 * layout.height(task.name)
    whole = _beyond(task, way, distance, half)
    # Before and behind the thing it must be clear of it: on an arc of that height at its middle.
    sides = (max(distance - half, 0.1 * distance), min(distance + half, whole - 0.1 * distance))
    summit = max(clearance * whole**2 / (4 * x * (whole - x)) for x in sides)
    upward = math.sqrt(2 * mech.G * summit)
    forward = whole / 2 * mech.G / upward
    force = act.toward_or_along(
        math.hypot(upward, forward),
        toward=hurdle,
        elevation=math.degrees(math.atan2(upward, forward)),
    )
    return act.push(task.name, force, duration=act.STEPS.kick_steps, label="jump")


def _beyond(task: Task, way: FloatArray, distance: float, half: float) -> float:
    """How far a leap over a thing goes along a level way (3,), m: to where it shall get beyond it.

    distance: to the thing; half: its own half and the thing's, along the way.
    """
    aim = task.target()
    if aim is None or not task.layout.is_known(place_name(aim)):
        return 2 * distance
    to = task.layout.position(place_name(aim)) - task.layout.position(task.name)
    on = float(to @ way)
    return max(on, distance + 1.5 * half) if on > distance else 2 * distance


def lift(task: Task) -> list[Action]:
    """Carried up without haste; then let go where it comes down again, else held there.

    What does nothing else rises faster and faster to the end, as far as the picture allows: what
    hangs still in the end was not told to.
    """
    height = seen_up(task, max(1.2 * task.layout.size(task.name), 0.12))
    seconds = task.seconds(0.25)
    first = act.STEPS.first_step
    if all(frame.sense == "rise" and frame.distance is None for frame in task.intent.frames):
        height = max(min(good_way(task.layout, task.name, WAYS["up"]), 4 * height), height)
        steps = task.clip.steps - first
        gain = 2 * height / (steps * task.clip.step_seconds) ** 2
        force = act.toward_or_along(mech.G + gain, way="up", quantity="acceleration")
        return [act.push(task.name, force, start=first, duration=steps, label="lift")]
    # Half of the time it gains speed, half of the time it loses it.
    gain = 4 * height / (seconds * seconds)
    half = round(seconds / 2 / task.clip.step_seconds)
    up, slow, hold = (
        act.toward_or_along(mech.G + share, way="up", quantity="acceleration")
        for share in (gain, -gain, 0.0)
    )
    actions: list[Action] = [
        act.push(task.name, up, start=first, duration=half, label="lift"),
        act.push(task.name, slow, start=first + half, duration=half, label="slow"),
    ]
    if not task.intent.has("fall", "land"):
        rest = task.clip.steps - first - 2 * half
        actions.append(
            act.push(task.name, hold, start=first + 2 * half, duration=rest, label="hold")
        )
    return actions


@dataclass(frozen=True, slots=True)
class FloatingSettings:
    """How what floats comes down."""

    min_sink_mps2: float = 0.02  # m/s², 0.005..0.05: slower, and it is not seen to sink
    # m/s², 0.05..0.3: for all of the clip; it ends at half a metre a second
    max_sink_mps2: float = 0.12
    start_share: float = 0.15  # 0.05..0.4: of the clip, until what comes from high up sinks evenly


FLOATING = FloatingSettings()


def float_down(task: Task) -> list[Action]:
    """An upward force carries nearly all of the weight."""
    below = task.layout.carrier(task.name)
    ramp = task.layout.ramp_below(task.name)
    drop = task.layout.gap(task.name, ramp.name if ramp else task.layout.ground())
    drop = drop if math.isfinite(drop) and below is None else 0.3
    sink = float(2 * max(drop, 0.05) / task.seconds(0.8) ** 2)
    # Without its weight it would rise again from where it lands.
    weight = act.toward_or_along(mech.G, way="down", quantity="acceleration")
    landed = act.on_contact(task.name, ramp.name if ramp else task.layout.ground())
    settled = act.push(
        task.name, weight, start=0, when=landed, duration=task.clip.steps, label="settle"
    )
    rest = [settled] if below is None else []
    if sink <= FLOATING.max_sink_mps2:
        force = act.toward_or_along(
            mech.G - max(sink, FLOATING.min_sink_mps2), way="up", quantity="acceleration"
        )
        return [act.push(task.name, force, start=0, duration=task.clip.steps, label="lift"), *rest]
    # From high up it would end too fast: it soon sinks evenly.
    first = task.seconds(FLOATING.start_share)
    sink = drop / (task.seconds(0.8) - first / 2) / first
    steps = round(first / task.clip.step_seconds)
    slow = act.toward_or_along(mech.G - sink, way="up", quantity="acceleration")
    even = act.toward_or_along(mech.G, way="up", quantity="acceleration")
    left = round(task.seconds(0.8) / task.clip.step_seconds) - steps
    return [
        act.push(task.name, slow, start=0, duration=steps, label="lift"),
        act.push(task.name, even, start=steps, duration=left, label="lift_on"),
        *rest,
    ]


def in_wind(task: Task) -> list[Action]:
    """Air that moves: a steady wind in gusts, or one strong gust."""
    way = task.way()
    named = way if way in ("left", "right", "away", "toward_camera") else _open_side(task)
    strong = task.intent.manner("hard", "fast")
    gentle = task.intent.manner("gentle", "slow")
    speed = 14.0 if strong else 4.0 if gentle else 7.0
    item = task.layout.state.object(task.name)
    if item is not None and item.material == FOLIAGE:
        # Beaufort 4, 5 and 8: thin branches move, small trees sway, twigs break off trees.
        speed = 20.0 if strong else 6.0 if gentle else 10.0
    if item is not None and isinstance(item.body, Cloth):
        speed = _lifting_wind(item, item.body, 60.0 if strong else 20.0 if gentle else 40.0)
    if not gentle and not task.intent.has("sway", "bend"):
        speed = max(speed, _carrying_wind(task, named))
    rhythm = task.intent.manner("rhythmic", "continuous") or task.intent.has("sway")
    # What only gives way comes to rest in a steady wind; gusts keep it going.
    gives = item is not None and item.body.kind in ("soft", "cloth", "rope")
    frequency = (1.0 if rhythm else 0.6) if gives else None
    if item is not None and item.material == FOLIAGE:
        # Of the gusts that blow a plant answers to those that come as often as it sways.
        frequency = round(min(max(sway_frequency(task.layout.height(task.name)), 0.5), 1.5), 2)
    return [
        act.blow(task.name, "wind", speed, named, frequency=frequency, duration=task.clip.steps)
    ]


def _lifting_wind(item: SceneObject, body: Cloth, angle: float) -> float:
    """Wind that holds a hanging sheet at an angle, degrees, from upright: drag = weight · tan.

    It meets the broad side of what hangs from above, and blows along what is held at a side.
    """
    weight = density_of(item) * body.thickness * mech.G
    share = FLUTTER if body.pinned in ("left", "right") else 1.0
    drag = weight * math.tan(math.radians(angle))
    return min(max(math.sqrt(2 * drag / (1.2 * share)), 0.5), 20.0)


def _carrying_wind(task: Task, way: Direction) -> float:
    """Wind that moves what stands free: its drag is more than the friction, m/s; 0 if rooted."""
    item, layout = task.layout.state.object(task.name), task.layout
    if item is None or item.body.kind != "rigid" or layout.carrier(task.name) is None:
        return 0.0
    across = WAYS["away" if way in ("left", "right") else "right"]
    area = 2 * layout.extent(task.name, across) * layout.height(task.name)
    rolls = layout.rolls(task.name)
    grip = task.ground_rolling() * 2 if rolls else task.ground_friction()
    force = grip * layout.mass(task.name) * mech.G
    return min(1.4 * math.sqrt(2 * force / (1.2 * max(area, 1e-4))), 60.0)


def _open_side(task: Task) -> Direction:
    """Where the wind blows if nobody says: onto the broad side of a sheet, else to the right."""
    item = task.layout.state.object(task.name)
    if item is None or not isinstance(item.body, Cloth):
        return "right"
    if item.body.pinned in ("left", "right"):
        # Along a sheet that is held at a side, away from there.
        return "right" if item.body.pinned == "left" else "left"
    wide = task.layout.extent(task.name, WAYS["right"])
    return "away" if wide >= task.layout.extent(task.name, WAYS["away"]) else "right"
