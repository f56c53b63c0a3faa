"""What falls where it stands goes over, and off nothing: by what the scene has it stand on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.language import EventFrame, Reading
from physagent_studio.language.tokens.vocabulary import words_of

_OVER = words_of("topple tip_over knock_over lose_balance")
_RESTS = words_of("rest lie land stop settle stay end be")
_GOES_ON = words_of("roll slide move fly drift")
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
    frames = [_felled(frames, index, layout) for index in range(len(frames))]
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


def _felled(frames: Sequence[EventFrame], index: int, layout: Layout) -> EventFrame:
    """ "A gust blows the man off his feet and he falls": it fells him, and does not carry him; what
    else it blows on it does."""
    frame, later = frames[index], frames[index + 1 :]
    if frame.sense != "wind" or frame.negated:
        return frame
    over = [f for f in later if f.sense in (*_OVER, "fall") and not (f.negated or f.agent)]
    over = [f for f in over if all(_can_be_felled(f, n, layout) for n in f.patient)]
    felled = {n: None for f in over for n in f.patient}
    blown = frame.patient or tuple(n for f in later for n in f.patient)
    others = tuple(n for n in dict.fromkeys(blown) if n not in felled)
    # "Blown by the wind, the cup tips over and rolls away": on and on by the wind.
    carried = any(f.sense in _GOES_ON and felled.keys() & {*f.patient} for f in later)
    if carried or not felled or (frame.patient and others):
        return frame
    if others:
        return replace(frame, patient=others)
    way = frame.direction or over[0].direction
    return replace(frame, sense="topple", patient=tuple(felled), direction=way)


def _can_be_felled(frame: EventFrame, name: str, layout: Layout) -> bool:
    """Whether it is stiff and stands there, and goes over as a frame tells, and not down."""
    item, carrier = layout.state.object(name), layout.carrier(name)
    if item is None or item.body.kind != "rigid" or carrier is None or layout.rolls(name):
        return False
    down = frame.sense == "fall" and layout.is_raised(name)
    return not (down or _goes_off(frame, carrier))


def _goes_off(frame: EventFrame, carrier: str) -> bool:
    """Whether a frame has it get to another place than what carries it, or off that."""
    rows = [(r, p) for r, p in frame.places if r in (*_ELSEWHERE, *_ON)]
    return any(relation in _ELSEWHERE or place.name != carrier for relation, place in rows)
