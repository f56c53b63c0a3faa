"""Event programs from mechanics: one small script per way of setting a thing going.

Each script gets a `Task` (the object, what is said of it, the scene) and returns actions. The
numbers come from the reconstructed geometry; what the engine does beyond the formulas is left
to the rounds that follow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules import actions as act
from physagent_studio.agent.rules import mechanics as mech
from physagent_studio.agent.rules.intents import Intent
from physagent_studio.agent.rules.layout import WAYS, FloatArray, Layout, level, named_way, unit
from physagent_studio.agent.rules.reading import Place
from physagent_studio.agent.rules.reading.vocabulary import words_of
from physagent_studio.agent.rules.specs import place_name, ways_of
from physagent_studio.program.actions import Action, Directed, Direction
from physagent_studio.program.program import Clip

UP = WAYS["up"]
FASTEST = 8.0
"""No first program sends a thing along the ground faster than this, m/s."""


@dataclass(frozen=True)
class Task:
    """One object to set going. rank: its place in a row of objects that do the same."""

    intent: Intent
    layout: Layout
    clip: Clip
    rank: int = 0
    of: int = 1

    @property
    def name(self) -> str:
        """The object."""
        return self.intent.name

    @property
    def delay(self) -> int:
        """Steps by which it starts later than the first of its row."""
        return act.FIRST_STEP + self.rank * 25

    def seconds(self, share: float) -> float:
        """A share of the clip, s."""
        return self.clip.seconds * share

    def way(self) -> Direction | None:
        """The named direction that is said, as the scene lies."""
        said = self.intent.way()
        frame = next((f for f in self.intent.frames if said in (f.direction, f.origin)), None)
        if said is None or frame is None:
            return None
        ways = ways_of(said, frame, self.name, self.layout)
        return ways[self.rank % len(ways)] if ways else None

    def target(self) -> Place | None:
        """Where it shall get to: what it hits, enters, crosses, reaches, stops near."""
        if self.intent.hits:
            return Place(self.intent.hits[0], "object")
        for relations in (
            ("in", "into"),
            ("object", "over", "between"),
            ("near", "at"),
            ("toward", "against"),
            ("on",),
        ):
            place = self.intent.place(*relations, senses=_ARRIVING)
            if place is not None and self._is_aim(place):
                return place
        return None

    def _is_aim(self, place: Place) -> bool:
        if place.kind == "group" or place.name == self.name:
            return False
        if place.name == self.layout.carrier(self.name) and not place.part:
            return False
        return self.layout.is_known(place_name(place))

    def distance_to(self, place: Place) -> float:
        """Horizontal way from its centre to the middle of a place."""
        way = self.layout.position(place_name(place)) - self.layout.position(self.name)
        return float(np.linalg.norm(level(way)))

    def ground_friction(self) -> float:
        """Friction with what carries it."""
        carrier = self.layout.carrier(self.name) or self.layout.ground()
        return self.layout.friction(self.name, carrier)


_ARRIVING = tuple(
    words_of(
        "move slide drift roll fly curve push pull kick throw hit cross pass reach enter approach "
        "stop settle land knock knock_over accelerate fall bounce jump crush strike"
    )
)


# --- on level ground ---------------------------------------------------------------------------


def along_ground(task: Task) -> list[Action]:
    """Rolls or slides to where it shall get, fast enough for what it shall do there."""
    target = task.target()
    speed = _ground_speed(task, target)
    if any(
        f.sense in ("curve", "circle") or f.path in ("curve", "circle") for f in task.intent.frames
    ):
        return _curved(task, target, speed)
    force = _aimed(task, target, speed)
    duration = act.PUSH_STEPS
    start: list[Action] = [act.push(task.name, force, start=task.delay, duration=duration)]
    return [*start, *_brake(task, target, speed, duration)]


def _aimed(task: Task, target: Place | None, speed: float, azimuth: float = 0.0) -> Directed:
    way = task.way()
    if target is not None and (way is None or task.intent.hits or target.kind == "landmark"):
        return act.toward_or_along(speed, toward=place_name(target), azimuth=azimuth)
    return act.toward_or_along(speed, way=way or _open_way(task), azimuth=azimuth)


def _open_way(task: Task) -> Direction:
    """Away from the camera on a field, else to the side that has more of the picture."""
    if task.layout.is_ball(task.name) or task.intent.has("kick", "throw", "roll"):
        return "away"
    return "right" if task.layout.position(task.name)[0] <= 0 else "left"


def _ground_speed(task: Task, target: Place | None) -> float:
    size = task.layout.size(task.name)
    item = task.layout.state.object(task.name)
    if item is not None and item.body.kind == "granular":
        # A heap is pushed over; faster, and all of its grains fly off together.
        return math.sqrt(mech.G * size)
    friction = task.ground_friction()
    rolls = task.layout.is_ball(task.name)
    slowing = 0.0 if rolls else mech.G * friction
    distance = task.distance_to(target) if target is not None else max(4 * size, 0.5)
    if task.intent.hits:
        distance = max(distance - size, 0.1)
    arrive = mech.speed_to_arrive(distance, task.seconds(0.45), slowing)
    if task.intent.has("stop", "settle") and not rolls:
        return _stopping_speed(task, distance, friction)
    speed = min(max(arrive, math.sqrt(2 * slowing * distance) * 1.15, 0.3), FASTEST)
    if task.intent.manner("slow", "gentle"):
        speed = max(min(speed, 0.8), 0.2)
    return max(
        speed, *(_knocking_speed(task, hit, slowing, distance) for hit in task.intent.hits), 0
    )


def _knocking_speed(task: Task, other: str, slowing: float, distance: float) -> float:
    """Speed at the start that still knocks the other one over on arrival."""
    layout = task.layout
    if layout.is_ball(other):
        return 0.0
    at = min(layout.extent(task.name, UP) + 0.0, 0.6 * layout.height(other)) or 0.05
    width = layout.extent(other, unit(level(layout.position(other) - layout.position(task.name))))
    knock = mech.speed_to_knock(
        layout.mass(other), layout.height(other), width, layout.mass(task.name),
        layout.restitution(task.name, other), max(at, 0.2 * layout.height(other)),
    )  # fmt: skip
    return min(math.sqrt((1.3 * knock) ** 2 + 2 * slowing * distance), FASTEST)


def _stopping_speed(task: Task, distance: float, friction: float) -> float:
    """Slides to a stop at the place; through a collision on the way, where there is one."""
    slowing = 2 * mech.G * friction
    if not task.intent.hits:
        return max(math.sqrt(slowing * distance), 0.15)
    other = task.intent.hits[0]
    near = task.intent.place("near", "at", "on", "in", senses=("stop", "settle"))
    rest = task.distance_to(near) - distance if near is not None else 0.2
    after = math.sqrt(slowing * max(abs(rest), 0.05))
    before = mech.speed_before_hit(
        after, task.layout.mass(task.name), task.layout.mass(other),
        task.layout.restitution(task.name, other),
    )  # fmt: skip
    return min(math.sqrt(min(before, 8.0) ** 2 + slowing * distance), 10.0)


def _brake(task: Task, target: Place | None, speed: float, start: int) -> list[Action]:
    """A ball rolls on for ever: rolling resistance that stops it where it shall."""
    if not task.intent.has("stop", "settle", "slow") or not task.layout.is_ball(task.name):
        return []
    distance = task.distance_to(target) if target is not None else 1.0
    slowing = max(speed * speed / max(distance, 0.05), 0.2)
    first = start + int(
        min(0.5 * distance / max(speed, 0.1), task.seconds(0.4)) / task.clip.step_seconds
    )
    force = Directed(magnitude=round(slowing, 4), along="against_velocity", quantity="acceleration")
    duration = max(task.clip.steps - first - 1, 1)
    return [act.push(task.name, force, start=first, duration=duration, label="brake")]


def _curved(task: Task, target: Place | None, speed: float) -> list[Action]:
    """Starts beside the straight line and is drawn back to it by a force across the path."""
    distance = (
        task.distance_to(target)
        if target is not None
        else max(5 * task.layout.size(task.name), 1.0)
    )
    circles = any(f.sense == "circle" or f.path == "circle" for f in task.intent.frames)
    turn = 200.0 if circles else 24.0
    side = next(
        (f.direction for f in task.intent.frames if f.direction in ("left", "right")), "left"
    )
    sign = 1.0 if side == "left" else -1.0
    rolling = 1.4 if task.layout.is_ball(task.name) else 1.0
    force = task.layout.mass(task.name) * mech.arc_acceleration(speed, distance, turn) * rolling
    steps = int(distance / max(speed, 0.1) / task.clip.step_seconds)
    duration = int(np.clip(steps - act.PUSH_STEPS, 10, task.clip.steps - 2 * act.PUSH_STEPS))
    aim = target if target is not None and target.kind != "support" else None
    way = None if aim is not None else ("away" if task.layout.is_ball(task.name) else task.way())
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
            task.name, force, 90.0 * sign, start=act.FIRST_STEP + act.PUSH_STEPS, duration=duration
        ),
    ]


# --- through the air ---------------------------------------------------------------------------


def through_air(task: Task) -> list[Action]:
    """Thrown or kicked so that it is at its target after a comfortable flight."""
    target = task.target()
    if target is None:
        speed = 4.0 if not task.intent.manner("gentle", "slow") else 2.0
        force = act.toward_or_along(speed, way=task.way() or "away", elevation=35.0)
        return [act.push(task.name, force, duration=act.KICK_STEPS, label="kick")]
    layout = task.layout
    distance = task.distance_to(target)
    rise = float(layout.position(place_name(target))[2] - layout.position(task.name)[2])
    seconds = float(np.clip(0.35 + 0.06 * distance, 0.4, task.seconds(0.35)))
    speed, elevation = mech.launch(distance, rise, seconds)
    if elevation < 10.0:
        speed, elevation = mech.launch(distance, rise, seconds * 1.4)
    force = act.toward_or_along(speed, toward=place_name(target), elevation=elevation)
    return [act.push(task.name, force, duration=act.KICK_STEPS, label="kick")]


def leap(task: Task) -> list[Action]:
    """Jumps up, and forward where that is said."""
    speed = math.sqrt(2 * mech.G * max(task.layout.size(task.name), 0.1))
    way = task.way()
    elevation = 65.0 if way not in (None, "up") else 0.0
    named = way if way not in (None, "up") else "up"
    force = act.toward_or_along(speed, way=named, elevation=elevation)
    return [act.push(task.name, force, duration=act.KICK_STEPS, label="jump")]


def float_down(task: Task) -> list[Action]:
    """An upward force carries nearly all of the weight."""
    below = task.layout.carrier(task.name)
    ramp = task.layout.ramp_below(task.name)
    drop = task.layout.gap(task.name, ramp.name if ramp else task.layout.ground())
    drop = drop if math.isfinite(drop) and below is None else 0.3
    sink = float(np.clip(2 * max(drop, 0.05) / task.seconds(0.8) ** 2, 0.02, 0.12))
    force = act.toward_or_along(mech.G - sink, way="up", quantity="acceleration")
    return [act.push(task.name, force, start=0, duration=task.clip.steps, label="lift")]


# --- off an edge, off a stack --------------------------------------------------------------------


def off_edge(task: Task) -> list[Action]:
    """Pushed over the edge of what it stands on."""
    way, distance = _way_off(task)
    friction = task.ground_friction()
    size = task.layout.size(task.name)
    needed = math.sqrt(2 * mech.G * friction * distance) * 1.25
    speed = max(needed, distance / task.seconds(0.3), math.sqrt(mech.G * size) * 0.6)
    vector = act.toward_or_along(speed, vector=way) if _is_oblique(way) else act.toward_or_along(
        speed, way=named_way(way)
    )  # fmt: skip
    flips = task.intent.has("flip", "topple", "lose_balance")
    point = act.top_point(task.layout, task.name) if flips and not _counts(task) else None
    start = _start_of_row(task)
    first = act.push(task.name, vector, start=start, point=point)
    return [first, *_tumble(task, way, distance, speed, start)]


def _start_of_row(task: Task) -> int:
    """Of a stack the highest goes first."""
    return task.delay


def _is_oblique(way: FloatArray) -> bool:
    return float(np.max(np.abs(way))) < 0.98


def _counts(task: Task) -> bool:
    return any(f.sense == "flip" and f.count for f in task.intent.frames)


def _tumble(task: Task, way: FloatArray, distance: float, speed: float, start: int) -> list[Action]:
    """A counted flip: spin while it falls."""
    counts = [f.count for f in task.intent.frames if f.sense == "flip" and f.count]
    if not counts:
        return []
    height = float(task.layout.position(task.name)[2] - task.layout.ground_height())
    fall = mech.time_to_fall(height)
    rate = mech.spin_for_flip(360.0 * counts[0] - 180.0, fall)
    away = start + act.PUSH_STEPS + int(distance / max(speed, 0.1) / task.clip.step_seconds)
    axis = np.cross(UP, way)
    steps = min(away, task.clip.steps - 5)
    return [act.spin(task.name, axis, rate, start=steps, duration=3, label="flip")]


def _way_off(task: Task) -> tuple[FloatArray, float]:
    """Unit direction and way until its centre is over nothing."""
    layout = task.layout
    said = task.way()
    carrier = layout.carrier(task.name)
    onto_stack = carrier is not None and layout.state.object(carrier) is not None
    if said in ("left", "right", "away", "toward_camera"):
        way = WAYS[said]
    elif (aim := _aim_beyond(task)) is not None:
        way = aim
    elif (edge := _clicked_edge(task) or layout.nearest_edge(task.name)) is not None:
        way = _common_way(task, edge[0])
    else:
        # On a stack without an edge near: by turns to either side.
        way = WAYS["right" if task.rank % 2 == 0 else "left"]
    distance = layout.way_to_edge(task.name, way)
    if not math.isfinite(distance) or (onto_stack and not _off_support(task)):
        distance = layout.extent(carrier, way) if onto_stack and carrier else layout.size(task.name)
    return way, distance


def _clicked_edge(task: Task) -> tuple[FloatArray, float] | None:
    """The way straight over the edge that is marked on what carries it, and how far it is."""
    base = task.layout.base(task.name)
    mark = task.layout.state.landmark(f"{base}_edge")
    if mark is None or mark.points is None or len(mark.points) < 2:
        return None
    start, end = (np.array(point, float) for point in (mark.points[0], mark.points[-1]))
    along = unit(level(end - start))
    out = np.array([-along[1], along[0], 0.0])
    if float(out @ (start - task.layout.position(base or ""))) < 0:
        out = -out
    distance = float(out @ level(start - task.layout.position(task.name)))
    return out, max(distance, 0.01)


def _common_way(task: Task, way: FloatArray) -> FloatArray:
    return unit(level(way))


def _off_support(task: Task) -> bool:
    """Whether it shall leave the table too, and not only the stack."""
    place = task.intent.place("off", "from")
    return place is not None and place.kind == "support"


def _aim_beyond(task: Task) -> FloatArray | None:
    """The way to something that it shall hit below."""
    if not task.intent.hits:
        return None
    other = task.intent.hits[0]
    return unit(level(task.layout.position(other) - task.layout.position(task.name)))


# --- falling over, turning -----------------------------------------------------------------------


def tip(task: Task) -> list[Action]:
    """A push at the top that brings its centre over its lower edge."""
    layout = task.layout
    way = WAYS[task.way() or ("right" if task.rank % 2 == 0 else "left")]
    if abs(way[2]) > 0.5:
        way = WAYS["right"]
    height = layout.height(task.name)
    width = layout.extent(task.name, way)
    speed = 1.2 * mech.speed_to_topple(height, width) / 2
    force = act.toward_or_along(max(speed, 0.3), way=named_way(way))
    point = act.top_point(layout, task.name)
    return [act.push(task.name, force, start=task.delay, duration=15, point=point, label="tip")]


def spin_about(task: Task) -> list[Action]:
    """Turns about the vertical, or where it lies, about its own middle."""
    turns = next((f.count for f in task.intent.frames if f.count), 1) or 1
    rate = mech.spin_for_flip(360.0 * turns + 30.0, task.seconds(0.5))
    steps = int(task.seconds(0.5) / task.clip.step_seconds)
    sign = -1.0 if task.way() == "right" else 1.0
    return [act.spin(task.name, UP * sign, rate, duration=steps)]


def turn_back(task: Task, trigger: Action | None = None) -> list[Action]:
    """Turns half round, then goes back or another way; after it reached the ground, if it fell."""
    layout = task.layout
    ramp = layout.ramp_below(task.name)
    steps = 45
    when = act.on_contact(task.name, layout.ground(), 5) if ramp is not None else None
    start = act.FIRST_STEP if when is not None else int(0.4 * task.clip.steps)
    turned = act.spin(
        task.name, UP, math.radians(170.0) / (steps * task.clip.step_seconds), start=start,
        duration=steps, when=when, label="turn",
    )  # fmt: skip
    heading = layout.downhill(task.name)
    way = -unit(level(heading)) if heading is not None else -WAYS[task.way() or "away"]
    away = act.toward_or_along(max(0.4, 3 * layout.size(task.name)), vector=way, azimuth=50.0)
    back = act.push(task.name, away, duration=30, when=act.after(turned, 0), label="back")
    return [turned, back]


# --- wind ---------------------------------------------------------------------------------------


def in_wind(task: Task) -> list[Action]:
    """Air that moves: a steady wind in gusts, or one strong gust."""
    way = task.way()
    named = way if way in ("left", "right", "away", "toward_camera") else _open_side(task)
    strong = task.intent.manner("hard", "fast")
    gentle = task.intent.manner("gentle", "slow")
    speed = 14.0 if strong else 4.0 if gentle else 7.0
    rhythm = task.intent.manner("rhythmic", "continuous") or task.intent.has("sway")
    return [
        act.blow(
            task.name, "wind", speed, named, frequency=1.0 if rhythm else 0.6,
            duration=task.clip.steps,
        )
    ]  # fmt: skip


def _open_side(task: Task) -> Direction:
    """Where the wind blows if nobody says: onto the broad side of a sheet, else to the right."""
    item = task.layout.state.object(task.name)
    if item is None or item.body.kind != "cloth":
        return "right"
    wide = task.layout.extent(task.name, WAYS["right"])
    return "away" if wide >= task.layout.extent(task.name, WAYS["away"]) else "right"
