"""Off an edge, off a stack."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import seen_way
from physagent_studio.agent.rules.scene.measures import UP, WAYS, FloatArray, level, named_way, unit
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.blows import blow
from physagent_studio.agent.rules.schedule.scripts.flight import seen_up
from physagent_studio.agent.rules.schedule.scripts.task import Task, square_to
from physagent_studio.language import EDGES
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.actions import Action, Directed


@dataclass(frozen=True, slots=True)
class EdgeSettings:
    """How what leaves a table does so."""

    leap_sizes: float = 1.0  # own sizes, 0.3..2: how high what jumps off it goes
    # over √(g · size), 0.1..0.6: speed at the edge of what is shoved all the way there
    shoved_ratio: float = 0.35
    # rad, 0..1.2: from the way told, so far at most that it still goes to that side as it is seen
    turns_rad: tuple[float, ...] = (0.0, 0.35, 0.7, 1.05)
    kept_share: float = 0.08  # 0.05..0.3: of its length, that its middle keeps from the edge
    jut_share: float = 0.3  # 0.15..0.5: of the clip, in which it is pushed, and then slowed
    jut_ratio: float = 1.25  # 1..1.6: of the speed that would do it, as it slips under the hand
    past_sizes: float = 0.15  # own sizes, 0..0.4: how far past the edge it is shoved


EDGE = EdgeSettings()


def off_edge(task: Task) -> list[Action]:
    """Pushed over the edge of what it stands on."""
    way, distance = way_off(task)
    size = task.layout.size(task.name)
    if any(f.partly_off for f in task.intent.frames) and task.wheels is None:
        return _partly_off(task, way, distance)
    if task.intent.has("jump"):
        return [_leap_off(task, way, distance)]
    slowing = mech.G * task.ground_friction()
    if task.layout.rolls(task.name):
        slowing = mech.rolling_slowing(task.ground_rolling())
    needed = math.sqrt(2 * slowing * distance) * 1.25
    speed = max(needed, distance / task.seconds(0.3), math.sqrt(mech.G * size) * 0.6)
    speed = task.speed or max(speed, blow(task.layout, task.intent))
    vector = _aimed(task, way, speed)
    flips = task.intent.has("flip", "topple", "lose_balance")
    point = act.top_point(task.layout, task.name) if flips and not _counts(task) else None
    start = _start_of_row(task)
    if _is_shoved_off(task, speed, needed):
        return [_shoved_off(task, way, distance, start)]
    first = act.push(task.name, vector, start=start, point=point)
    return [first, *_tumble(task, way, distance, speed, start)]


_SENT = words_of(
    "kick throw hit strike knock flip topple lose_balance fly collapse crash fling roll"
)


def _is_shoved_off(task: Task, speed: float, needed: float) -> bool:
    """Whether it slides off under something that goes along, and is not sent off by a blow."""
    item, intent = task.layout.state.object(task.name), task.intent
    rigid = item is not None and item.body.kind == "rigid" and task.wheels is None
    sent = intent.has(*_SENT) or bool(intent.struck_by) or intent.manner("fast", "hard", "flicked")
    led = speed <= needed and not task.layout.rolls(task.name)
    alone = not task.layout.above(task.name) and all(len(f.patient) < 2 for f in intent.frames)
    return rigid and led and alone and not sent and task.speed is None


def _shoved_off(task: Task, way: FloatArray, distance: float, start: int) -> Action:
    """Pushed from rest until it is a little past the edge, no faster than it has to be."""
    size = task.layout.size(task.name)
    whole = distance + EDGE.past_sizes * size
    speed = max(EDGE.shoved_ratio * math.sqrt(mech.G * size), 2 * whole / task.seconds(0.5))
    steps = round(2 * whole / speed / task.clip.step_seconds)
    return act.push(task.name, _aimed(task, way, speed), start=start, duration=steps)


def _partly_off(task: Task, way: FloatArray, distance: float) -> list[Action]:
    """Pushed by a hand that goes along until it juts out, its middle still over what carries it."""
    layout, carrier = task.layout, task.layout.carrier(task.name)
    if carrier is not None and layout.state.object(carrier) is not None:
        # Of a stack: the edge of what is right below it.
        ahead = float((layout.position(carrier) - layout.position(task.name)) @ way)
        distance = max(ahead + layout.extent(carrier, way), 0.0)
    distance = max(distance - EDGE.kept_share * 2 * layout.extent(task.name, way), 0.0)
    half = round(task.seconds(EDGE.jut_share) / task.clip.step_seconds)
    aim = _aimed(task, way, max(EDGE.jut_ratio * distance / task.seconds(EDGE.jut_share), 0.02))
    start = act.push(task.name, aim, start=_start_of_row(task), duration=half)
    slow = aim.model_copy(update={"magnitude": 0.0})
    later = act.after(start)
    return [start, act.push(task.name, slow, start=0, duration=half, when=later, label="slow")]


def _leap_off(task: Task, way: FloatArray, distance: float) -> Action:
    """A leap that comes back to the height of the edge clear of it."""
    layout = task.layout
    upward = math.sqrt(2 * mech.G * seen_up(task, EDGE.leap_sizes * layout.size(task.name)))
    forward = (distance + 1.5 * layout.extent(task.name, -way)) * mech.G / (2 * upward)
    elevation = math.degrees(math.atan2(upward, forward))
    force = act.toward_or_along(math.hypot(upward, forward), vector=way, elevation=elevation)
    return act.push(task.name, force, duration=act.STEPS.kick_steps, label="jump")


def _aimed(task: Task, way: FloatArray, speed: float) -> Directed:
    if task.wheels is None and (onto := task.onto()) is not None:
        return act.toward_or_along(speed, toward=onto)
    if _is_oblique(way):
        return act.toward_or_along(speed, vector=way)
    return act.toward_or_along(speed, way=named_way(way))


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
    away = start + act.STEPS.push_steps + int(distance / max(speed, 0.1) / task.clip.step_seconds)
    axis = np.cross(UP, way)
    steps = min(away, task.clip.steps - 5)
    return [act.spin(task.name, axis, rate, start=steps, duration=3, label="flip")]


def way_off(task: Task) -> tuple[FloatArray, float]:
    """Unit direction and way until its centre is over nothing."""
    layout = task.layout
    said = task.way()
    carrier = layout.carrier(task.name)
    onto_stack = carrier is not None and layout.state.object(carrier) is not None
    if (axis := task.axis_way()) is not None:
        way = axis
    elif (onto := task.onto()) is not None:
        way = task.way_onto(onto)
    elif said in ("left", "right", "away", "toward_camera"):
        way = _off_in_sight(task, WAYS[said])
    elif (edge := _clicked_edge(task) or layout.nearest_edge(task.name)) is not None:
        way = _common_way(task, edge[0])
    else:
        # A stack without an edge near comes down to one side: what goes takes the next along.
        downhill = layout.downhill(task.name)
        way = WAYS["right"] if downhill is None else unit(level(downhill))
    distance = layout.way_to_edge(task.name, way)
    if not math.isfinite(distance) or (onto_stack and not _off_support(task)):
        distance = layout.extent(carrier, way) if onto_stack and carrier else layout.size(task.name)
    return way, distance


def _off_in_sight(task: Task, way: FloatArray) -> FloatArray:
    """The way told, or where its edge lies outside the picture, the next one on its front side
    that leads over an edge that is seen; the way told where none does."""
    layout = task.layout
    if abs(float(way[0])) < 1:
        return way
    for turn in EDGE.turns_rad:
        turned = math.cos(turn) * way + math.sin(turn) * WAYS["toward_camera"]
        if layout.way_to_edge(task.name, turned) <= seen_way(layout, task.name, turned):
            return turned
    return way


def _clicked_edge(task: Task) -> tuple[FloatArray, float] | None:
    """The way straight over the edge that is marked on what carries it, and how far it is."""
    base = task.layout.base(task.name)
    marks = (task.layout.state.landmark(f"{base}_{part}") for part in EDGES)
    mark = next((m for m in marks if m is not None), None)
    inward = None if mark is None else square_to(mark, task.layout.position(base or ""))
    if mark is None or mark.points is None or inward is None:
        return None
    out, start = -inward, np.array(mark.points[0], float)
    distance = float(out @ level(start - task.layout.position(task.name)))
    return out, max(distance, 0.01)


def _common_way(task: Task, way: FloatArray) -> FloatArray:
    return unit(level(way))


def _off_support(task: Task) -> bool:
    """Whether it shall leave the table too, and not only the stack."""
    place = task.intent.place("off", "from")
    return place is not None and place.kind == "support"
