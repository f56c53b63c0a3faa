"""How what goes along the ground comes to a stop where it shall."""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.blows import blow, sent_off
from physagent_studio.agent.rules.schedule.scripts.task import Task
from physagent_studio.program.actions import Action
from physagent_studio.program.base import Position


@dataclass(frozen=True, slots=True)
class StoppingSettings:
    """How what hits something stops."""

    after_blow_sizes: float = 0.4  # own sizes, 0.1..1: that it goes on or back after what it hit
    slid_on_m: float = 0.05  # m, 0.01..0.1: that it would slide on, where it stops at what it hit


STOPPING = StoppingSettings()


def stopping_speed(task: Task, distance: float, friction: float) -> float:
    """Slides to a stop at the place; through a collision on the way, where there is one."""
    slowing = 2 * mech.G * friction
    if not task.intent.hits:
        return max(math.sqrt(slowing * distance), 0.15)
    other = task.intent.hits[0]
    near = task.intent.place("near", "at", "on", "in", senses=("stop", "settle"))
    rest = task.distance_to(near) - distance if near is not None else 0.2
    if task.intent.stops_last and (near is None or near.name == other):
        # What it hits stops it, and the brake that acts then: it only has to get there.
        if task.wheels is not None:
            slowing = 2 * mech.G * task.wheels.rolling
        there = math.sqrt(slowing * (distance + STOPPING.slid_on_m))
        return max(there, sent_off(blow(task.layout, task.intent), slowing / 2, distance))
    after = math.sqrt(slowing * max(abs(rest), 0.05))
    before = mech.speed_before_hit(
        after, task.layout.mass(task.name), task.layout.mass(other),
        task.layout.touch(task.name, other).restitution,
    )  # fmt: skip
    return min(math.sqrt(min(before, 8.0) ** 2 + slowing * distance), 10.0)


def brake(
    task: Task, distance: float, speed: float, start: int, foot: Position | None
) -> list[Action]:
    """A ball rolls far: a brake that stops it where it shall; at what it hits, only there.

    foot: where it is pushed, in its body frame, if a hand shoves it along.
    """
    rolls, hits = task.layout.rolls(task.name), task.intent.hits
    near = task.intent.place("near", senses=("stop",))
    at_it = near is None or near.name in hits
    ends = (task.intent.stops_last and at_it) or _is_driven_against(task)
    if hits and ends and task.layout.has(hits[0]):
        short = STOPPING.after_blow_sizes * task.layout.size(task.name)
        force = act.against(max(speed * speed / (2 * short), 0.2))
        when = act.on_contact(task.name, hits[0])
        steps = task.clip.steps
        return [act.push(task.name, force, start=0, when=when, duration=steps, label="brake")]
    if foot is not None and hits and task.layout.has(hits[0]):
        # The hand that pushes it is still there as they meet: it does not trip over its own feet.
        seconds = 2 * STOPPING.after_blow_sizes * task.layout.size(task.name) / max(speed, 0.1)
        steps = round(min(seconds, task.seconds(0.4)) / task.clip.step_seconds)
        still = act.toward_or_along(0.0, toward=hits[0])
        when = act.on_contact(task.name, hits[0])
        return [act.push(task.name, still, start=0, when=when, duration=max(steps, 1),
                         point=foot, label="slow")]  # fmt: skip
    if not rolls or not (task.intent.has("stop", "settle", "slow") or task.ends_short):
        return []
    slowing = max(speed * speed / max(distance, 0.05), 0.2)
    first = start + int(
        min(0.5 * distance / max(speed, 0.1), task.seconds(0.4)) / task.clip.step_seconds
    )
    duration = max(task.clip.steps - first - 1, 1)
    force = act.against(slowing)
    return [act.push(task.name, force, start=first, duration=duration, label="brake")]


def _is_driven_against(task: Task) -> bool:
    """What is on wheels and hits something last, which it does not push along: who drives brakes
    there."""
    last = task.intent.frames[-1]
    return task.wheels is not None and task.name in last.agent and not task.intent.shoves
