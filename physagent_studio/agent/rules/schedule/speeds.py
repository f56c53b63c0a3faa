"""How fast a verb has a thing of a certain size go."""

from __future__ import annotations

from physagent_studio.knowledge import pace_of
from physagent_studio.language import EventFrame


def speed_range(frame: EventFrame, size: float) -> tuple[float, float, str] | None:
    """Lowest and highest speed, m/s, of a frame's verb for a thing of that size, m, and the verb;
    None for what has no speed of its own. What is large goes as many of its lengths a second as
    is usual, however many metres these are: a car is not held to the pace of a toy.
    """
    if frame.speed is not None:
        return 0.5 * frame.speed, 1.5 * frame.speed, frame.sense
    pace = pace_of(frame.gait or frame.sense)
    if pace is None or pace.plain.metres.high <= 0:
        return None
    said = pace.plain
    if frame.manner & {"slow", "gentle"}:
        said = pace.slow
    elif frame.manner & {"fast", "hard"}:
        said = pace.fast
    most = max(said.metres.high, said.lengths.usual * size)
    high = min(most, max(said.lengths.high * size, said.metres.low))
    return min(said.metres.low, said.lengths.low * size), round(high, 3), frame.gait or frame.sense
