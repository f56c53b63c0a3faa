"""What a sentence leaves unsaid between two clauses: the blow that brings the second about."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from physagent_studio.language.frames import EventFrame

_GOES = ("move", "roll", "slide", "fly", "drift", "leave")
_GIVES_WAY = ("topple", "fall", "tip_over", "collapse", "flip")
_TO = ("toward", "into", "against", "at")


def with_blows(frames: list[EventFrame]) -> list[EventFrame]:
    """ "The ball rolls towards the pins and the left one falls over": it hits that one, which
    would stand there otherwise. The same of "into the boxes and the stack tumbles down".

    A thing that is said to go to a single other one is on its way there already; to be added is
    the blow where it only goes in that direction, or where several are spoken of.
    """
    found = list(frames)
    for frame, after in pairwise(frames):
        told = frame.sense in _GOES and not (frame.agent or frame.negated or frame.any_one)
        own = not (after.agent or after.cause or after.negated or after.places)
        if not (told and own and frame.patient and after.sense in _GIVES_WAY):
            continue
        aim = next(((r, p) for r, p in frame.places if r in _TO), None)
        if aim is None or set(after.patient) & set(frame.patient):
            continue
        relation, place = aim
        meant = place.kind == "group" or place.name in after.patient
        if not meant or (relation != "toward" and after.patient == (place.name,)):
            continue
        several = len(after.patient) > 1 and not after.counted
        blow = EventFrame(
            clause=frame.clause, sense="hit", agent=frame.patient, patient=after.patient,
            as_one=several, link=frame.link,
        )  # fmt: skip
        kept = tuple(row for row in frame.places if row != aim)
        found[found.index(frame)] = replace(frame, places=kept)
        found.insert(found.index(after), blow)
    return found
