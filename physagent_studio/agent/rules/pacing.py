"""How fast things may be seen to go, by the verbs of the sentence and the sizes of the things."""

from __future__ import annotations

from physagent_studio.agent.rules.intents import Intent, intents_of
from physagent_studio.agent.rules.layout import Layout
from physagent_studio.agent.rules.reading import EventFrame, Reading
from physagent_studio.knowledge import pace_of
from physagent_studio.program.contract import Speeds

FALLS = ("fall", "land", "slip", "leave", "lose_support", "lose_balance", "fly", "bounce", "jump")
"""Senses after which gravity or a flight decides how fast a thing goes."""


def paces_of(reading: Reading, layout: Layout) -> tuple[Speeds, ...]:
    """A range for each thing that is set going on level ground."""
    found = (_pace(intent, layout) for intent in intents_of(reading).values())
    return tuple(pace for pace in found if pace is not None)[:64]


def _pace(intent: Intent, layout: Layout) -> Speeds | None:
    name = intent.name
    own = [f for f in intent.frames if (name in f.patient and not f.agent) or name in f.agent]
    if not layout.has(name) or intent.struck_by or intent.has(*FALLS):
        return None
    if layout.downhill(name) is not None or layout.carrier(name) is None:
        return None
    ranges = [row for frame in own if (row := _range(frame, layout.size(name))) is not None]
    if not ranges:
        return None
    low, high, verb = max(ranges, key=lambda row: row[1])
    return Speeds(subject=name, verb=verb.replace("_", " "), low=low, high=high)


def _range(frame: EventFrame, size: float) -> tuple[float, float, str] | None:
    """Lowest and highest speed, m/s, of the verb for a thing of that size, m."""
    if frame.speed is not None:
        return 0.5 * frame.speed, 1.5 * frame.speed, frame.sense
    pace = pace_of(frame.sense)
    if pace is None or pace.plain.metres.high <= 0:
        return None
    said = pace.plain
    if frame.manner & {"slow", "gentle"}:
        said = pace.slow
    elif frame.manner & {"fast", "hard"}:
        said = pace.fast
    high = min(said.metres.high, max(said.lengths.high * size, said.metres.low))
    return min(said.metres.low, said.lengths.low * size), round(high, 3), frame.sense
