"""One leg after the other along the ground, each in its part of the clip."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from physagent_studio.agent.rules.contract.intents import Intent
from physagent_studio.agent.rules.scene.framing import good_way
from physagent_studio.agent.rules.scene.measures import OPPOSITE, WAYS, FloatArray, are_opposite
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule import scripts
from physagent_studio.agent.rules.schedule.scripts import Task
from physagent_studio.agent.rules.schedule.told_order import GROUND
from physagent_studio.language import EventFrame
from physagent_studio.program.actions import Action, After
from physagent_studio.program.program import Clip


def ways_in_turn(task: Task) -> list[EventFrame]:
    """The frames of "slides to the left, then to the right", where nothing else is told of it."""
    told = [f for f in task.intent.frames if not f.negated and f.sense != "stop"]
    plain = all(f.sense in GROUND and f.direction in OPPOSITE and not f.places for f in told)
    alone = not task.intent.hits and not task.intent.struck_by and task.wheels is None
    if len(told) < 2 or not plain or not alone:
        return []
    turns = all(are_opposite(a.direction, b.direction) for a, b in pairwise(told))
    return told if turns and task.layout.ramp_below(task.name) is None else []


def one_way_then_another(task: Task) -> list[Action]:
    """As many legs as are told, each in its part of the clip and to a stand at its end."""
    legs = ways_in_turn(task)
    wait = task.clip.steps // len(legs)
    found: list[Action] = []
    far = 0.0
    for k, leg in enumerate(legs):
        room = good_way(task.layout, task.name, _along(leg)) / len(legs)
        # The way back is as free as the way there was.
        far = max(room, far)
        told = leg if leg.distance is not None else replace(leg, distance=far)
        halts = Intent(task.name, [told, EventFrame("stop", "")])
        there = scripts.along_ground(replace(task, intent=halts, clip=shorter(task.clip, wait)))
        found += [act.later(_of_leg(a, f"leg_{k + 1}"), k * wait) for a in there]
    return found


def _along(leg: EventFrame) -> FloatArray:
    return next(vector for way, vector in WAYS.items() if way == leg.direction)


def _of_leg(action: Action, leg: str) -> Action:
    """The action under a name of its own, and so whatever it waits for."""
    when = action.when
    if isinstance(when, After):
        when = when.model_copy(update={"action": f"{leg}_{when.action}"[:64]})
    return action.model_copy(update={"id": f"{leg}_{action.id}"[:64], "when": when})


def shorter(clip: Clip, steps: int) -> Clip:
    """A clip of so many steps, in whole frames."""
    return clip.model_copy(update={"frames": max(steps // clip.steps_per_frame, 2)})
