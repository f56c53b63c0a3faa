"""Senses of coming to rest, staying and being somewhere."""

from __future__ import annotations

import math

from physagent_studio.agent.rules.contract.senses.common import posture, quality, rolls, still
from physagent_studio.agent.rules.contract.sequence import OVER
from physagent_studio.agent.rules.contract.specs import SPEC, Context, Spec, spec, ways_of
from physagent_studio.agent.rules.scene.measures import are_opposite, level, place_name, unit
from physagent_studio.language import EDGES, EventFrame, Place
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.actions import Direction
from physagent_studio.program.scene.state import Ramp, Support


def stop(c: Context) -> list[Spec]:
    """Moves and then is at rest, near or on what is named.

    What goes on afterwards is not at rest at the end. That it was for a moment is told by its going
    the opposite way from there, and by nothing else.
    """
    if on := [f for f in c.later if _goes_on(f) and not _kept_from(f)]:
        ways = [_way_of(c, f) for f in (*c.earlier[-1:], on[0])]
        turns = on[0].sense == "reverse" or are_opposite(ways[0], ways[-1])
        return [spec("reverses", c.subject, angle=135.0)] if turns else []
    return [*_stopped(c), *_not_over_the_edge(c)]


def _not_over_the_edge(c: Context) -> list[Spec]:
    """ "Slides to the edge and stops": still on what it stood on."""
    carrier = c.layout.carrier(c.subject)
    named = [p for f in (*c.earlier, c.frame) for r, p in f.places if r not in _BEFORE]
    at_edge = any(p.part in EDGES and p.name == c.layout.base(c.subject) for p in named)
    gone = any(f.sense in _GONE for f in (*c.earlier, *c.later) if not _kept_from(f))
    if carrier is None or not at_edge or gone or not c.layout.is_raised(c.subject):
        return []
    found = [spec("rests_on", c.subject, other=carrier)]
    if any(_kept_from(f) for f in c.later):
        # "Stops just before it falls off", "nearly falls off": with its side at the edge.
        edge = next(place_name(p) for p in named if p.part in EDGES)
        found.append(spec("stops", c.subject, near=edge, distance=c.length(1.1, 0.03, 0.6)))
    return found


def _way_of(c: Context, frame: EventFrame) -> Direction | None:
    return next(iter(ways_of(frame.direction, frame, c.subject, c.layout)), None)


_GONE = ("fall", "leave")


def _kept_from(frame: EventFrame) -> bool:
    """ "Stops before it falls off": that does not come about."""
    return frame.link == "before" and frame.sense in _GONE


_BEFORE = ("before", "in_front")


def _stopped(c: Context) -> list[Spec]:
    place = c.frame.place("near", "at", "on", "in", "object", "atop")
    if place is not None and place.kind == "group":
        place = None
    leant = c.frame.place("against")
    if leant is not None and leant.kind in ("object", "support") and leant.name != c.subject:
        # At rest against it is beside it in the end, and not only after a touch.
        beside = round(0.8 * c.size + 0.01, 3)
        stopped = spec("stops", c.subject, near=place_name(leant), distance=beside)
        return [stopped, spec("contacts", c.subject, other=leant.name)]
    ahead = c.frame.place("before", "in_front")
    if ahead is not None and ahead.kind != "group":
        name, near = place_name(ahead), c.length(0.3, 0.02, 0.2)
        there = ahead.kind == "object"
        return [
            *([spec("moves", c.subject, distance=near, toward=name)] if there else []),
            spec("stops", c.subject),
            spec("stops_before", c.subject, before=name),
            *_so_near(c, name),
        ]
    if place is not None and place.kind == "support" and not place.part:
        there = spec("rests_on", c.subject, other=place.name)
        return [spec("stops", c.subject), there, *_off_the_slope(c, place)]
    if place is not None and place.kind == "object" and c.frame.place("on", "atop") == place:
        return [spec("stops", c.subject), spec("rests_on", c.subject, other=place.name)]
    carrier = c.layout.carrier(c.subject)
    if place is None and carrier and _went_nowhere(c):
        # "Spins on the spot and comes to rest": it went nowhere before.
        return [spec("rests_on", c.subject, other=carrier)]
    name = place_name(place) if place is not None else None
    near = _beside(c, name) if name is not None else None
    ramp = c.layout.ramp_below(c.subject)
    near_end_share = 0.5  # 0.1..0.6: of a slope's length: near its lower end is in the lower half
    if near and place is not None and ramp is not None and ramp.name == place.name:
        # "Near the lower end" is in the lower half.
        near = round(min(near, near_end_share * _slope_length(ramp)), 4)
    found = [spec("stops", c.subject, near=name, distance=near)]
    if place is None or ramp is None or ramp.name != place.name:
        return found
    # A ball at the foot of a slope lies before it.
    below = rolls(c) and place.part == "lower_end"
    return found if below else [*found, spec("reaches", c.subject, other=place.name)]


def _went_nowhere(c: Context) -> bool:
    """Whether all that is told of it before happens where it stands."""
    told = [f for f in c.earlier if f.sense != "slow"]
    return bool(told) and all(f.sense in _IN_PLACE for f in told)


def _off_the_slope(c: Context, place: Place) -> list[Spec]:
    """ "Rolls down the ramp and stops on the carpet": with no wheel on the ramp any more."""
    ramp = c.layout.ramp_below(c.subject)
    below = None if ramp is None else ramp.name
    return [] if below in (None, place.name) else [spec("leaves", c.subject, other=below)]


def _slope_length(support: Support) -> float:
    assert isinstance(support.shape, Ramp)
    return math.hypot(support.shape.run, support.shape.rise)


def _beside(c: Context, name: str) -> float:
    """How near its centre is to what it stops near: what is large reaches far ahead of that."""
    near = c.length(2.0, 0.1, 0.6)
    if not c.layout.has(name) or not c.layout.has(c.subject):
        return near
    ahead = unit(level(c.layout.position(name) - c.layout.position(c.subject)))
    return round(max(near, c.layout.extent(c.subject, ahead) + 0.5 * c.size), 3)


def _so_near(c: Context, name: str) -> list[Spec]:
    """ "Stops 5 cm before it"."""
    if c.frame.distance is None and "close" in c.frame.manner:
        # "Stops just before it".
        return [spec("stops", c.subject, near=name, distance=c.length(1.6, 0.1, 0.6))]
    if c.frame.distance is None:
        return []
    far = round(1.6 * c.frame.distance + 0.01, 3)
    return [spec("stops", c.subject, near=name, distance=far)]


def slow(c: Context) -> list[Spec]:
    """ "Slows down and stops", or falls over or flat: it is at rest in the end.

    How much slower it gets otherwise is not told.
    """
    rests = any(f.sense in ("stop", *OVER) or f.posture == "flat" for f in c.later if not f.negated)
    return [spec("stops", c.subject)] if rests else []


_GOING_ON = words_of("move roll slide drift fall fly jump bounce accelerate reverse curve leave")

_IN_PLACE = words_of("spin turn turn_around sway be rest stay")
_MOVING = words_of("move roll slide drift push pull slip kick accelerate spin turn lift rise")


def _goes_on(frame: EventFrame) -> bool:
    """Whether a later frame has it move again."""
    return frame.sense in _GOING_ON and not frame.negated and frame.link in ("then", "before")


def end(c: Context) -> list[Spec]:
    """Where it is in the end, and how."""
    return _ends(c)


def stay(c: Context) -> list[Spec]:
    """Does not move; "standing" alone only means that it does not fall over."""
    if c.frame.posture == "upright" and c.frame.place("in", "on") is None:
        return [spec("upright", c.subject, tilt=20.0)] if not rolls(c) else still(c)
    gone = {*_GOING_ON, "rise"} if c.frame.posture == "still" else {*_GOING_ON, *_MOVING, "land"}
    own = [f for f in c.earlier if f.sense in gone and not (f.agent or f.negated)]
    if c.frame.link == "then" and own and not c.frame.rest:
        # "Rolls to the cup and stays there": from then on; not "is pushed but stays put".
        return _ends(c)
    on = c.frame.place("on", "atop")
    if on is not None and _is_moved(c, on.name):
        # "The plate slides while the orange stays on it": with it.
        return [spec("rests_on", c.subject, other=on.name)]
    found = still(c)
    if on is not None and on.kind in ("support", "object") and not on.part:
        carried = c.layout.carrier(c.subject)
        if carried in (None, on.name):
            found.append(spec("rests_on", c.subject, other=on.name))
    return found


def _is_moved(c: Context, name: str) -> bool:
    """Whether another clause moves this thing."""
    frames = (f for f in c.reading.frames if f is not c.frame and not f.negated)
    return any(f.sense in _MOVING and name in f.patient for f in frames)


def be(c: Context) -> list[Spec]:
    """How things are: at the beginning, or, after they moved, at the end."""
    if c.frame.posture == "still" and c.frame.link == "while":
        # "… while the lamp hangs still": all the time.
        return stay(c)
    if c.frame.sense == "hang" and c.earlier and c.earlier[-1].sense == "rise":
        # "Rises and hovers": it does not come down again.
        return [spec("falls", c.subject, drop=c.length(0.3, 0.02, 0.2), negated=True)]
    if c.earlier and c.frame.link != "which" and _has_acted(c):
        return _ends(c)
    if c.frame.direction == "up" and c.frame.posture == "upright":
        # "The bottle stands up", which lay: no statement says which of its ends is up.
        return []
    found: list[Spec] = []
    for relation, place in c.frame.places:
        if place.kind == "group" or place.name == c.subject:
            continue
        if relation in ("on", "in", "atop") and place.kind != "landmark":
            found.append(spec("contacts", c.subject, other=place.name, to_step=SPEC.start_steps))
        elif relation in ("above", "over") and place.kind != "landmark" and not place.part:
            found.append(spec("contacts", c.subject, other=place.name, to_step=3, negated=True))
    if not found and c.frame.sense in ("rest", "stack", "be") and not c.frame.manner:
        carrier = c.layout.carrier(c.subject)
        if carrier is not None:
            found.append(spec("contacts", c.subject, other=carrier, to_step=SPEC.start_steps))
    return [*found, *quality(c)]


def _has_acted(c: Context) -> bool:
    still = ("rest", "stack", "hang", "be", "stay")
    return any(f.sense not in still for f in c.earlier)


def _ends(c: Context) -> list[Spec]:
    place = c.frame.place("on", "in", "atop")
    found = posture(c)
    if place is not None and place.kind in ("support", "object"):
        found += [spec("rests_on", c.subject, other=place.name), *_off_the_slope(c, place)]
    elif c.frame.sense in ("rest", "end", "stay") and not found:
        carrier = c.layout.carrier(c.subject) if _went_nowhere(c) else None
        still = spec("rests_on", c.subject, other=carrier) if carrier else None
        found.append(still or spec("stops", c.subject))
    return [*found, *quality(c)]


def stack(c: Context) -> list[Spec]:
    """Each touches the one that it stands on."""
    carrier = c.layout.carrier(c.subject)
    if carrier is None:
        return be(c)
    return [spec("contacts", c.subject, other=carrier, to_step=SPEC.start_steps)]
