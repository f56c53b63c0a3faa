"""How fast things may be seen to go, by the verbs of the sentence and the sizes of the things."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from physagent_studio.agent.rules.contract.intents import Intent, intents_of
from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.schedule.scripts.blows import blow, sent_off
from physagent_studio.agent.rules.schedule.scripts.task import Task
from physagent_studio.agent.rules.schedule.speeds import speed_range
from physagent_studio.contract.view.footing import ALONG_THE_GROUND
from physagent_studio.language import Reading
from physagent_studio.program.contract import Speeds

FALLS = ("fall", "land", "slip", "leave", "lose_support", "lose_balance", "fly", "bounce", "jump")
"""Senses after which gravity or a flight decides how fast a thing goes."""


def paces_of(
    reading: Reading, layout: Layout, needed: Mapping[str, float] = MappingProxyType({})
) -> tuple[Speeds, ...]:
    """A range for each thing that is set going on level ground.

    needed: m/s that it takes to get where the sentence has it get within the clip, by name.
    """
    found = (
        _pace(intent, layout, needed.get(intent.name, 0.0))
        for intent in intents_of(reading).values()
    )
    return tuple(pace for pace in found if pace is not None)[:64]


def _pace(intent: Intent, layout: Layout, needed: float) -> Speeds | None:
    name = intent.name
    own = [f for f in intent.frames if (name in f.patient and not f.agent) or name in f.agent]
    if not layout.has(name) or intent.struck_by or intent.has(*FALLS):
        return None
    if layout.downhill(name) is not None or layout.carrier(name) is None:
        return None
    # "Slides slowly until it touches the cup" meets it as slowly.
    own = [f for f in own if f.manner & {"slow", "gentle"}] or own
    ranges = [row for frame in own if (row := speed_range(frame, layout.size(name))) is not None]
    if not ranges:
        return None
    low, high, verb = max(ranges, key=lambda row: row[1])
    # "Is pushed until it hits the table" goes as it stands, as fast as what hits may.
    verb = next((sense for _, _, sense in ranges if sense in ALONG_THE_GROUND), verb)
    # Where it is told how far, it may go as fast as that takes.
    high = max(high, round(1.5 * needed, 3))
    return Speeds(subject=name, verb=verb.replace("_", " "), low=low, high=high)


def speed_to_get_there(task: Task) -> float:
    """m/s with which a thing sets out that is where it shall be after half of the clip, and fast
    enough there for what comes of the blow."""
    target = task.target()
    if target is None:
        return 0.0
    layout = task.layout
    rolls = layout.rolls(task.name)
    slowing = mech.rolling_slowing(task.ground_rolling()) if rolls else 0.0
    distance = task.distance_to(target)
    arrives = mech.speed_to_arrive(distance, task.seconds(0.5), slowing)
    struck = blow(layout, task.intent)
    return max(arrives, sent_off(struck, slowing, distance) if struck else 0.0)
