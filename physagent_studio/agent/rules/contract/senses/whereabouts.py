"""What the places of a clause demand: it leaves this, comes onto that, passes the other."""

from __future__ import annotations

import math
from dataclasses import replace

from physagent_studio.agent.rules.contract.impossible import too_high
from physagent_studio.agent.rules.contract.senses.remaining import is_container, is_last
from physagent_studio.agent.rules.contract.specs import (
    SPEC,
    Context,
    Spec,
    any_of,
    spec,
)
from physagent_studio.agent.rules.scene.measures import level, named_way, place_name
from physagent_studio.agent.rules.scene.steps import descents, steps_below
from physagent_studio.language import SLOPE_ENDS, Place
from physagent_studio.program.scene.state import Ramp


def is_ground(c: Context, place: Place) -> bool:
    """Whether the place is the ground itself."""
    return place.kind == "support" and place.name == c.layout.ground() and not place.part


def along(c: Context) -> list[Spec]:
    """What the places say: leaves this, comes onto that, passes the other."""
    found: list[Spec] = []
    # What goes along with the thing that carries it touches nothing else of its way.
    borne = "along" in c.frame.manner and c.layout.carrier(c.subject) in c.frame.patient
    for relation, place in c.frame.places:
        name = place_name(place)
        if borne and relation in ("over", "along"):
            continue
        if relation in ("off", "from"):
            found += off(c, place)
        elif relation in ("on", "in", "into", "against", "atop") and place.name != c.subject:
            found += _onto(c, relation, place)
        elif relation == "between" and place.kind == "landmark":
            found.append(spec("passes_over", c.subject, landmark=name))
        elif relation in ("over", "along") and place.kind == "support" and not place.part:
            found += _along_support(c, relation, place)
        elif relation == "near" and _begins_near(c, place):
            found.append(spec("contacts", c.subject, other=place.name, to_step=SPEC.start_steps))
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
        elif relation == "down" and descents(c.layout, c.subject):
            found += downstairs(c)
        elif relation in ("down", "object") and is_slope(c, place):
            found += [
                spec("contacts", c.subject, other=place.name, to_step=SPEC.start_steps + 10),
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
    if too_high(c.layout, c.frame, c.subject, "over", place):
        return []
    name, flies = place_name(place), c.frame.sense in _THROUGH_AIR
    mark = c.layout.state.landmark(name)
    if flies and mark is not None and mark.kind == "opening":
        by = spec("passes_over", c.subject, landmark=name, by=True)
        return [by, spec("passes_over", c.subject, landmark=name, negated=True)]
    # What rolls or slides "over the box" goes by it; what flies over it is above it.
    level = place.kind == "object" and not flies
    found = [spec("passes_over", c.subject, landmark=name, by=True if level else None)]
    if level and c.frame.sense in ("roll", "slide") and c.layout.state.object(name):
        # Over a thing is on it, and not only past it.
        found.append(spec("contacts", c.subject, other=name))
    if place.kind == "object" and c.frame.sense in ("drift", "float"):
        found.append(spec("side_of", c.subject, other=name, side="above"))
    if _clears(c, place):
        # Above it is not yet over it: it comes down behind it.
        found.append(spec("passes_over", c.subject, landmark=name, by=True))
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


def downstairs(c: Context) -> list[Spec]:
    """Down a flight of steps: to the lowest of them, or past it to the ground; or as many steps
    lower as are told, and no farther."""
    depths, told = descents(c.layout, c.subject), c.frame.steps
    # As a flight has no fewer steps for it, more than there are is more than can be.
    deep = 0.8 * (depths[told - 1] if told and told <= len(depths) else depths[-2:][0])
    if told is None and (steps := steps_below(c.layout, c.subject)):
        last = spec("contacts", c.subject, other=steps[-1])
        ground = spec("contacts", c.subject, other=c.layout.ground())
        return [any_of(last, ground), spec("falls", c.subject, drop=round(deep, 4))]
    if told is not None and told > len(depths):
        deep = told * depths[0]
    # Lower than it stood at first: what hops in place falls as well.
    found = [spec("moves", c.subject, distance=round(deep, 3), direction="down")]
    if told is None or told > len(depths) or not is_last(c):
        return found
    most = round(depths[told - 1] + 0.5 * depths[0], 3)
    return [*found, spec("moves", c.subject, distance=most, direction="down", negated=True)]


def lands_on(c: Context) -> str:
    """What it bounces on that nothing names: where it stands, unless it came off that."""
    here, gone = c.layout.base(c.subject), ("fall", "leave", "slip", "land")
    told = c.reading.frames[: c.index + 1]
    off = any(f.sense in gone or f.place("off", "from", "over") for f in told)
    return c.layout.ground() if off or here is None else here


def to_ground(c: Context) -> list[Spec]:
    """ "… down the stairs to the floor": it gets there."""
    place = c.frame.place("toward", "to", "until")
    if place is None or not is_ground(c, place):
        return []
    return [spec("contacts", c.subject, other=c.layout.ground())]


def _is_ramp(c: Context, place: Place) -> bool:
    support = c.layout.state.support(place.name)
    return support is not None and isinstance(support.shape, Ramp) and not place.part


def _uphill(c: Context, place: Place) -> list[Spec]:
    """Up a slope: on it, and higher than before."""
    climb = c.length(0.3, 0.02, 0.1)
    found = [
        spec("contacts", c.subject, other=place.name),
        spec("moves", c.subject, distance=climb, direction="up"),
    ]
    if any(f.place("off", "from") is not None for f in (c.frame, *c.later)):
        return found
    return [*found, spec("airborne", c.subject, seconds=0.25, negated=True)]


def is_slope(c: Context, place: Place) -> bool:
    """Whether the place is the ramp that carries the subject."""
    ramp = c.layout.ramp_below(c.subject)
    return ramp is not None and ramp.name == place.name and not place.part


def off(c: Context, place: Place) -> list[Spec]:
    """It comes off what it stands on."""
    carrier = c.layout.carrier(c.subject)
    raised = carrier is not None and carrier != c.layout.ground()
    if c.frame.partly_off and raised and not is_apart(c, place):
        return [spec("rests_on", c.subject, other=carrier)]
    if place.kind == "group":
        below = carrier if carrier is not None else landed_on(c)
        grounded = below is None or below == c.layout.ground()
        return [] if grounded else [spec("leaves", c.subject, other=below)]
    if is_ground(c, place):
        return [spec("contacts", c.subject, other=place.name, to_step=SPEC.start_steps)]
    if place.kind == "landmark" or place.name == c.subject:
        return []
    if is_apart(c, place):
        return farther_from(c, place)
    if _is_ramp(c, replace(place, part="")) and place.part in SLOPE_ENDS:
        # Off that end of the slope, and not off the other one.
        there = spec("passes_over", c.subject, landmark=place_name(place))
        return [spec("leaves", c.subject, other=place.name), there]
    stacked = carrier is not None and c.layout.state.object(carrier) is not None
    if not stacked or carrier == place.name:
        return [spec("leaves", c.subject, other=place.name)]
    # It stands on others that stand on it: it ends up carried by none of them.
    return [spec("rests_on", c.subject, other=place.name, negated=True)]


def is_apart(c: Context, place: Place) -> bool:
    """Whether a thing is neither touched at first nor told to be met before."""
    met = {p.name for f in c.earlier for _, p in f.places} | {
        n for f in c.earlier for n in (*f.patient, *f.agent) if n != c.subject
    }
    clear = 0.02  # m, 0.005..0.05: of a gap that is none by mistake
    gap = c.layout.gap(c.subject, place.name)
    return place.kind == "object" and place.name not in met and clear < gap < math.inf


def farther_from(c: Context, place: Place) -> list[Spec]:
    """It gets farther from a thing than it was, and never nearer."""
    name, far = place_name(place), c.length(0.5, 0.02, 0.2)
    apart = level(c.layout.position(c.subject) - c.layout.position(name))
    nearer = spec("moves", c.subject, distance=far, toward=name)
    if c.ways():
        return [nearer.opposite()]
    aimed = c.frame.place("toward", "at", "against") is not None or place.kind != "object"
    way = None if aimed or not c.layout.is_known(name) else named_way(apart)
    return [spec("moves", c.subject, distance=far, direction=way), nearer.opposite()]


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
    if place.kind == "group" and relation in ("into", "against"):
        return meets_one(c, place)
    if place.kind == "group":
        return _in_stack(c) if relation == "in" else []
    on_thing = place.kind == "object" and c.layout.carrier(c.subject) != name
    if on_thing and relation in ("on", "atop") and c.frame.sense == "jump" and is_last(c):
        # "Jumps onto the box": on top of it in the end, and not with its forefeet.
        over = spec("side_of", c.subject, other=name, side="above", at_end=True)
        return [spec("rests_on", c.subject, other=name), over]
    if relation == "atop":
        return [spec("reaches" if is_last(c) else "contacts", c.subject, other=name)]
    if relation in ("in", "into") and place.kind in ("object", "support") and is_container(name):
        drops = c.frame.sense in ("fall", "land", "throw", "kick", "jump", "fly", "bounce")
        if drops and is_last(c):
            return [spec("lands_in", c.subject, landmark=name)]
    if c.layout.carrier(c.subject) == place.name and relation == "on" and was_raised(c):
        return [spec("reaches", c.subject, other=place.name)]
    elsewhere = c.layout.carrier(c.subject) != place.name
    drops = c.frame.sense in ("fall", "throw", "jump", "descend")
    slides = elsewhere and c.frame.sense in ("slide", "roll", "move", "push", "slip", "drift")
    solid = not is_ground(c, place) and place.kind in ("object", "support")
    if (drops or slides) and relation in ("on", "atop") and solid and is_last(c):
        # "Drops onto the table" is not falling past its edge, nor "slides onto it" hitting it.
        return [spec("reaches", c.subject, other=name)]
    if not elsewhere and relation == "on":
        # Where it already is ("a ball on the grass rolls"): how it begins.
        return [spec("contacts", c.subject, other=place.name, to_step=SPEC.start_steps)]
    return [spec("contacts", c.subject, other=place.name)]


def meets_one(c: Context, place: Place) -> list[Spec]:
    """It touches one at least of a stack or a row."""
    hits = [spec("contacts", c.subject, other=name) for name in place.members if name != c.subject]
    return [any_of(*hits)] if hits else []


def _begins_near(c: Context, place: Place) -> bool:
    """ "Near the table edge", said first: it stands on the table, unless it lies on a stack."""
    carrier = c.layout.carrier(c.subject)
    stacked = carrier is not None and c.layout.state.object(carrier) is not None
    return place.kind == "support" and bool(place.part) and not c.earlier and not stacked


def _in_stack(c: Context) -> list[Spec]:
    """ "In a stack": it stands on the next lower one of the objects, else on its support."""
    below = c.layout.carrier(c.subject)
    return [spec("contacts", c.subject, other=below, to_step=SPEC.start_steps)] if below else []
