"""What several senses have in common: ways, places, blows, postures."""

from __future__ import annotations

from physagent_studio.agent.rules.intents import met
from physagent_studio.agent.rules.reading import EventFrame, Place
from physagent_studio.agent.rules.senses.remaining import is_container, is_last
from physagent_studio.agent.rules.specs import (
    START,
    Context,
    Spec,
    any_of,
    forward,
    over_way,
    place_name,
    spec,
    ways_of,
)
from physagent_studio.program.actions import Direction
from physagent_studio.program.scene import Ramp

FLAT_TILT = 20.0
OVER_TILT = 160.0
SIDE_TILT = 60.0


def travel(c: Context) -> list[Spec]:
    """That it moves, along the way that is said, towards what is named."""
    distance = _least_way(c)
    ways = [w for w in c.ways() if w != "down" or c.layout.is_raised(c.subject)]
    found = (
        [any_of(*(spec("moves", c.subject, distance=distance, direction=w) for w in ways))]
        if ways
        else []
    )
    toward = c.frame.place("toward", "at", "against")
    if toward is not None and not is_ground(c, toward) and toward.name != c.subject:
        found.append(spec("moves", c.subject, distance=distance, toward=place_name(toward)))
    gone = c.frame.place("away_from")
    if gone is not None and gone.name != c.subject:
        nearer = spec("moves", c.subject, distance=distance, toward=place_name(gone))
        found += [spec("moves", c.subject, distance=distance), nearer.opposite()]
    return found or [spec("moves", c.subject, distance=distance)]


def _least_way(c: Context) -> float:
    if c.frame.distance is not None:
        return round(0.8 * c.frame.distance, 4)
    return c.length(0.1, 0.01, 0.05) if "slight" in c.frame.manner else c.length(0.5, 0.02, 0.2)


def manner(c: Context) -> list[Spec]:
    """How fast, and whether to and fro, where the prompt says so."""
    if "rhythmic" in c.frame.manner and c.frame.sense in ("roll", "slide", "move", "drift"):
        return [spec("reverses", c.subject, angle=90.0, times=2), *_pace(c)]
    return _pace(c)


def _pace(c: Context) -> list[Spec]:
    if "slow" in c.frame.manner or "gentle" in c.frame.manner:
        if c.frame.sense in ("float", "descend") or c.layout.ramp_below(c.subject) is not None:
            drop = c.length(0.3, 0.02, 0.1)
            return [spec("descends_slowly", c.subject, drop=drop, speed=0.6)]
        return [spec("speed_between", c.subject, low=0.02, high=1.0)]
    if "fast" in c.frame.manner or "hard" in c.frame.manner:
        return [spec("speed_between", c.subject, low=0.7)]
    return []


def is_ground(c: Context, place: Place) -> bool:
    """Whether the place is the ground itself."""
    return place.kind == "support" and place.name == c.layout.ground() and not place.part


def along(c: Context) -> list[Spec]:
    """What the places say: leaves this, comes onto that, passes the other."""
    found: list[Spec] = []
    for relation, place in c.frame.places:
        name = place_name(place)
        if relation in ("off", "from"):
            found += off(c, place)
        elif relation in ("on", "in", "into", "against", "atop") and place.name != c.subject:
            found += _onto(c, relation, place)
        elif relation == "between" and place.kind == "landmark":
            found.append(spec("passes_over", c.subject, landmark=name))
        elif relation in ("over", "along") and place.kind == "support" and not place.part:
            found += _along_support(c, relation, place)
        elif relation == "near" and _begins_near(c, place):
            found.append(spec("contacts", c.subject, other=place.name, to_step=START))
        elif relation == "toward" and is_ground(c, place):
            found += _onto(c, "on", place)
        elif relation == "along" and place.kind == "object" and place.name != c.subject:
            # "Across the laptop": on it, and to its other side.
            found.append(spec("contacts", c.subject, other=place.name))
            found.append(spec("passes_over", c.subject, landmark=place.name, by=True))
        elif relation == "past" and place.kind != "group":
            found += _past(c, place)
        elif relation == "over" and place.kind != "group":
            found += _over(c, place)
        elif relation == "up" and _is_ramp(c, place):
            found += _uphill(c, place)
        elif relation in ("down", "object") and is_slope(c, place):
            found += [
                spec("contacts", c.subject, other=place.name, to_step=START + 10),
                spec("falls", c.subject, drop=c.length(0.3, 0.02, 0.1)),
            ]
    return found


def _past(c: Context, place: Place) -> list[Spec]:
    """What goes past a thing goes by it, on the side that is said; what falls past it does not
    touch it."""
    side = c.frame.direction if c.frame.direction in ("left", "right") else None
    there = [spec("side_of", c.subject, other=place_name(place), side=side)] if side else []
    if place.kind != "object":
        mark = c.layout.state.landmark(place_name(place))
        beside = mark is not None and mark.kind in ("area", "point")
        by = True if beside else None
        passed = spec("passes_over", c.subject, landmark=place_name(place), by=by)
        return [passed, *there] if beside else [passed]
    if c.frame.sense in ("fall", "descend"):
        return [spec("contacts", c.subject, other=place.name, negated=True)]
    passed = [spec("passes_over", c.subject, landmark=place.name, by=True), *there]
    if c.frame.sense in ("fly", "throw", "kick"):
        # What flies past a thing does not bounce off it.
        passed.append(spec("contacts", c.subject, other=place.name, negated=True))
    return passed


def _over(c: Context, place: Place) -> list[Spec]:
    """Across a line or a thing; what flies over an opening does not go through it."""
    name, flies = place_name(place), c.frame.sense in _THROUGH_AIR
    mark = c.layout.state.landmark(name)
    if flies and mark is not None and mark.kind == "opening":
        by = spec("passes_over", c.subject, landmark=name, by=True)
        return [by, spec("passes_over", c.subject, landmark=name, negated=True)]
    # What rolls or slides "over the box" goes by it; what flies over it is above it.
    level = place.kind == "object" and not flies
    found = [spec("passes_over", c.subject, landmark=name, by=True if level else None)]
    if place.kind == "object" and c.frame.sense in ("drift", "float"):
        found.append(spec("side_of", c.subject, other=name, side="above"))
    if _clears(c, place):
        found.append(spec("contacts", c.subject, other=name, negated=True))
    return found


def _clears(c: Context, place: Place) -> bool:
    """Whether a leap is over a thing that nothing else has it touch."""
    if place.kind != "object" or c.frame.sense not in ("jump", "fly", "throw", "kick"):
        return False
    met = {p.name for f in c.later for _, p in f.places} | {n for f in c.later for n in f.patient}
    return place.name not in met and c.layout.carrier(c.subject) != place.name


_THROUGH_AIR = ("jump", "fly", "throw", "kick", "fall", "bounce", "drift", "float")


def _along_support(c: Context, relation: str, place: Place) -> list[Spec]:
    """ "Across the floor": where it is not yet, it gets to; "over the ramp" is beyond it."""
    if is_ground(c, place) or relation == "along":
        here = c.layout.carrier(c.subject) == place.name
        return [] if here else [spec("contacts", c.subject, other=place.name)]
    return [spec("passes_over", c.subject, landmark=place.name)]


def _is_ramp(c: Context, place: Place) -> bool:
    support = c.layout.state.support(place.name)
    return support is not None and isinstance(support.shape, Ramp) and not place.part


def _uphill(c: Context, place: Place) -> list[Spec]:
    """Up a slope: on it, and higher than before."""
    climb = c.length(0.3, 0.02, 0.1)
    return [
        spec("contacts", c.subject, other=place.name),
        spec("moves", c.subject, distance=climb, direction="up"),
        spec("airborne", c.subject, seconds=0.25, negated=True),
    ]


def is_slope(c: Context, place: Place) -> bool:
    """Whether the place is the ramp that carries the subject."""
    ramp = c.layout.ramp_below(c.subject)
    return ramp is not None and ramp.name == place.name and not place.part


def off(c: Context, place: Place) -> list[Spec]:
    """It comes off what it stands on."""
    if place.kind == "group":
        below = c.layout.carrier(c.subject)
        if below is None:
            below = landed_on(c)
        grounded = below is None or below == c.layout.ground()
        return [] if grounded else [spec("leaves", c.subject, other=below)]
    if is_ground(c, place):
        return [spec("contacts", c.subject, other=place.name, to_step=START)]
    if place.kind == "landmark" or place.name == c.subject:
        return []
    carrier = c.layout.carrier(c.subject)
    stacked = carrier is not None and c.layout.state.object(carrier) is not None
    if not stacked or carrier == place.name:
        return [spec("leaves", c.subject, other=place.name)]
    # It stands on others that stand on it: it ends up carried by none of them.
    return [spec("rests_on", c.subject, other=place.name, negated=True)]


def landed_on(c: Context) -> str | None:
    """What an earlier clause has it come down on, the ground apart."""
    for frame in reversed(c.earlier):
        place = frame.place("on")
        if place is not None and place.kind in ("object", "support") and not is_ground(c, place):
            return place.name
    return None


def was_raised(c: Context) -> bool:
    """Whether an earlier clause brought it off the ground, so that it can come down on it."""
    return any(f.sense in ("throw", "kick", "fly", "jump", "rise", "bounce") for f in c.earlier)


def _onto(c: Context, relation: str, place: Place) -> list[Spec]:
    name = place_name(place)
    if place.kind == "landmark":
        inside = relation in ("in", "into")
        return [spec("lands_in", c.subject, landmark=name)] if inside else []
    if place.kind == "group":
        return _in_stack(c) if relation == "in" else []
    if relation == "atop":
        return [spec("reaches" if is_last(c) else "contacts", c.subject, other=name)]
    if relation in ("in", "into") and place.kind in ("object", "support") and is_container(name):
        drops = c.frame.sense in ("fall", "land", "throw", "kick", "jump", "fly", "bounce")
        if drops and is_last(c):
            return [spec("lands_in", c.subject, landmark=name)]
    if c.layout.carrier(c.subject) == place.name and relation == "on" and was_raised(c):
        return [spec("reaches", c.subject, other=place.name)]
    thrown = ("fall", "throw", "jump")
    drops = c.frame.sense in thrown and relation in ("on", "atop")
    if drops and not is_ground(c, place) and place.kind in ("object", "support") and is_last(c):
        # "Drops onto the table" is not falling past its edge.
        return [spec("reaches", c.subject, other=name)]
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


def bent_path(c: Context) -> list[Spec]:
    """The shape of its path, where the prompt says one."""
    if not c.frame.path:
        return []
    if c.frame.path == "straight":
        return [spec("path_bends", c.subject, angle=15.0, negated=True)]
    angle = 150.0 if c.frame.path == "circle" else 10.0
    side = c.frame.direction if c.frame.direction in ("left", "right") else "either"
    return [spec("path_bends", c.subject, side=side, angle=angle)]


def touch(c: Context) -> list[Spec]:
    """The agents touch the subject: one of several suffices."""
    agents = [a for a in c.frame.agent if a != c.subject]
    if not agents:
        return []
    return [any_of(*(spec("contacts", a, other=c.subject) for a in agents))]


def sideways_fall(c: Context) -> list[Spec]:
    """ "Topples to the left": its middle goes there."""
    frame = c.frame
    plain = frame.direction in (None, "up", "down", "off")
    way = falling_way(c) or (frame.origin if plain else frame.direction)
    if way in (None, "forward", "backward", "up", "down", "off"):
        return []
    far = c.length(0.25, 0.02, 0.2)
    ways = ways_of(way, frame, c.subject, c.layout)
    moved = [spec("moves", c.subject, distance=far, direction=w) for w in ways]
    return [any_of(*moved)] if moved else []


def falling_way(c: Context) -> Direction | None:
    """ "Topples backwards", "falls on its face"; away from what knocks it over backwards."""
    if not _was_struck(c) and (way := over_way(c.frame, c.subject)) is not None:
        return way
    if c.frame.direction == "backward" and c.frame.agent:
        return forward(c.frame, c.subject, c.layout)
    return None


def _was_struck(c: Context) -> bool:
    return any(f.agent and c.subject in f.patient for f in c.earlier)


def siblings(c: Context) -> list[Spec]:
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


def struck_before(c: Context) -> list[Spec]:
    """The blow that an earlier clause tells of, with the subject on either side of it."""
    for frame in c.earlier:
        if frame.sense != "hit" or not frame.agent:
            continue
        if c.subject in frame.patient:
            return [spec("contacts", frame.agent[0], other=c.subject)]
        if c.subject in frame.agent and frame.patient:
            return [spec("contacts", c.subject, other=frame.patient[0])]
    for frame in c.reading.frames[: c.index]:
        # "Slides into the cup, which tips over".
        if c.subject in met(frame) and not frame.any_one and len(frame.patient) == 1:
            return [spec("contacts", frame.patient[0], other=c.subject)]
    return []


def posture(c: Context) -> list[Spec]:
    """How it ends."""
    if c.layout.is_ball(c.subject):
        return []
    flat = spec("upright", c.subject, tilt=FLAT_TILT)
    if c.frame.posture == "flat":
        return [any_of(flat, spec("topples", c.subject, tilt=OVER_TILT))]
    if c.frame.posture == "upright":
        return [flat]
    if c.frame.posture in ("supine", "prone"):
        return [spec("topples", c.subject, tilt=SIDE_TILT), *sideways_fall(c)]
    if c.frame.posture == "side":
        return [spec("topples", c.subject, tilt=SIDE_TILT)]
    return [spec("topples", c.subject, tilt=135.0)] if c.frame.posture == "inverted" else []


def is_ball(c: Context) -> bool:
    """Whether the subject is a ball."""
    return c.layout.is_ball(c.subject)


def still(c: Context) -> list[Spec]:
    """It stays where and as it is."""
    return [spec("stays", c.subject, distance=c.length(0.4, 0.03, 0.05), tilt=15.0)]


def quality(c: Context) -> list[Spec]:
    """ "The motion is gentle, continuous and rhythmic"."""
    found: list[Spec] = []
    if "gentle" in c.frame.manner or "slow" in c.frame.manner:
        found.append(spec("speed_between", c.subject, low=0.01, high=1.5))
    if "continuous" in c.frame.manner:
        found.append(spec("sways", c.subject, amplitude=2.0, cycles=1.0, from_step=160))
    if "rhythmic" in c.frame.manner:
        found.append(spec("sways", c.subject, amplitude=2.0, cycles=2.0))
    return found


_OVER = ("topple", "fall", "knock_over", "tip_over", "flip", "collapse", "lose_balance")


def keeps_standing(c: Context) -> list[Spec]:
    """What bends or sways does not fall over, unless that is told next."""
    falls = any(f.sense in _OVER and not f.negated for f in c.later)
    return [] if is_ball(c) or falls else [spec("topples", c.subject, tilt=60.0, negated=True)]


def arrival(c: Context, frame: EventFrame) -> Spec | None:
    """The statement that the subject gets to the place of a frame; None where it names none."""
    place = frame.place("object", "on", "at", "toward", "in", "into", "against")
    if place is None or place.kind == "group":
        return None
    if place.kind == "support" and place.part == "lower_end":
        return spec("contacts", c.subject, other=c.layout.ground())
    name = place_name(place)
    if place.kind == "landmark":
        return spec("passes_over", c.subject, landmark=name)
    return spec("contacts", c.subject, other=name)
