"""The event program of a reading: who is set going, when, and by which script."""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_studio.agent.rules.contract.intents import Intent, intents_of
from physagent_studio.agent.rules.contract.living import way_into_reach
from physagent_studio.agent.rules.contract.specs import ways_of
from physagent_studio.agent.rules.scene.framing import free_way
from physagent_studio.agent.rules.scene.measures import WAYS, FloatArray, Layout, level, unit
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.choosing import script_for
from physagent_studio.agent.rules.schedule.company import leaders, pushed_alike
from physagent_studio.agent.rules.schedule.scripts import Task
from physagent_studio.language import Reading
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.actions import Action, OnContact, When, duration_of
from physagent_studio.program.program import Clip
from physagent_studio.program.statements import Moves


@dataclass(frozen=True, slots=True)
class ScheduleSettings:
    """How what is told to go on after a blow does so."""

    # cosine, 0.3..0.95: of the way that the blow sends it; what lies farther aside it is led to
    carried_cosine: float = math.cos(math.radians(40.0))
    apart_steps: int = 30  # steps, 5..80: after the blow, in which it is seen what that does


SCHEDULE = ScheduleSettings()
_GOES_ON = ("move", "roll", "slide", "drift")


def schedule(reading: Reading, layout: Layout, clip: Clip) -> tuple[Action, ...]:
    """The event program of a reading over a scene."""
    actions: list[Action] = []
    raised = raised_places(reading, layout)
    for name, place in raised.items():
        # The photo has it standing: it is seen to rise, and does not jump.
        actions += act.raised(name, float((place - layout.position(name))[2]))
    before, layout = layout, layout.with_places(raised)
    actions += [act.hold(name, clip.steps) for name in stays_on_slope(reading, layout)]
    company = leaders(reading, layout)
    for task in (t for t in tasks_of(reading, layout, clip) if t.name not in company):
        wait = steps_to_wait(task.intent, reading, clip)
        wait += act.STEPS.first_step + act.STEPS.rise_steps if task.name in raised else 0
        first = _awaited(task.intent, layout)
        if wait and first is None and _runs_off(layout, task.name):
            # "After a second it rolls down the ramp": not before.
            actions.append(act.hold(task.name, act.STEPS.first_step + wait))
        for action in script_for(task)(task):
            if task.name in raised and _waits_for_touch(action, before):
                continue
            later = act.later(action, wait) if first is None else _once(action, first)
            actions += [a for a in [_fitted(later, clip, actions)] if a is not None]
    return tuple([*actions, *pushed_alike(actions, company, layout)][:500])


def _waits_for_touch(action: Action, layout: Layout) -> bool:
    """Whether it waits for a thing to touch what it touches from the start, in the layout."""
    when = getattr(action, "when", None)
    near_m = 0.005  # m, 0.001..0.02: of two that touch
    if not isinstance(when, OnContact):
        return False
    other = when.b if when.a == action.name else when.a
    return layout.gap(action.name, other) < near_m


def stays_on_slope(reading: Reading, layout: Layout) -> list[str]:
    """What is round or on wheels, is on a slope as the picture shows it, and is told to do
    nothing: it does not roll down while something else happens."""
    told = {
        name
        for frame in reading.frames
        if frame.sense not in ("stay", "rest", "be")
        for name in (*frame.patient, *frame.agent, *(place.name for _, place in frame.places))
    }
    objects = (item.name for item in layout.state.objects)
    return [
        name
        for name in objects
        if name not in told and layout.has(name) and _runs_off(layout, name)
    ]  # fmt: skip


def _runs_off(layout: Layout, name: str) -> bool:
    """Whether it is on a slope and rolls down that by itself."""
    item = layout.state.object(name)
    wheels = item is not None and item.wheels is not None
    return layout.ramp_below(name) is not None and (wheels or layout.rolls(name))


def steps_to_wait(intent: Intent, reading: Reading, clip: Clip) -> int:
    """How much later than the beginning a thing is set going, where the prompt says it: so many
    seconds, or after what is told before it."""
    own = next((f for f in intent.frames if f.sense not in ("be", "stay", "rest")), None)
    if own is None:
        return 0
    if own.delay is not None:
        return min(int(own.delay / clip.step_seconds), clip.steps - 2 * act.STEPS.push_steps)
    index = next((i for i, f in enumerate(reading.frames) if f is own), 0)
    earlier = [f for f in reading.frames[:index] if not f.negated]
    alone = not any(intent.name in (*f.patient, *f.agent) for f in earlier)
    if not alone or intent.struck_by:
        return 0
    following = reading.frames[index + 1 : index + 2]
    turn_steps = 80  # 30..200: that what is told to come next waits for what comes before
    if own.link == "before" or (following and following[0].link == "after"):
        return turn_steps
    if not own.sequel:
        return 0
    before = sum(f.sequel for f in earlier) + 1
    return min(turn_steps * before, clip.steps // 2)


def _sent_after(intent: Intent, layout: Layout) -> str | None:
    """ "First the lemon rolls into the orange, then the orange rolls to the basket": what strikes
    a thing that is told to go another way next than the blow sends it; None for any other."""
    if not intent.struck_by or not layout.has(intent.name):
        return None
    after = [f for f in intent.frames[intent.untouched :] if not f.agent and f.sequel]
    going = next((f for f in after if f.sense in _GOES_ON), None)
    striker = intent.struck_by[0]
    if going is None or not layout.has(striker):
        return None
    aim = going.place("toward", "against", "into", "at")
    here = layout.position(intent.name)
    if aim is not None and layout.has(aim.name):
        ways = [level(layout.position(aim.name) - here)]
    else:
        ways = [WAYS[w] for w in ways_of(going.direction, going, intent.name, layout)]
    sent = unit(level(here - layout.position(striker)))
    along = [float(unit(way) @ sent) for way in ways]
    return striker if along and max(along) < SCHEDULE.carried_cosine else None


def _awaited(intent: Intent, layout: Layout) -> OnContact | When | None:
    """What has to have happened before a thing moves: a blow that sends it another way, or that
    who kicks it has come within reach."""
    if (striker := _sent_after(intent, layout)) is not None:
        return act.on_contact(striker, intent.name, SCHEDULE.apart_steps)
    by = next((f.by for f in intent.frames if f.by and layout.has(f.by)), None)
    if by is None:
        return None
    _, there = way_into_reach(layout, by, intent.name)
    near = Moves(id="within_reach", subject=by, toward=intent.name, distance=there)
    return When(statement=near)


def _once(action: Action, first: OnContact | When) -> Action:
    """The action as long after what it waits for as it would have begun after the beginning."""
    if action.when is not None:
        return action
    when = first.model_copy(update={"delay": first.delay + action.start_step})
    return action.model_copy(update={"start_step": 0, "when": when})


def raised_places(reading: Reading, layout: Layout) -> dict[str, FloatArray]:
    """Where things begin that the prompt has in the air and the picture has standing on it."""
    found: dict[str, FloatArray] = {}
    for index, frame in enumerate(reading.frames):
        under = frame.place("above")
        if frame.sense not in ("hang", "be") or under is None:
            continue
        for name in frame.patient:
            told = any(name in f.patient for f in reading.frames[:index])
            if told or not layout.has(name) or layout.placed(under.name) is None:
                continue
            size = layout.size(name)
            if layout.gap(name, under.name) < 0.06 * size:
                rise = min(max(1.5 * size, 0.1), 0.7 * free_way(layout, name, WAYS["up"]))
                found[name] = layout.position(name) + WAYS["up"] * max(rise, 0.3 * size)
    return found


def tasks_of(reading: Reading, layout: Layout, clip: Clip) -> list[Task]:
    """One task per object that has to be set going, rows of like ones with their ranks."""
    intents = intents_of(reading)
    for frame in (f for f in reading.frames if f.sense == "withdrawn"):
        for intent in (i for i in intents.values() if i.has("lose_support", "fall")):
            intent.frames.insert(0, frame)
    wind = [f for f in reading.frames if f.sense == "wind" and not f.patient]
    if wind:
        for item in layout.state.objects:
            if (
                any(item.name in f.patient for f in reading.frames)
                or len(layout.state.objects) == 1
            ):
                intents.setdefault(item.name, Intent(item.name)).frames[:0] = wind
    driven = [i for i in intents.values() if i.needs_drive or _sent_after(i, layout)]
    driven = [i for i in driven if layout.has(i.name)]
    driven = [i for i in driven if not _comes_down_by_itself(i, driven, layout)]
    return [Task(i, layout, clip, *_rank(i, driven, layout)) for i in driven]


_FALLING = words_of("fall collapse topple slip land lose_support lose_balance descend stay be rest")


def _comes_down_by_itself(intent: Intent, driven: list[Intent], layout: Layout) -> bool:
    """What stands on a thing that is pulled or knocked from under it."""
    if not intent.senses <= _FALLING or intent.hits:
        return False
    pulled = [
        i.name
        for i in driven
        if i.name != intent.name and i.has("pull", "push", "kick", "knock", "move", "hit")
    ]
    return any(intent.name in layout.above(name) for name in pulled)


def _rank(intent: Intent, driven: list[Intent], layout: Layout) -> tuple[int, int]:
    """Place among the objects that share a frame with it, from top to bottom."""
    row = {intent.name, *(n for f in intent.frames for n in (f.agent or f.patient))}
    alike = [i.name for i in driven if i.name in row]
    ordered = sorted(alike, key=lambda n: -layout.position(n)[2])
    return ordered.index(intent.name), len(ordered)


def _fitted(action: Action, clip: Clip, taken: list[Action]) -> Action | None:
    """The action inside the clip, with an id of its own."""
    ids = {a.id for a in taken}
    name, number = action.id, 1
    while name in ids:
        number += 1
        name = f"{action.id[:60]}_{number}"
    update: dict[str, object] = {"id": name}
    if action.when is None:
        if action.start_step >= clip.steps:
            return None
        room = clip.steps - action.start_step
        if duration_of(action) > room:
            update["duration"] = room
    return action.model_copy(update=update)
