"""Who has to be set going, and to what end: the prompt's frames gathered per object."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from physagent_studio.agent.rules.reading import EventFrame, Place, Reading
from physagent_studio.agent.rules.reading.vocabulary import words_of

ACTIVE = words_of(
    "move slide drift roll fly curve circle push pull kick throw hit knock knock_over tip_over "
    "topple lose_balance flip spin turn turn_around reverse slip float jump rise bounce cross "
    "strike pass reach enter approach accelerate dislodge descend fall stop land leave "
    "lose_support miss end withdrawn wind sway bend crush settle slow collapse spread break deform"
)
"""Senses after which something is no longer as it was."""


@dataclass
class Intent:
    """What one object shall do.

    hits: objects that it shall touch, in order. struck_by: objects that shall touch it.
    """

    name: str
    frames: list[EventFrame] = field(default_factory=list)
    hits: list[str] = field(default_factory=list)
    struck_by: list[str] = field(default_factory=list)

    @property
    def senses(self) -> frozenset[str]:
        """All that is said of it."""
        return frozenset(frame.sense for frame in self.frames)

    def has(self, *senses: str) -> bool:
        """Whether one of the senses is said of it."""
        return bool(self.senses & set(senses))

    def place(self, *relations: str, senses: tuple[str, ...] = ()) -> Place | None:
        """The first place that its frames name in one of these relations."""
        for frame in self.frames:
            if senses and frame.sense not in senses:
                continue
            if (place := frame.place(*relations)) is not None:
                return place
        return None

    def way(self) -> str | None:
        """The first direction that its frames name."""
        known = (None, "off", "down")
        own = [f for f in self.frames if self.name not in f.agent]
        said = [way for f in own for way in (f.direction, f.origin) if way not in known]
        return said[0] if said else None

    def manner(self, *words: str) -> bool:
        """Whether one of the manners is said."""
        return any(frame.manner & set(words) for frame in self.frames)

    @property
    def needs_drive(self) -> bool:
        """Whether it has to move on its own account and not only because it is struck."""
        own = [f for f in self.frames if self.name in f.agent or not f.agent]
        passive = {"topple", "knock_over", "lose_balance", "stay", "rest", "fall", "stack", "be"}
        if self.struck_by:
            return any(f.sense not in passive and f.sense in ACTIVE for f in own if not f.agent)
        return any(f.sense in ACTIVE for f in own)


def intents_of(reading: Reading) -> dict[str, Intent]:
    """The intents of all objects that shall do something, in the order they are told."""
    found: dict[str, Intent] = {}

    def intent(name: str) -> Intent:
        return found.setdefault(name, Intent(name))

    for index, frame in enumerate(reading.frames):
        if prevented(reading, index):
            for name in frame.patient if not frame.negated and not frame.agent else ():
                # "Stops before it reaches the pins": it goes towards them all the same.
                rows = tuple(("before", place) for relation, place in frame.places)
                intent(name).frames.append(replace(frame, sense="stop", places=rows))
            continue
        if frame.negated:
            continue
        if frame.agent:
            _struck(frame, intent)
            continue
        for name in meant(frame):
            intent(name).frames.append(frame)
    return {name: one for name, one in found.items() if one.frames or one.hits}


def meant(frame: EventFrame) -> tuple[str, ...]:
    """The patients that shall do it: where a number is a limit, as many as it takes."""
    return frame.patient[: frame.least] if frame.counted else frame.patient


STOPPING = words_of("stop settle stay rest slow")


def prevented(reading: Reading, index: int) -> bool:
    """ "Stops before it hits the wall": what is told last does not come about."""
    frame = reading.frames[index]
    main = reading.frames[index - 1] if index else None
    return frame.link == "before" and main is not None and main.sense in STOPPING


def _struck(frame: EventFrame, intent) -> None:  # noqa: ANN001 - a local function
    for agent in frame.agent:
        one = intent(agent)
        one.frames.append(frame)
        one.hits += [p for p in meant(frame) if p not in one.hits and p != agent]
    for patient in meant(frame):
        other = intent(patient)
        other.struck_by += [a for a in frame.agent if a != patient]


def moving_frames(intent: Intent) -> list[EventFrame]:
    """Its frames that are no mere description of how things are."""
    return [frame for frame in intent.frames if frame.sense in ACTIVE]
