"""What a sentence leaves unsaid between two clauses: the blow that brings the second about."""

from dataclasses import replace
from itertools import zip_longest

from physagent_studio.language.frames import EventFrame, Place, Relation

_GOES = ("move", "roll", "slide", "fly", "drift", "leave")
_GIVES_WAY = ("topple", "fall", "tip_over", "collapse", "flip")
_GOES_OVER = ("topple", "tip_over")
_SIDES = ("left", "right")
_TO = ("toward", "into", "against", "at")


def with_blows(frames: list[EventFrame]) -> list[EventFrame]:
    """ "The ball rolls towards the pins and the left one falls over": it hits that one, which
    would stand there otherwise. The same of "into the boxes and the stack tumbles down".

    A thing that is said to go to a single other one is on its way there already; to be added is
    the blow where it only goes in that direction, or where several are spoken of.
    """
    found: list[EventFrame] = []
    frames = _with_the_wind(_off_its_support(_held_up(frames)))
    for frame, after in zip_longest(frames, frames[1:]):
        aim = None if after is None else _aim(frame, after)
        if aim is None or after is None:
            found.append(frame)
            continue
        several = len(after.patient) > 1 and not after.counted
        found.append(replace(frame, places=tuple(row for row in frame.places if row != aim)))
        found.append(
            EventFrame("hit", frame.clause, after.patient, frame.patient, as_one=several,
                       link=frame.link)
        )  # fmt: skip
    return found


def _with_the_wind(frames: list[EventFrame]) -> list[EventFrame]:
    """ "The wind tugs the balloon to the right and the chair topples over": the same way."""
    found: list[EventFrame] = []
    way = None
    for frame in frames:
        by_itself = not (frame.agent or frame.negated or frame.direction or frame.places)
        if frame.sense == "wind" and {frame.direction, frame.origin} & {*_SIDES}:
            # What comes from the left goes to the right, and so its origin is written.
            way = frame.direction or frame.origin
        elif way is not None and by_itself and frame.sense in _GOES_OVER:
            frame = replace(frame, direction=way)
        found.append(frame)
    return found


def _held_up(frames: list[EventFrame]) -> list[EventFrame]:
    """ "Lifts off the table and floats in the air": up there, and not down again."""
    risen: set[str] = set()
    found: list[EventFrame] = []
    for frame in frames:
        level = frame.direction in (None, *_SIDES) and not frame.places
        if frame.sense == "float" and level and risen & set(frame.patient):
            frame = replace(frame, sense="drift" if frame.direction else "hang")
        if frame.sense == "rise" and not frame.negated:
            risen |= set(frame.patient)
        found.append(frame)
    return found


def _off_its_support(frames: list[EventFrame]) -> list[EventFrame]:
    """ "Backs up to the top of the ramp and drops off the back": nothing falls off itself; the
    back is that of the slope which it has got to, over its upper end."""
    found: list[EventFrame] = []
    for frame in frames:
        off = frame.place("off")
        at = [p for f in found if f.patient == frame.patient for _, p in f.places]
        tops = [p for p in at if p.kind == "support" and p.part == "upper_end"]
        if off is not None and off.name in frame.patient and tops:
            rows = tuple((r, tops[-1] if r == "off" else p) for r, p in frame.places)
            frame = replace(frame, places=rows, direction=None)
        found.append(frame)
    return found


def _aim(frame: EventFrame, after: EventFrame) -> tuple[Relation, Place] | None:
    """How and to what a thing goes that what falls next is among; None where no blow is unsaid."""
    told = frame.sense in _GOES and not (frame.agent or frame.negated or frame.any_one)
    own = not (after.agent or after.cause or after.negated or after.places)
    if not (told and own and frame.patient and after.sense in _GIVES_WAY):
        return None
    aim = next((row for row in frame.places if row[0] in _TO), None)
    if aim is None or set(after.patient) & set(frame.patient):
        return None
    relation, place = aim
    meant = {place.name, *place.members} & set(after.patient)
    return aim if meant and (relation == "toward" or after.patient != (place.name,)) else None
