"""Senses of motion."""

from __future__ import annotations

import math

from physagent_studio.agent.rules.contract.intents import brought_above, carries_the_others, met
from physagent_studio.agent.rules.contract.senses.common import (
    bent_path,
    comes_down,
    goes_aside,
    least_along,
    lies_in_the_end,
    manner,
    rolls,
    struck_before,
    travel,
)
from physagent_studio.agent.rules.contract.senses.extents import is_slight
from physagent_studio.agent.rules.contract.senses.in_turn import in_turn
from physagent_studio.agent.rules.contract.senses.turning import topple
from physagent_studio.agent.rules.contract.senses.whereabouts import (
    along,
    downstairs,
    landed_on,
    lands_on,
    to_ground,
    was_raised,
)
from physagent_studio.agent.rules.contract.senses.yielding import wind
from physagent_studio.agent.rules.contract.specs import (
    SPEC,
    Context,
    Spec,
    any_of,
    before,
    spec,
    ways_of,
)
from physagent_studio.agent.rules.scene.measures import level, named_way, place_name
from physagent_studio.agent.rules.scene.steps import descents, steps_below
from physagent_studio.language import Place
from physagent_studio.program.actions import Direction


def move(c: Context) -> list[Spec]:
    """Moves, slides, drifts, flies; what the wind moves and is held gives way to it."""
    item = c.layout.state.object(c.subject)
    held = item is not None and item.body.kind in ("soft", "cloth", "rope")
    if c.frame.cause == "wind" and held:
        return wind(c)
    return [*in_turn(c, travel(c)), *along(c), *manner(c), *bent_path(c), *_while_descending(c)]


def slide(c: Context) -> list[Spec]:
    """Moves along what it is on, and is not thrown through the air."""
    found = move(c)
    over = any(r in ("off", "from", "over", "down") or p.part for r, p in c.frame.places)
    leaves = c.frame.direction in ("off", "down", "up") or c.layout.carrier(c.subject) is None
    if over or leaves or comes_down(c) or _never_level(c):
        return found
    high = c.length(1.5, 0.2, 0.6)
    return [*found, spec("moves", c.subject, distance=high, direction="up", negated=True)]


def _never_level(c: Context) -> bool:
    """Whether what it is on is a slope, is taken away, or is itself moved."""
    withdrawn = any(f.sense in ("withdrawn", "lose_support") for f in c.reading.frames)
    carried = c.layout.state.object(c.layout.carrier(c.subject) or "") is not None
    return withdrawn or carried or c.layout.ramp_below(c.subject) is not None


def roll(c: Context) -> list[Spec]:
    """Moves on the ground; a ball turns while it does."""
    found = move(c)
    if c.layout.rolls(c.subject):
        found.append(spec("rotates", c.subject, angle=_least_roll(c)))
        if not comes_down(c):
            found.append(spec("airborne", c.subject, seconds=0.3, negated=True))
    elif c.layout.ramp_below(c.subject) is not None and not comes_down(c):
        uphill = c.frame.place("up") is not None or c.frame.direction == "up"
        found += _on_the_slope(c) if uphill else _down_the_slope(c)
    return found


def _least_roll(c: Context) -> float:
    """How far it turns at least as it rolls, degrees: less where the picture leaves little room."""
    most = 90.0  # 45..180: where there is room
    wide = 1.6  # radii, 1..2: of a way on which it may turn by so much, in radians
    ways: list[Direction] = [way for way in c.ways() if way not in ("up", "down")]
    if not ways or c.frame.places:
        return most
    room = min(least_along(c, wide * c.size, way) for way in ways)
    return min(most, round(math.degrees(2 * room / c.size), 0))


def _on_the_slope(c: Context) -> list[Spec]:
    """Upright and never far off the slope."""
    return [
        spec("upright", c.subject, tilt=50.0),
        spec("airborne", c.subject, seconds=0.12, negated=True),
    ]


def _down_the_slope(c: Context) -> list[Spec]:
    """Upright, along the slope and never far off it."""
    downhill = c.layout.downhill(c.subject)
    assert downhill is not None
    way = named_way(level(downhill))
    along_it = spec("moves", c.subject, distance=c.length(1.0, 0.05, 0.2), direction=way)
    below = spec("contacts", c.subject, other=c.layout.ground())
    upright, held = _on_the_slope(c)
    return [upright, along_it, held, *_not_off_the_side(c, way, below)]


def _not_off_the_side(c: Context, way: Direction, below: Spec) -> list[Spec]:
    """It does not come off the side of the slope before it is at the bottom."""
    aside = ("left", "right") if way in ("away", "toward_camera") else ("away", "toward_camera")
    far = c.length(1.6, 0.08, 0.3)
    off = any_of(*(spec("moves", c.subject, distance=far, direction=w) for w in aside))
    return [Spec("all_of", {}, (before(off, below).opposite(),))]


def _while_descending(c: Context) -> list[Spec]:
    """ "Drifts sideways while descending the ramp": on the slope, not after it."""
    near = (*c.reading.frames[c.index + 1 : c.index + 2],)
    told = any(f.sense in ("descend", "roll", "slide") and f.link == "while" for f in near)
    ways = [w for w in c.ways() if w not in ("up", "down")]
    if not told or not ways or c.layout.ramp_below(c.subject) is None:
        return []
    far = c.length(0.3, 0.02, 0.1)
    drift = any_of(*(spec("moves", c.subject, distance=far, direction=w) for w in ways))
    return [before(drift, spec("contacts", c.subject, other=c.layout.ground()))]


def curve(c: Context) -> list[Spec]:
    """The path bends to a side."""
    side = c.frame.direction if c.frame.direction in ("left", "right") else "either"
    angle = 150.0 if c.frame.path == "circle" else 10.0
    bent = spec("path_bends", c.subject, side=side, angle=angle)
    return [bent, spec("moves", c.subject, distance=c.length(0.5, 0.05, 0.3)), *along(c)]


def circle(c: Context) -> list[Spec]:
    """Goes round."""
    around = c.frame.place("object", "around")
    angle = 270.0 if around is not None and around.kind == "object" else 150.0
    return [spec("path_bends", c.subject, angle=angle), *along(c)]


def fly(c: Context) -> list[Spec]:
    """Goes through the air towards something."""
    if c.frame.negated and not c.frame.places:
        # "Falls over but does not fly away": it may well move.
        return [spec("airborne", c.subject, seconds=0.3)]
    return [*move(c), spec("airborne", c.subject, seconds=0.15)]


def fall(c: Context) -> list[Spec]:
    """Comes down; a thing that stands on the ground can only fall over."""
    stands = c.layout.has(c.subject) and not c.layout.is_raised(c.subject)
    off = c.frame.place("off", "from")
    raised = was_raised(c)
    if off is None and carries_the_others(c.layout, c.subject, c.frame):
        # Of a stack that comes down, what is at the bottom need not fall.
        return []
    if off is None and (_only_topples(c) or _lies_down(c)):
        return topple(c)
    # What was lifted comes down by less than what stood high to begin with.
    least = 0.015 if raised and stands else 0.03
    found = [spec("falls", c.subject, drop=_drop_off(c, off) or c.length(0.4, least, 0.1))]
    if "straight" in c.frame.manner or (
        c.frame.direction == "down" and c.frame.manner - {"skidding", "bodily"}
    ):
        found += _vertical(c)
    ways = [w for w in c.ways() if w not in ("down", "up")]
    if ways:
        far = c.length(0.5, 0.02, 0.2)
        found.append(any_of(*(spec("moves", c.subject, distance=far, direction=w) for w in ways)))
    told = c.earlier[-1].sense if c.earlier else ""
    if told == "lose_support":
        found += _straight_down(c, found[0])
    if told == "flip":
        found += _flipped_first(c, found[0])
    struck = [before(blow, found[0]) for blow in struck_before(c)[:1]]
    struck += _once_there(c, found[0])
    return [*found, *along(c), *manner(c), *struck, *lies_in_the_end(c)]


def _drop_off(c: Context, off: Place | None) -> float | None:
    """Of what falls off a table: its own size, as far as that is high; less is a tumble on it."""
    base = c.layout.base(c.subject) if off is not None else None
    if off is None or off.name != base or c.layout.state.object(c.subject) is None:
        return None
    foot = float(c.layout.position(c.subject)[2]) - c.layout.height(c.subject) / 2
    high = foot - c.layout.ground_height()
    return round(min(c.size, high / 2), 3) if high > c.size else None


def _only_topples(c: Context) -> bool:
    """Whether it stands on the ground, was not lifted off it and is no ball."""
    stands = c.layout.has(c.subject) and not c.layout.is_raised(c.subject) and not was_raised(c)
    return stands and not (rolls(c) or brought_above(c.layout, c.subject, c.frame))


def _lies_down(c: Context) -> bool:
    """ "The cup falls onto its side": on the table, where nothing had lifted it off."""
    stands = c.layout.carrier(c.subject) is not None and not was_raised(c)
    return c.frame.lies_down and stands and not rolls(c)


def _straight_down(c: Context, event: Spec) -> list[Spec]:
    """What loses its support falls where it is, and is not first moved aside."""
    aside = c.length(0.8, 0.05, 0.1)
    raised = spec("moves", c.subject, distance=aside, direction="up")
    drifted = before(goes_aside(c, aside), event)
    return [Spec("all_of", {}, (drifted.opposite(),)), raised.opposite()]


def _flipped_first(c: Context, event: Spec) -> list[Spec]:
    """ "Flips to the left and falls": the flip is told, and comes, first."""
    if c.layout.rolls(c.subject):
        return []
    flip = c.earlier[-1]
    ways = ways_of(flip.direction, flip, c.subject, c.layout)
    sides = [w for w in ways if w not in ("up", "down")] or [None]
    flips = any_of(*(spec("flips", c.subject, angle=80.0, direction=w) for w in sides))
    return [before(flips, event)] if flip.count is None else []


def _once_there(c: Context, event: Spec) -> list[Spec]:
    """ "As it passes the edge, it falls": the passing comes first."""
    for frame in c.earlier:
        if frame.link == "as" and frame.sense in ("pass", "cross", "reach", "hit"):
            place = frame.place("object", "over", "past")
            if place is not None and place.kind != "group":
                passed = spec("passes_over", c.subject, landmark=place_name(place))
                return [before(passed, event)]
    return []


def _vertical(c: Context) -> list[Spec]:
    # What stands on something has to come off it first, and that is not aside either.
    until = 16 if c.layout.carrier(c.subject) is None else 60
    return [goes_aside(c, c.length(0.3, 0.03, 0.1), until).opposite()]


def descend(c: Context) -> list[Spec]:
    """Comes down a slope or through the air; what stands on the ground can only fall over."""
    if not c.frame.places and _only_topples(c):
        return topple(c)
    found = [spec("falls", c.subject, drop=c.length(0.3, 0.02, 0.1))]
    return [*found, *along(c), *manner(c)]


def set_down(c: Context) -> list[Spec]:
    """Comes down gently onto what carries it then; what stands there already is raised first."""
    below = c.frame.place("on", "onto", "in", "into", "atop")
    if c.layout.carrier(c.subject) is None or (below is not None and below.kind == "landmark"):
        return descend(c)
    far = c.length(0.3, 0.015, 0.1)
    up = [] if was_raised(c) else [spec("moves", c.subject, distance=far, direction="up")]
    beside = c.frame.place("near")
    # Put down next to a thing it stands on what that stands on.
    about = beside.name if beside is not None and c.layout.has(beside.name) else c.subject
    carrier = below.name if below is not None else c.layout.carrier(about)
    inside = [one for one in along(c) if one.kind == "lands_in"]
    there = inside or [spec("reaches", c.subject, other=carrier)]
    ways = [way for way in c.ways() if way not in ("up", "down")]
    aside = [spec("moves", c.subject, distance=far, direction=way) for way in ways]
    if beside is not None and c.layout.is_known(place_name(beside)):
        close = c.length(1.6, 0.1, 0.6)
        there.append(spec("stops", c.subject, near=place_name(beside), distance=close))
    # Gently is said of how it is set down, not of how fast it goes along on the level.
    slowly = [one for one in manner(c) if one.kind != "speed_between"]
    return [*up, spec("falls", c.subject, drop=far), *there, *aside, *slowly]


def float_down(c: Context) -> list[Spec]:
    """Sinks through the air, never fast; what stands on the ground can only drift along."""
    if c.layout.has(c.subject) and not c.layout.is_raised(c.subject):
        return [*travel(c), spec("airborne", c.subject, seconds=0.2)]
    found = [
        spec("descends_slowly", c.subject, drop=c.length(0.3, 0.02, 0.1), speed=0.5),
        spec("airborne", c.subject, seconds=0.2),
    ]
    return [*found, *(s for s in along(c) if s.kind != "contacts")]


_ALOFT = ("rise", "stay", "spin", "turn")


def rise(c: Context) -> list[Spec]:
    """Goes up, and stays there unless more is said of it."""
    found = upward(c)
    if (over := c.frame.place("over")) is not None and over.kind == "object":
        found += along(c)
    further = any(f.sense not in _ALOFT for f in c.later)
    if further or c.frame.place("on", "onto", "in", "into", "over", "above") is not None:
        return found
    return [*found, spec("falls", c.subject, drop=c.length(0.3, 0.02, 0.2), negated=True)]


def upward(c: Context) -> list[Spec]:
    """It gets higher, as far as is said; off what it stood on, where that is named."""
    far = c.length(0.3, 0.02, 0.2)
    if c.frame.distance is not None:
        # "Is lifted 20 cm": about as high, and not to the ceiling.
        high = round(1.5 * c.frame.distance + 0.02, 3)
        raised = round(0.8 * c.frame.distance, 4)
        found = [
            spec("moves", c.subject, distance=raised, direction="up"),
            spec("moves", c.subject, distance=high, direction="up", negated=True),
        ]
    else:
        found = [spec("moves", c.subject, distance=least_along(c, far, "up"), direction="up")]
        if is_slight(c):
            high = c.length(1.5, 0.08, 0.6)
            found.append(spec("moves", c.subject, distance=high, direction="up", negated=True))
    found += [
        spec("moves", c.subject, distance=far, direction=w)
        for w in c.ways()
        if w not in ("up", "down")
    ]
    below = c.frame.place("off", "from")
    if below is None or below.kind in ("landmark", "group"):
        return found
    lifted = spec("contacts", c.subject, other=below.name, to_step=SPEC.start_steps)
    return [*found, lifted, spec("airborne", c.subject, seconds=0.12)]


def bounce(c: Context) -> list[Spec]:
    """Touches something and is free again, and gets the way that is told; "bounces back" from what
    it hit."""
    level_ways: list[Direction] = [way for way in c.ways() if way not in ("up", "down")]
    far = c.length(0.5, 0.02, 0.2)
    return [
        *_touching(c),
        *(
            spec("moves", c.subject, distance=least_along(c, far, way), direction=way)
            for way in level_ways
            if c.frame.direction != "backward"
        ),
    ]


def _touching(c: Context) -> list[Spec]:
    """What it bounces on, and how often."""
    struck = [f.patient[0] for f in c.earlier if f.sense == "hit" and c.subject in f.agent]
    if c.frame.direction == "backward" and struck:
        # That it touches it is demanded where it is told.
        return [spec("reverses", c.subject, angle=90.0)]
    if (flight := c.frame.place("down")) and descents(c.layout, c.subject):
        hops = spec("bounces", c.subject, other=flight.name)
        free = spec("airborne", c.subject, seconds=0.1)
        return [*downstairs(c), free if steps_below(c.layout, c.subject) else hops, *to_ground(c)]
    inside = c.frame.place("in", "into")
    if inside is not None and inside.kind != "group":
        # "Bounces into the box": it leaps, and is in it.
        return [spec("airborne", c.subject, seconds=0.1), *along(c)]
    off = c.frame.place("off", "on", "against", "from", "object")
    named = off.name if off is not None and off.kind not in ("landmark", "group") else None
    if off is not None and off.kind == "group" and c.earlier and (struck := met(c.earlier[-1])):
        # "Rolls into the rock, bounces off": off the rock.
        named = struck[0]
    other = named or landed_on(c) or lands_on(c)
    if c.frame.count is not None:
        return [spec("bounces", c.subject, other=other, times=c.frame.count), *_low(c)]
    thing = c.layout.state.object(other) is not None and c.layout.carrier(c.subject) is not None
    raised = c.layout.is_raised(c.subject) and c.layout.carrier(c.subject) != other
    if not thing and (raised or was_raised(c)) and c.layout.state.landmark(other) is None:
        # What comes down is in the air in any case: it has to be thrown back.
        return [spec("bounces", c.subject, other=other)]
    if not thing and (c.layout.is_raised(c.subject) or other == c.layout.ground()):
        free = spec("airborne", c.subject, seconds=0.1)
        return [spec("contacts", c.subject, other=other), free, *_low(c)]
    return [spec("contacts", c.subject, other=other), spec("leaves", c.subject, other=other)]


def _low(c: Context) -> list[Spec]:
    """ "Bounces gently": not high, where it is not said to come down from somewhere."""
    if not c.frame.manner & {"gentle", "slight"} or c.layout.is_raised(c.subject):
        return []
    high = c.length(2.0, 0.1, 0.5)
    return [spec("moves", c.subject, distance=high, direction="up", negated=True)]


def slip(c: Context) -> list[Spec]:
    """Begins to slide; off its support where it falls afterwards."""
    found = [spec("moves", c.subject, distance=c.length(0.4, 0.02, 0.1))]
    falls = any(f.sense == "fall" for f in c.later)
    base = c.layout.base(c.subject)
    if falls and base is not None and base != c.layout.ground():
        found.append(spec("leaves", c.subject, other=c.layout.carrier(c.subject) or base))
    return [*found, *along(c)]
