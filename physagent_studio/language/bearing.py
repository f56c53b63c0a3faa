"""What stands on what before anything happens, as a sentence tells it: "slides off the log"."""

from collections.abc import Iterable

from physagent_studio.language.frames import EventFrame, Reading

_LEFT = ("off", "from", "down")
"""What is told to go off something, or down it, stands on it to begin with."""
_THERE = ("on", "atop")
_RESTING = frozenset(("be", "rest", "stay", "sway", "topple"))
"""Senses of which a place tells where a thing is, and not where it goes."""
_REBOUNDS = frozenset(("bounce", "hit"))
"""What comes off a thing that it was never on."""


def stands_on(reading: Reading) -> dict[str, str]:
    """Names of things, each with what the sentence has it stand on at first; each once.

    Not where an earlier word brings it there: "jumps onto the box and off it again".
    """
    found: dict[str, str] = {}
    reached: set[tuple[str, str]] = set()
    for frame in reading.frames:
        for name in frame.patient:
            for below, begins in _told(frame):
                if below == name:
                    continue
                if begins and (name, below) not in reached:
                    found.setdefault(name, below)
                reached.add((name, below))
    return found


def _told(frame: EventFrame) -> Iterable[tuple[str, bool]]:
    """What a frame has things be on, and whether they are there to begin with."""
    for relation, place in frame.begins:
        if relation in _THERE:
            yield place.name, not frame.negated
    for relation, place in frame.places:
        here = relation in _THERE and frame.sense in _RESTING
        left = relation in _LEFT and frame.sense not in _REBOUNDS
        if place.kind in ("object", "support") and (left or relation in _THERE):
            yield place.name, (here or left) and not frame.negated
