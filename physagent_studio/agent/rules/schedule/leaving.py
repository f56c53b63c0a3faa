"""What drives, runs or rolls off or away, from nothing that is said: it leaves the picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

from physagent_studio.agent.rules.scene.framing import free_way, way_hidden
from physagent_studio.agent.rules.scene.measures import WAYS, FloatArray, Layout
from physagent_studio.agent.rules.schedule.scripts.carrying import met_across
from physagent_studio.agent.rules.schedule.speeds import speed_range
from physagent_studio.language import EventFrame, Reading
from physagent_studio.language.tokens.vocabulary import words_of

_BY_ITSELF = words_of("roll fly slide")
_GOES_NOWHERE = words_of("be stay rest stop settle stack hang turn_around spin")

_WAYS_OUT = ("left", "right", "away", "toward_camera")


@dataclass(frozen=True, slots=True)
class LeavingSettings:
    """What goes off can be seen to be gone."""

    # 0.3..0.9: of the clip, for which it goes as fast as its verb allows: what walks through all of
    # the picture is not out of it before the clip ends
    time_share: float = 0.6


LEAVING = LeavingSettings()


def off_the_picture(reading: Reading, layout: Layout, seconds: float) -> Reading:
    """ "The car drives off to the left", on the ground: out of the picture, where that is the last
    that is told of it and there is time for it; the reading with that said. seconds: of the clip.
    """
    frames = tuple(
        replace(frame, manner=frame.manner | {"offscreen"}, places=())
        if _goes_off(frame)
        and _is_all(reading, index)
        and all(_gets_out(frame, name, layout, seconds) for name in frame.patient)
        else frame
        for index, frame in enumerate(reading.frames)
    )
    return replace(reading, frames=frames)


def _goes_off(frame: EventFrame) -> bool:
    """Whether it goes "off" or "away" by itself, and not off a thing, to one or after one."""
    free = not (frame.agent or frame.negated or frame.counted or frame.any_one)
    off = [(relation, place.kind) for relation, place in frame.places] == [("off", "group")]
    off |= "away" in frame.manner and not frame.places
    return free and off and (bool(frame.gait) or frame.sense in _BY_ITSELF)


def _is_all(reading: Reading, index: int) -> bool:
    """Whether nothing else is told of it after this; nor before, of what does not go by itself:
    what was struck, or landed on a thing, rolls off that."""
    frame, later = reading.frames[index], reading.frames[index + 1 :]
    earlier = () if frame.gait else reading.frames[:index]
    others = (*later, *(f for f in earlier if f.sense not in _GOES_NOWHERE))
    return not any(
        {*frame.patient} & {*f.patient, *f.agent, *(p.name for _, p in f.places)} for f in others
    )


def _gets_out(frame: EventFrame, name: str, layout: Layout, seconds: float) -> bool:
    """Whether it stands on the ground, nothing stands in the way that is said, and its verb is fast
    enough for the way out."""
    if not layout.has(name) or layout.carrier(name) != layout.ground():
        return False
    said = {frame.direction} if frame.direction in _WAYS_OUT else {"left", "right"}
    ways = [vector for way, vector in WAYS.items() if way in said]
    far = [(_way_out(layout, name, way), way) for way in ways]
    free = [length for length, way in far if not met_across(layout, name, length * way)]
    pace = speed_range(frame, layout.size(name))
    if not free or pace is None:
        return False
    return min(free) < pace[1] * LEAVING.time_share * seconds


def _way_out(layout: Layout, name: str, way: FloatArray) -> float:
    return free_way(layout, name, way) + way_hidden(layout, name, way)
