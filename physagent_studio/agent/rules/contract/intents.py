"""Who has to be set going, and to what end: the prompt's frames gathered per object."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.knowledge import is_container
from physagent_studio.language import EventFrame, Place, Reading
from physagent_studio.language.tokens.vocabulary import words_of

ACTIVE = words_of(
    "set_down move slide drift roll fly curve circle push pull kick throw hit knock knock_over "
    "tip_over topple lose_balance flip spin turn turn_around reverse slip float jump rise bounce "
    "cross strike pass reach enter approach accelerate dislodge descend fall stop land leave "
    "lose_support miss end withdrawn wind sway bend crush settle slow collapse spread break deform"
)
"""Senses after which something is no longer as it was."""


@dataclass
class Intent:
    """What one object shall do.

    hits: objects that it shall touch, in order. fells, shoves: those of them that shall fall over
    for it, and that shall slide or roll on. strikes: what those that it hits shall do. struck_by:
    objects that shall touch it; untouched: how many of its frames are told before that.
    """

    name: str
    frames: list[EventFrame] = field(default_factory=list)
    hits: list[str] = field(default_factory=list)
    fells: list[str] = field(default_factory=list)
    shoves: list[str] = field(default_factory=list)
    strikes: list[Intent] = field(default_factory=list, compare=False, repr=False)
    struck_by: list[str] = field(default_factory=list)
    untouched: int = 0

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
    def stops_last(self) -> bool:
        """Whether it is told to stop after it hits something, and not before."""
        told = [f.sense for f in self.frames]
        return bool(self.hits) and len(told) > 1 and told[-1] in ("stop", "settle")

    @property
    def together(self) -> tuple[str, ...]:
        """Several things that it shall run into at once."""
        struck = (f.patient for f in self.frames if self.name in f.agent)
        into = (p.members for f in self.frames for r, p in f.places if r in ("into", "against"))
        return next((all_ for all_ in (*struck, *into) if len(all_) > 1), ())

    @property
    def needs_drive(self) -> bool:
        """Whether it has to move on its own account and not only because it is struck."""
        own = [f for f in self.frames if self.name in f.agent or not f.agent]
        if self.struck_by:
            return any(f.sense in ACTIVE for f in own if not f.agent and not self._explained(f))
        return any(f.sense in ACTIVE for f in own)

    def _explained(self, frame: EventFrame) -> bool:
        """Whether that it is struck is reason enough for what is said of it."""
        told_after = not any(frame is other for other in self.frames[: self.untouched])
        after = told_after and frame.sense in (*_CARRIED_ON, *_YIELDING, *_COMES_TO_REST)
        return frame.sense in _GIVING_WAY or after


_GIVING_WAY = words_of("topple knock_over lose_balance stay rest fall stack be")
_CARRIED_ON = words_of("slide move roll drift slip tip_over collapse break spread deform dislodge")
_COMES_TO_REST = words_of("stop settle slow end")
_YIELDING = words_of("sway bend deform crush")
"""What a blow explains: always, where it is told after the blow, and of what gives way."""


def intents_of(reading: Reading) -> dict[str, Intent]:
    """The intents of all objects that shall do something, in the order they are told."""
    found: dict[str, Intent] = {}

    def intent(name: str) -> Intent:
        return found.setdefault(name, Intent(name))

    for index, frame in enumerate(reading.frames):
        if prevented(reading, index):
            for name in frame.patient if not frame.negated and not frame.agent else ():
                # "Stops before it reaches the pins": it goes towards them all the same.
                # What it would fall off is no place to stop before.
                ahead = (place for relation, place in frame.places if relation not in _BEHIND)
                rows = tuple(("before", place) for place in ahead)
                intent(name).frames.append(replace(frame, sense="stop", places=rows))
            continue
        if frame.negated:
            continue
        if frame.agent:
            _struck(frame, intent)
            continue
        for name in meant(frame):
            intent(name).frames.append(frame)
            for other in met(frame):
                _hit(frame, name, other, intent)
    for frame in reading.frames:
        struck = [n for n in frame.patient if n in found and found[n].struck_by]
        if struck and not frame.agent and frame.sense in (*_GIVING_WAY, "collapse"):
            # "The ball hits the first one, and three of them fall": by one another. What strikes
            # them and falls as well is not set going by that.
            for name in (n for n in frame.patient if n in found and n not in struck):
                if not found[name].hits:
                    found[name].struck_by += struck
    _fallen_on(reading, found)
    for one in found.values():
        one.strikes = [found[other] for other in one.hits]
        own = {f.sense for f in one.frames if one.name in f.agent}
        for other in one.hits:
            after = {f.sense for f in found[other].frames[found[other].untouched :]}
            if (own | after) & _FALLS_OVER:
                one.fells.append(other)
            elif after & _CARRIED_ON or "push" in own:
                one.shoves.append(other)
    return {name: one for name, one in found.items() if one.frames or one.hits}


def _fallen_on(reading: Reading, found: dict[str, Intent]) -> None:
    """ "The plum falls on the jelly, and the jelly wobbles": by the plum."""
    for frame in reading.frames:
        if frame.negated or frame.agent or frame.sense not in ("fall", "land", "descend"):
            continue
        below = [found.get(place.name) for relation, place in frame.places if relation == "on"]
        for one in below:
            if one is not None and not one.struck_by and one.has(*_YIELDING):
                one.struck_by += [name for name in frame.patient if name != one.name]


_FALLS_OVER = words_of(
    "knock_over tip_over topple fall flip collapse lose_balance knock crush break"
)


def meant(frame: EventFrame) -> tuple[str, ...]:
    """The patients that shall do it: where a number is a limit, as many as it takes."""
    if frame.any_one and frame.patient:
        # Whichever it is: one of them, and "the other" the next.
        return frame.patient[1:2] if frame.rest else frame.patient[:1]
    return frame.patient[: frame.least] if frame.counted else frame.patient


_BEHIND = ("off", "from")
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
        if not other.struck_by:
            other.untouched = 0 if told_later(frame) else len(other.frames)
        other.struck_by += [a for a in frame.agent if a != patient]


_MEETING = words_of("move roll slide drift accelerate slip fly push kick throw bounce")


def met(frame: EventFrame) -> tuple[str, ...]:
    """ "Rolls into the box", "bounces off the crate": what it runs into, where that is no vessel
    that it could get into."""
    if frame.sense not in _MEETING or frame.agent or frame.negated:
        return ()
    relations = ("off", "against") if frame.sense == "bounce" else ("into", "against")
    rows = [(r, p) for r, p in frame.places if r in relations and not p.part]
    met_with = [p for r, p in rows if r != "into" or not is_container(p.name)]
    things = [p.name for p in met_with if p.kind == "object"]
    members = [name for p in met_with if p.kind == "group" for name in p.members]
    return tuple(name for name in (*things, *members) if name not in frame.patient)


def _hit(frame: EventFrame, name: str, other: str, intent) -> None:  # noqa: ANN001 - a local function
    one, struck = intent(name), intent(other)
    one.hits += [other] if other not in one.hits else []
    if not struck.struck_by:
        struck.untouched = 0 if told_later(frame) else len(struck.frames)
    struck.struck_by.append(name)


def told_later(frame: EventFrame) -> bool:
    """ "The tower collapses when the truck hits it": the cause is told after what it does."""
    return frame.link in ("as", "after", "because", "since", "once") and not frame.leads


def moving_frames(intent: Intent) -> list[EventFrame]:
    """Its frames that are no mere description of how things are."""
    return [frame for frame in intent.frames if frame.sense in ACTIVE]


def brought_above(layout: Layout, name: str, frame: EventFrame) -> bool:
    """ "Is dropped onto the book", "falls into the cup", of what stands no higher than that and
    cannot fall over onto it: it is brought above it, and falls from there."""
    place = frame.place("on", "in", "into")
    if frame.sense not in ("fall", "land") or place is None or place.kind != "object":
        return False
    if not layout.has(place.name) or place.name == name:
        return False
    reach = layout.gap(name, place.name) < layout.height(name)
    leans = reach and not layout.rolls(name)
    lowest = layout.position(name)[2] - layout.height(name) / 2
    top = layout.position(place.name)[2] + layout.height(place.name) / 2
    return bool(lowest < top) and not leans


def carries_the_others(layout: Layout, name: str, frame: EventFrame) -> bool:
    """Whether it stands on no thing itself, and others that come down with it stand on it, or, of a
    stack as a whole, on one another: it need not fall."""
    others = [other for other in frame.patient if other != name]
    on_things = layout.state.object(layout.carrier(name) or "") is not None
    below = frame.patient if frame.as_one else (name,)
    return not on_things and any(layout.carrier(other) in below for other in others)


def struck_above(reading: Reading, layout: Layout) -> Reading:
    """ "The stack is pushed and collapses": what carries the others stays where it is, and those on
    it are pushed off; the reading with that said."""
    frames = list(reading.frames)
    for index, (frame, after) in enumerate(pairwise(reading.frames)):
        comes_down = after.sense == "collapse" and not after.negated
        if comes_down and frame.sense in _STRIKES and set(after.patient) == set(frame.patient):
            above = [n for n in frame.patient if not carries_the_others(layout, n, after)]
            frames[index] = replace(frame, patient=tuple(above) or frame.patient)
    return replace(reading, frames=tuple(frames))


_STRIKES = ("push", "knock", "strike", "tip_over", "knock_over")
