"""What each sense of a verb demands: one small builder of statements per sense."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from physagent_studio.agent.rules.reading import EventFrame, Place
from physagent_studio.agent.rules.specs import (
    START,
    Context,
    Spec,
    any_of,
    before,
    place_name,
    spec,
)

Builder = Callable[[Context], Sequence[Spec]]

FLAT_TILT, OVER_TILT, SIDE_TILT = 20.0, 160.0, 60.0


# --- motion ----------------------------------------------------------------------------------


def _travel(c: Context) -> list[Spec]:
    """That it moves, along the way that is said, towards what is named."""
    distance = c.length(0.5, 0.02, 0.2) if c.frame.distance is None else 0.8 * c.frame.distance
    ways = [w for w in c.ways() if w != "down" or c.layout.is_raised(c.subject)]
    found = (
        [any_of(*(spec("moves", c.subject, distance=distance, direction=w) for w in ways))]
        if ways
        else []
    )
    toward = c.frame.place("toward", "at", "against")
    if toward is not None and not _is_ground(c, toward) and toward.name != c.subject:
        found.append(spec("moves", c.subject, distance=distance, toward=place_name(toward)))
    return found or [spec("moves", c.subject, distance=distance)]


def _manner(c: Context) -> list[Spec]:
    if "slow" in c.frame.manner or "gentle" in c.frame.manner:
        if c.frame.sense in ("float", "descend") or c.layout.ramp_below(c.subject) is not None:
            drop = c.length(0.3, 0.02, 0.1)
            return [spec("descends_slowly", c.subject, drop=drop, speed=0.6)]
        return [spec("speed_between", c.subject, low=0.02, high=1.0)]
    if "fast" in c.frame.manner or "hard" in c.frame.manner:
        return [spec("speed_between", c.subject, low=0.7)]
    return []


def _is_ground(c: Context, place: Place) -> bool:
    return place.kind == "support" and place.name == c.layout.ground() and not place.part


def _along(c: Context) -> list[Spec]:
    """What the places say: leaves this, comes onto that, passes the other."""
    found: list[Spec] = []
    for relation, place in c.frame.places:
        name = place_name(place)
        if relation in ("off", "from"):
            found += _off(c, place)
        elif relation in ("on", "in", "against") and place.name != c.subject:
            found += _onto(c, relation, place)
        elif relation == "near" and _begins_near(c, place):
            found.append(spec("contacts", c.subject, other=place.name, to_step=START))
        elif relation == "toward" and _is_ground(c, place):
            found += _onto(c, "on", place)
        elif relation == "over" and place.kind != "group":
            found.append(spec("passes_over", c.subject, landmark=name))
        elif relation in ("down", "object") and _is_slope(c, place):
            found += [
                spec("contacts", c.subject, other=place.name, to_step=START + 10),
                spec("falls", c.subject, drop=c.length(0.3, 0.02, 0.1)),
            ]
    return found


def _is_slope(c: Context, place: Place) -> bool:
    ramp = c.layout.ramp_below(c.subject)
    return ramp is not None and ramp.name == place.name and not place.part


def _off(c: Context, place: Place) -> list[Spec]:
    if place.kind == "group":
        below = c.layout.carrier(c.subject)
        return [spec("leaves", c.subject, other=below)] if below is not None else []
    if _is_ground(c, place):
        return [spec("contacts", c.subject, other=place.name, to_step=START)]
    if place.kind == "landmark" or place.name == c.subject:
        return []
    carrier = c.layout.carrier(c.subject)
    stacked = carrier is not None and c.layout.state.object(carrier) is not None
    if not stacked or carrier == place.name:
        return [spec("leaves", c.subject, other=place.name)]
    # It stands on others that stand on it: it ends up carried by none of them.
    return [spec("rests_on", c.subject, other=place.name, negated=True)]


def _onto(c: Context, relation: str, place: Place) -> list[Spec]:
    name = place_name(place)
    if place.kind == "landmark":
        return [spec("lands_in", c.subject, landmark=name)] if relation == "in" else []
    if place.kind == "group":
        return _in_stack(c) if relation == "in" else []
    if c.layout.carrier(c.subject) == place.name and relation == "on":
        # Where it already is ("a ball on the grass rolls"): how it begins.
        return [spec("contacts", c.subject, other=place.name, to_step=START)]
    return [spec("contacts", c.subject, other=place.name)]


def _begins_near(c: Context, place: Place) -> bool:
    """ "Near the table edge", said first: it stands on the table, unless it lies on a stack."""
    carrier = c.layout.carrier(c.subject)
    stacked = carrier is not None and c.layout.state.object(carrier) is not None
    return place.kind == "support" and bool(place.part) and not c.earlier and not stacked


def _in_stack(c: Context) -> list[Spec]:
    """ "In a stack": it stands on the next lower one of the objects, else on its support."""
    layout = c.layout
    below = layout.carrier(c.subject)
    if below is None and layout.has(c.subject):
        height = layout.position(c.subject)[2]
        others = [o.name for o in layout.state.objects if layout.has(o.name)]
        lower = [n for n in others if layout.position(n)[2] < height]
        below = max(lower, key=lambda n: layout.position(n)[2], default=None)
    return [spec("contacts", c.subject, other=below, to_step=START)] if below else []


def move(c: Context) -> list[Spec]:
    """Moves, slides, drifts, flies."""
    return [*_travel(c), *_along(c), *_manner(c), *_bend(c)]


def roll(c: Context) -> list[Spec]:
    """Moves on the ground; a ball turns while it does."""
    found = move(c)
    if c.layout.is_ball(c.subject):
        found.append(spec("rotates", c.subject, angle=90.0))
        found.append(spec("airborne", c.subject, seconds=0.3, negated=True))
    elif c.layout.ramp_below(c.subject) is not None:
        found.append(spec("upright", c.subject, tilt=50.0))
    return found


def _bend(c: Context) -> list[Spec]:
    if not c.frame.path:
        return []
    if c.frame.path == "straight":
        return [spec("path_bends", c.subject, angle=15.0, negated=True)]
    angle = 150.0 if c.frame.path == "circle" else 10.0
    side = c.frame.direction if c.frame.direction in ("left", "right") else "either"
    return [spec("path_bends", c.subject, side=side, angle=angle)]


def curve(c: Context) -> list[Spec]:
    """The path bends to a side."""
    side = c.frame.direction if c.frame.direction in ("left", "right") else "either"
    angle = 150.0 if c.frame.path == "circle" else 10.0
    bent = spec("path_bends", c.subject, side=side, angle=angle)
    return [bent, spec("moves", c.subject, distance=c.length(0.5, 0.05, 0.3)), *_along(c)]


def circle(c: Context) -> list[Spec]:
    """Goes round."""
    return [spec("path_bends", c.subject, angle=150.0), *_along(c)]


def fly(c: Context) -> list[Spec]:
    """Goes through the air towards something."""
    return [*move(c), spec("airborne", c.subject, seconds=0.15)]


def fall(c: Context) -> list[Spec]:
    """Comes down; a thing that stands on the ground can only fall over."""
    stands = c.layout.has(c.subject) and not c.layout.is_raised(c.subject)
    off = c.frame.place("off", "from")
    if stands and off is None and not c.layout.is_ball(c.subject):
        return topple(c)
    found = [spec("falls", c.subject, drop=c.length(0.4, 0.03, 0.1))]
    if "straight" in c.frame.manner or (c.frame.direction == "down" and c.frame.manner):
        found += _vertical(c)
    ways = [w for w in c.ways() if w not in ("down", "up")]
    if ways:
        far = c.length(0.5, 0.02, 0.2)
        found.append(any_of(*(spec("moves", c.subject, distance=far, direction=w) for w in ways)))
    return [*found, *_along(c), *_manner(c), *_once_there(c, found[0])]


def _once_there(c: Context, event: Spec) -> list[Spec]:
    """ "As it passes the edge, it falls": the passing comes first."""
    for frame in c.earlier:
        if frame.link == "as" and frame.sense in ("pass", "cross", "reach", "hit"):
            place = frame.place("object", "over")
            if place is not None and place.kind != "group":
                passed = spec("passes_over", c.subject, landmark=place_name(place))
                return [before(passed, event)]
    return []


def _vertical(c: Context) -> list[Spec]:
    aside = c.length(0.3, 0.03, 0.1)
    sides = ("left", "right", "away", "toward_camera")
    drift = any_of(
        *(spec("moves", c.subject, distance=aside, direction=w, to_step=16) for w in sides)
    )
    return [drift.opposite()]


def descend(c: Context) -> list[Spec]:
    """Comes down a slope or through the air."""
    found = [spec("falls", c.subject, drop=c.length(0.3, 0.02, 0.1))]
    return [*found, *_along(c), *_manner(c)]


def float_down(c: Context) -> list[Spec]:
    """Sinks through the air, never fast."""
    found = [
        spec("descends_slowly", c.subject, drop=c.length(0.3, 0.02, 0.1), speed=0.5),
        spec("airborne", c.subject, seconds=0.2),
    ]
    return [*found, *(s for s in _along(c) if s.kind != "contacts")]


def rise(c: Context) -> list[Spec]:
    """Goes up."""
    return [spec("moves", c.subject, distance=c.length(0.3, 0.02, 0.2), direction="up")]


def jump(c: Context) -> list[Spec]:
    """Leaves the ground for a moment."""
    return [*rise(c), spec("airborne", c.subject, seconds=0.1), *_along(c)]


def bounce(c: Context) -> list[Spec]:
    """Touches something and is free again."""
    off = c.frame.place("off", "on", "against", "from", "object")
    other = off.name if off is not None and off.kind != "landmark" else c.layout.ground()
    if c.layout.is_raised(c.subject) or other == c.layout.ground():
        return [spec("contacts", c.subject, other=other), spec("airborne", c.subject, seconds=0.1)]
    return [spec("contacts", c.subject, other=other), spec("leaves", c.subject, other=other)]


def slip(c: Context) -> list[Spec]:
    """Begins to slide; off its support where it falls afterwards."""
    found = [spec("moves", c.subject, distance=c.length(0.4, 0.02, 0.1))]
    falls = any(f.sense == "fall" for f in c.later)
    base = c.layout.base(c.subject)
    if falls and base is not None and base != c.layout.ground():
        found.append(spec("leaves", c.subject, other=c.layout.carrier(c.subject) or base))
    return [*found, *_along(c)]


# --- doing something to another ----------------------------------------------------------------


def _touch(c: Context) -> list[Spec]:
    """The agents touch the subject: one of several suffices."""
    agents = [a for a in c.frame.agent if a != c.subject]
    if not agents:
        return []
    return [any_of(*(spec("contacts", a, other=c.subject) for a in agents))]


def _siblings(c: Context) -> list[Spec]:
    """ "Only": the acting object touches none of the others of the kind."""
    if not c.frame.only:
        return []
    kind = c.subject.split("_")[-1]
    meant = {*c.frame.patient, *c.frame.agent}
    others = [o.name for o in c.layout.state.objects if o.name not in meant]
    alike = [name for name in others if name.split("_")[-1] == kind]
    if c.frame.agent:
        # "Hits only the cube": nothing else is hit, whatever it is, but what carries the agent.
        carriers = {c.layout.carrier(a) for a in c.frame.agent}
        spared = [name for name in others if name not in carriers]
        return [spec("contacts", a, other=s, negated=True) for a in c.frame.agent for s in spared]
    return [spec("stays", s, distance=0.05, tilt=15.0) for s in alike]


def hit(c: Context) -> list[Spec]:
    """Two objects touch."""
    found = [*_touch(c), *_siblings(c)]
    if c.frame.agent and ("hard" in c.frame.manner or "fast" in c.frame.manner):
        found.append(spec("speed_between", c.frame.agent[0], low=0.7))
    return found or move(c)


def push(c: Context) -> list[Spec]:
    """The subject is moved; by an object where one is named."""
    touched = _touch(c)
    moved = _travel(c) if not c.frame.agent else _pushed_away(c)
    found = [*touched, *moved, *_siblings(c), *_along(c)]
    if touched and moved:
        found.append(before(touched[0], moved[0]))
    return found


def _pushed_away(c: Context) -> list[Spec]:
    ways = c.ways()
    distance = c.length(0.3, 0.02, 0.1)
    if ways:
        return [any_of(*(spec("moves", c.subject, distance=distance, direction=w) for w in ways))]
    return [spec("moves", c.subject, distance=distance)]


def kick(c: Context) -> list[Spec]:
    """Gets a speed in a moment."""
    return [*move(c), spec("speed_between", c.subject, low=0.8)]


def crush(c: Context) -> list[Spec]:
    """The subject is deformed or breaks under another."""
    harmed = any_of(spec("deforms", c.subject, strain=0.05), spec("breaks", c.subject))
    touched = _touch(c)
    # It may give way in the very moment of the blow, but not earlier.
    return [*touched, harmed, *(before(harmed, one).opposite() for one in touched)]


def knock_over(c: Context) -> list[Spec]:
    """The subject falls over; after it was hit, where something hits it."""
    if c.layout.is_ball(c.subject):
        return [*_touch(c), spec("moves", c.subject, distance=c.length(0.5, 0.02, 0.2))]
    over = spec("topples", c.subject, tilt=45.0)
    struck = _touch(c) or _struck_before(c)
    found = [*_touch(c), over, *_siblings(c)]
    return [*found, before(struck[0], over)] if struck else found


def _struck_before(c: Context) -> list[Spec]:
    """The blow that an earlier clause tells of, with the subject on either side of it."""
    for frame in c.earlier:
        if frame.sense != "hit" or not frame.agent:
            continue
        if c.subject in frame.patient:
            return [spec("contacts", frame.agent[0], other=c.subject)]
        if c.subject in frame.agent and frame.patient:
            return [spec("contacts", c.subject, other=frame.patient[0])]
    return []


# --- turning and falling over ------------------------------------------------------------------


def topple(c: Context) -> list[Spec]:
    """Falls over, onto its side where that is said."""
    if c.layout.is_ball(c.subject):
        return [spec("moves", c.subject, distance=c.length(0.5, 0.02, 0.2))]
    tilt = SIDE_TILT if c.frame.posture == "side" else 45.0
    over = spec("topples", c.subject, tilt=tilt)
    found = [over]
    if c.frame.posture == "side":
        found.append(spec("topples", c.subject, tilt=135.0, negated=True))
    struck = _struck_before(c)
    if struck:
        found.append(before(struck[0], over))
    on = c.frame.place("on")
    if on is not None and on.kind == "support":
        found.append(spec("reaches", c.subject, other=on.name))
    return [*found, *(s for s in _along(c) if s.kind in ("leaves", "rests_on"))]


def lose_balance(c: Context) -> list[Spec]:
    """Tilts."""
    return [spec("rotates", c.subject, angle=20.0)]


def flip(c: Context) -> list[Spec]:
    """Turns over about a level axis; a number says how often."""
    times = c.frame.count
    angle = 80.0 if times is None else 360.0 * times - 210.0
    ways = [w for w in c.ways() if w not in ("up", "down")]
    flips = any_of(*(spec("flips", c.subject, angle=angle, direction=w) for w in ways or [None]))
    if c.layout.is_ball(c.subject):
        return [spec("rotates", c.subject, angle=angle)]
    found = [flips, *(s for s in _along(c) if s.kind != "passes_over")]
    if times is not None:
        found.append(spec("flips", c.subject, angle=360.0 * times + 180.0, negated=True))
    if c.frame.posture == "airborne":
        found.append(before(flips, spec("contacts", c.subject, other=c.layout.ground())))
    return found


def spin(c: Context) -> list[Spec]:
    """Turns about itself."""
    angle = 180.0 if c.frame.count is None else 360.0 * c.frame.count - 60.0
    return [spec("rotates", c.subject, angle=angle), *_along(c)]


def turn(c: Context) -> list[Spec]:
    """Turns, without saying how."""
    return [spec("rotates", c.subject, angle=30.0)]


def turn_around(c: Context) -> list[Spec]:
    """Faces another way than before."""
    if c.layout.is_ball(c.subject):
        return reverse(c)
    return [spec("rotates", c.subject, angle=90.0, axis=(0.0, 0.0, 1.0))]


def reverse(c: Context) -> list[Spec]:
    """Goes back where it came from, or another way."""
    back = spec("reverses", c.subject, angle=90.0)
    following = c.reading.frames[c.index + 1 : c.index + 2]
    if following and following[0].link == "after" and following[0].sense == "reach":
        reached = _arrival(c, following[0])
        return [back, before(reached, back)] if reached is not None else [back]
    return [back]


# --- arriving ----------------------------------------------------------------------------------


def _arrival(c: Context, frame: EventFrame) -> Spec | None:
    place = frame.place("object", "on", "at", "toward", "in")
    if place is None or place.kind == "group":
        return None
    if place.kind == "support" and place.part == "lower_end":
        return spec("contacts", c.subject, other=c.layout.ground())
    name = place_name(place)
    if place.kind == "landmark" and place.landmark_kind == "line":
        return spec("passes_over", c.subject, landmark=name)
    return spec("contacts", c.subject, other=name)


def reach(c: Context) -> list[Spec]:
    """Comes to a place; "before reaching" means that it does not get there."""
    place = c.frame.place("object", "on", "at", "toward", "in")
    if place is None or place.kind == "group":
        return []
    name = place_name(place)
    main = c.earlier[-1] if c.earlier else None
    if c.frame.link == "before" and main is not None:
        if main.sense in ("stop", "settle", "stay", "rest", "slow"):
            return [spec("stops_before", c.subject, before=name)]
        return _ordered(c, main)
    arrival = _arrival(c, c.frame)
    if place.kind == "support" and not place.part and c.frame.link != "after":
        found = [spec("reaches", c.subject, other=name)]
        start = c.layout.carrier(c.subject)
        if start is not None and start != name and arrival is not None:
            found.append(before(spec("contacts", c.subject, other=start), arrival))
        return found
    return [arrival] if arrival is not None else []


def _ordered(c: Context, main: EventFrame) -> list[Spec]:
    """The event before comes first."""
    arrival = _arrival(c, c.frame)
    build = SENSES.get(main.sense)
    index = c.reading.frames.index(main)
    earlier = build(Context(main, c.subject, index, c.reading, c.layout)) if build else ()
    return [before(earlier[0], arrival)] if earlier and arrival is not None else []


def cross(c: Context) -> list[Spec]:
    """Passes a line, an edge or a thing."""
    place = c.frame.place("object", "over", "along", "on", "in")
    if place is None or place.kind == "group":
        return []
    if _is_ground(c, place):
        return [spec("moves", c.subject, distance=c.length(2.0, 0.2, 1.0))]
    over = c.frame.place("over") is not None
    if place.kind == "object" and not place.part and not over:
        # "Passes the block" is going by it, and passing is not bumping into it.
        return [
            spec("passes_over", c.subject, landmark=place.name, by=True),
            spec("contacts", c.subject, other=place.name, negated=True),
        ]
    return [spec("passes_over", c.subject, landmark=place_name(place))]


def enter(c: Context) -> list[Spec]:
    """Ends inside."""
    place = c.frame.place("object", "in", "on", "toward")
    if place is None or place.kind == "group":
        return []
    if place.kind == "landmark":
        return [spec("lands_in", c.subject, landmark=place_name(place))]
    return [spec("contacts", c.subject, other=place.name)]


def land(c: Context) -> list[Spec]:
    """Comes down onto or into something, in a posture where one is said."""
    place = c.frame.place("on", "in", "object", "toward", "at")
    found: list[Spec] = []
    if place is None or place.kind == "group":
        found.append(spec("contacts", c.subject, other=c.layout.ground()))
    elif place.kind == "landmark":
        found.append(spec("lands_in", c.subject, landmark=place_name(place)))
    elif c.frame.posture:
        found.append(spec("reaches", c.subject, other=place.name))
    else:
        found.append(spec("contacts", c.subject, other=place.name))
    if "hard" in c.frame.manner:
        found.append(spec("speed_between", c.subject, low=0.7))
    return [*found, *posture(c)]


def posture(c: Context) -> list[Spec]:
    """How it ends."""
    if c.layout.is_ball(c.subject):
        return []
    flat = spec("upright", c.subject, tilt=FLAT_TILT)
    if c.frame.posture == "flat":
        return [any_of(flat, spec("topples", c.subject, tilt=OVER_TILT))]
    if c.frame.posture == "upright":
        return [flat]
    if c.frame.posture == "side":
        return [spec("topples", c.subject, tilt=SIDE_TILT)]
    return [spec("topples", c.subject, tilt=135.0)] if c.frame.posture == "inverted" else []


def approach(c: Context) -> list[Spec]:
    """Comes nearer."""
    place = c.frame.place("object", "toward", "near", "on")
    if place is None or place.kind == "group":
        return []
    distance = c.length(0.3, 0.02, 0.2)
    # What the prompt has above something may first be put there.
    placed = 5 if any(f.place("above") for f in c.earlier) else None
    near = spec("moves", c.subject, distance=distance, toward=place_name(place), from_step=placed)
    slow = "slow" in c.frame.manner or "gentle" in c.frame.manner
    return [near, spec("speed_between", c.subject, low=0.02, high=0.8)] if slow else [near]


def leave(c: Context) -> list[Spec]:
    """Loses touch: with the ground for a while, with anything else for good."""
    place = c.frame.place("object", "off", "from")
    if place is None or _is_ground(c, place):
        return [spec("airborne", c.subject, seconds=0.12)]
    if place.kind == "landmark":
        return [spec("moves", c.subject, distance=c.length(0.5, 0.02, 0.2))]
    return _off(c, place)


def miss(c: Context) -> list[Spec]:
    """Never touches it."""
    place = c.frame.place("object")
    if place is None or place.kind in ("landmark", "group"):
        return []
    return [spec("contacts", c.subject, other=place.name, negated=True)]


def lose_support(c: Context) -> list[Spec]:
    """Nothing carries it for a while."""
    return [spec("airborne", c.subject, seconds=0.1)]


# --- coming to rest and staying ------------------------------------------------------------------


def stop(c: Context) -> list[Spec]:
    """Moves and then is at rest, near or on what is named."""
    place = c.frame.place("near", "at", "on", "in", "object")
    if place is not None and place.kind == "group":
        place = None
    ahead = c.frame.place("before")
    if ahead is not None and ahead.kind != "group":
        return [spec("stops", c.subject), spec("stops_before", c.subject, before=place_name(ahead))]
    if place is not None and place.kind == "support" and not place.part:
        return [spec("stops", c.subject), spec("rests_on", c.subject, other=place.name)]
    name = place_name(place) if place is not None else None
    near = c.length(2.0, 0.1, 0.6) if name is not None else None
    found = [spec("stops", c.subject, near=name, distance=near)]
    ramp = c.layout.ramp_below(c.subject)
    if place is not None and ramp is not None and ramp.name == place.name:
        found.append(spec("reaches", c.subject, other=place.name))
    return found


def stay(c: Context) -> list[Spec]:
    """Does not move; "standing" alone only means that it does not fall over."""
    if c.frame.posture == "upright" and c.frame.place("in", "on") is None:
        return [spec("upright", c.subject, tilt=20.0)] if not _ball(c) else _still(c)
    found = _still(c)
    on = c.frame.place("on")
    if on is not None and on.kind in ("support", "object") and not on.part:
        carried = c.layout.carrier(c.subject)
        if carried in (None, on.name):
            found.append(spec("rests_on", c.subject, other=on.name))
    return found


def _ball(c: Context) -> bool:
    return c.layout.is_ball(c.subject)


def _still(c: Context) -> list[Spec]:
    return [spec("stays", c.subject, distance=c.length(0.4, 0.03, 0.05), tilt=15.0)]


def be(c: Context) -> list[Spec]:
    """How things are: at the beginning, or, after they moved, at the end."""
    if c.earlier and c.frame.link != "which" and _has_acted(c):
        return _ends(c)
    found: list[Spec] = []
    for relation, place in c.frame.places:
        if place.kind == "group" or place.name == c.subject:
            continue
        if relation in ("on", "in") and place.kind != "landmark":
            found.append(spec("contacts", c.subject, other=place.name, to_step=START))
        elif relation in ("above", "over", "under") and place.kind != "landmark":
            found.append(spec("contacts", c.subject, other=place.name, to_step=3, negated=True))
    if not found and c.frame.sense in ("rest", "stack", "be") and not c.frame.manner:
        carrier = c.layout.carrier(c.subject)
        if carrier is not None:
            found.append(spec("contacts", c.subject, other=carrier, to_step=START))
    return [*found, *_quality(c)]


def _has_acted(c: Context) -> bool:
    still = ("rest", "stack", "hang", "be", "stay")
    return any(f.sense not in still for f in c.earlier)


def _ends(c: Context) -> list[Spec]:
    place = c.frame.place("on", "in")
    found = posture(c)
    if place is not None and place.kind in ("support", "object"):
        found.append(spec("rests_on", c.subject, other=place.name))
    elif place is not None and place.kind == "landmark":
        found.append(spec("lands_in", c.subject, landmark=place_name(place)))
    elif c.frame.sense == "rest" and not found:
        found.append(spec("stops", c.subject))
    return [*found, *_quality(c)]


def _quality(c: Context) -> list[Spec]:
    """ "The motion is gentle, continuous and rhythmic"."""
    found: list[Spec] = []
    if "gentle" in c.frame.manner or "slow" in c.frame.manner:
        found.append(spec("speed_between", c.subject, low=0.01, high=1.5))
    if "continuous" in c.frame.manner:
        found.append(spec("sways", c.subject, amplitude=2.0, cycles=1.0, from_step=160))
    if "rhythmic" in c.frame.manner:
        found.append(spec("sways", c.subject, amplitude=2.0, cycles=2.0))
    return found


def stack(c: Context) -> list[Spec]:
    """Each touches the one that it stands on."""
    carrier = c.layout.carrier(c.subject)
    if carrier is None:
        return be(c)
    return [spec("contacts", c.subject, other=carrier, to_step=START)]


# --- wind and what gives way ---------------------------------------------------------------------


def wind(c: Context) -> list[Spec]:
    """The air moves it: it sways, bends or goes along."""
    far = c.length(0.1, 0.01, 0.05)
    ways = c.ways() or (None,)
    moved = [spec("moves", c.subject, distance=far, direction=w) for w in ways]
    if any(f.sense in ("sway", "bend") or f.manner & {"rhythmic"} for f in c.reading.frames):
        bent = [spec("sways", c.subject, amplitude=2.0), spec("deforms", c.subject, strain=0.03)]
        return [any_of(*moved, *bent), *_quality(c)]
    return [any_of(*moved), *_quality(c), *_along(c)]


def sway(c: Context) -> list[Spec]:
    """Moves to and fro."""
    return [spec("sways", c.subject, amplitude=3.0, cycles=1.0), *_stands(c), *_quality(c)]


def _stands(c: Context) -> list[Spec]:
    """What bends or sways does not fall over."""
    return [] if _ball(c) else [spec("topples", c.subject, tilt=60.0, negated=True)]


def bend(c: Context) -> list[Spec]:
    """Changes its shape or leans, and does not fall over."""
    leans = any_of(spec("deforms", c.subject, strain=0.02), spec("rotates", c.subject, angle=5.0))
    return [leans, *_stands(c)]


def lean(c: Context) -> list[Spec]:
    """Tilts without falling over."""
    return [spec("rotates", c.subject, angle=10.0)]


def collapse(c: Context) -> list[Spec]:
    """Comes down and loses its shape."""
    gone = any_of(
        spec("deforms", c.subject, strain=0.1),
        spec("breaks", c.subject),
        spec("spreads", c.subject, factor=1.3),
    )
    return [spec("falls", c.subject, drop=c.length(0.1, 0.01, 0.1)), gone]


def break_apart(c: Context) -> list[Spec]:
    """At least one of its joints lets go."""
    return [spec("breaks", c.subject)]


def spread(c: Context) -> list[Spec]:
    """Covers more ground, towards where it is said."""
    ways = [w for w in c.ways() if w not in ("up", "down")]
    found = [spec("spreads", c.subject, factor=1.3)]
    if ways:
        distance = c.length(0.15, 0.02, 0.1)
        found.append(
            any_of(*(spec("moves", c.subject, distance=distance, direction=w) for w in ways))
        )
    return found


def deform(c: Context) -> list[Spec]:
    """Loses its shape."""
    return [spec("deforms", c.subject, strain=0.05)]


SENSES: dict[str, Builder] = {
    "move": move, "slide": move, "drift": move, "accelerate": move, "roll": roll, "fly": fly,
    "curve": curve, "circle": circle, "fall": fall, "descend": descend, "float": float_down,
    "rise": rise, "jump": jump, "bounce": bounce, "slip": slip, "hit": hit, "push": push,
    "pull": push, "dislodge": push, "kick": kick, "throw": kick, "knock": hit,
    "knock_over": knock_over, "tip_over": knock_over, "crush": crush, "topple": topple,
    "lose_balance": lose_balance, "flip": flip, "spin": spin, "turn": turn,
    "turn_around": turn_around, "reverse": reverse, "reach": reach, "cross": cross, "pass": cross,
    "enter": enter, "land": land, "approach": approach, "leave": leave, "miss": miss,
    "lose_support": lose_support, "stop": stop, "settle": stop, "stay": stay, "rest": be,
    "hang": be, "be": be, "stack": stack, "wind": wind, "sway": sway, "bend": bend, "lean": lean,
    "collapse": collapse, "break": break_apart, "spread": spread, "deform": deform,
}  # fmt: skip
"""Builders by sense; a sense without one leaves its clause untested, and that is shown."""
