"""What falls where it stands goes over, and off nothing: by what the scene has it stand on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.language import EventFrame, Reading
from physagent_studio.language.tokens.vocabulary import words_of

_OVER = words_of("topple tip_over knock_over lose_balance")
_RESTS = words_of("rest lie land stop settle stay end be")
_STILL = words_of("be stay rest hang stack sway")
_RAISED = words_of("rise jump fly throw kick bounce fall leave slip lose_support withdrawn")
_ELSEWHERE = ("off", "from", "toward", "into", "down", "past")
_ON = ("on", "atop", "in", "at")


def as_going_over(reading: Reading, layout: Layout) -> Reading:
    """ "A gust knocks over the vase; it falls and comes to rest on the desk" that it stands on: the
    fall is the same toppling; the reading with that said."""
    frames = list(reading.frames)
    for index, frame in enumerate(frames):
        if _falls_where_it_stands(frames, index, layout):
            frames[index] = replace(frame, sense="topple")
    return replace(reading, frames=tuple(frames))


def _falls_where_it_stands(frames: Sequence[EventFrame], index: int, layout: Layout) -> bool:
    """Whether a frame tells of a fall off nothing, after it was told to go over, or before it is
    told to lie on what carries it."""
    frame = frames[index]
    if frame.sense != "fall" or frame.negated or frame.agent or len(frame.patient) != 1:
        return False
    name = frame.patient[0]
    carrier = layout.carrier(name) if layout.has(name) else None
    if carrier is None or layout.rolls(name) or not layout.is_raised(name):
        # On the ground it can only fall over in any case.
        return False
    before = [f for f in frames[:index] if name in f.patient and f.sense not in _STILL]
    after = [f for f in frames[index + 1 :] if name in f.patient and not f.negated]
    gone = any(f.sense in _RAISED or f.place(*_ELSEWHERE) for f in before)
    if gone or frame.direction in ("off", "down") or any(_goes_off(f, carrier) for f in after):
        return False
    over = bool(before) and before[-1].sense in _OVER
    lies = any(f.sense in _RESTS and (p := f.place(*_ON)) and p.name == carrier for f in after)
    return not _goes_off(frame, carrier) and (over or lies)


def _goes_off(frame: EventFrame, carrier: str) -> bool:
    """Whether a frame has it get to another place than what carries it, or off that."""
    rows = [(r, p) for r, p in frame.places if r in (*_ELSEWHERE, *_ON)]
    return any(relation in _ELSEWHERE or place.name != carrier for relation, place in rows)
