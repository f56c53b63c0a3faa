"""Senses of wind, and of what bends, sways, breaks and spreads."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_studio.agent.rules.contract.intents import carries_the_others
from physagent_studio.agent.rules.contract.senses.common import (
    keeps_standing,
    quality,
    sideways_fall,
    touch,
)
from physagent_studio.agent.rules.contract.senses.whereabouts import along
from physagent_studio.agent.rules.contract.specs import (
    Context,
    Spec,
    any_of,
    apart,
    over_way,
    spec,
)
from physagent_studio.agent.rules.scene.measures import place_name
from physagent_studio.language import EventFrame
from physagent_studio.program.scene.bodies import Cloth


@dataclass(frozen=True, slots=True)
class YieldingSettings:
    """When what sways does so."""

    wobble_share: float = 0.5  # 0.3..0.7: of the clip, for what wobbles before it falls over
    # share, 0.01..0.1: of its size, that may still be off when it sprang back: it also sags
    left_strain: float = 0.08


YIELDING = YieldingSettings()


def wind(c: Context) -> list[Spec]:
    """The air moves it: it sways, bends or goes along."""
    # What is rooted or hangs only gives way; what stands free is seen to go along.
    item = c.layout.state.object(c.subject)
    gives = item is not None and item.body.kind in ("soft", "cloth", "rope")
    far = c.length(0.03, 0.01, 0.3) if gives else c.length(0.3, 0.02, 0.5)
    ways = c.ways() or (None,)
    moved = [spec("moves", c.subject, distance=far, direction=w) for w in ways]
    toward = c.frame.place("toward")
    if toward is not None and toward.kind != "group" and toward.name != c.subject:
        moved = [spec("moves", c.subject, distance=far, toward=place_name(toward))]
    if any(f.sense in ("sway", "bend") or f.manner & {"rhythmic"} for f in c.reading.frames):
        bent = [spec("sways", c.subject, amplitude=2.0), spec("deforms", c.subject, strain=0.03)]
        return [any_of(*moved, *bent), *quality(c)]
    return [any_of(*moved), *quality(c), *along(c)]


def sway(c: Context) -> list[Spec]:
    """Moves to and fro; what falls over afterwards does so by half of the clip."""
    until = round(YIELDING.wobble_share * c.steps) if _falls_afterwards(c) else None
    seen = spec("sways", c.subject, amplitude=3.0, cycles=1.0, to_step=until)
    return [seen, *_stands(c), *([] if until else quality(c))]


def _falls_afterwards(c: Context) -> bool:
    """ "Wobbles, then topples", by itself: the fall is no sway."""
    struck = any(c.subject in f.patient and f.agent for f in c.reading.frames)
    stands = c.layout.has(c.subject) and c.layout.carrier(c.subject) is not None
    over = any(
        (f.sense == "topple" or (f.sense == "fall" and stands) or _goes_off(f)) and not f.negated
        for f in c.later
    )
    return over and not struck and not c.frame.negated and not c.layout.rolls(c.subject)


def _goes_off(frame: EventFrame) -> bool:
    return frame.sense in ("roll", "slide", "slip") and frame.place("off", "from") is not None


def bend(c: Context) -> list[Spec]:
    """Changes its shape or leans, and does not fall over."""
    leans = any_of(spec("deforms", c.subject, strain=0.02), spec("rotates", c.subject, angle=5.0))
    return [leans, *_stands(c)]


def _stands(c: Context) -> list[Spec]:
    """It does not fall over, which is nothing to ask of a flag: it droops when the wind ebbs."""
    item = c.layout.state.object(c.subject)
    held = isinstance(item.body, Cloth) and item.body.pinned if item is not None else ""
    return [] if held in ("left", "right") else keeps_standing(c)


def lean(c: Context) -> list[Spec]:
    """Tilts without falling over."""
    onto = c.frame.place("against", "on")
    if onto is not None and onto.kind in ("object", "support") and onto.name != c.subject:
        # In the end beside what it leans against, and touching it.
        near = spec("stops", c.subject, near=place_name(onto), distance=round(c.size, 3))
        tilted = spec("rotates", c.subject, angle=10.0)
        return [tilted, spec("contacts", c.subject, other=place_name(onto)), near]
    ways = [
        w
        for w in (over_way(c.frame, c.subject, c.layout), *c.ways())
        if w not in (None, "up", "down")
    ]
    if ways and not c.layout.rolls(c.subject):
        return [spec("flips", c.subject, angle=10.0, direction=ways[0])]
    return [spec("rotates", c.subject, angle=10.0)]


def collapse(c: Context) -> list[Spec]:
    """Comes down and loses its shape; of several things, those come down that stand on others."""
    if len(c.frame.patient) > 1:
        on_ground = c.layout.has(c.subject) and not c.layout.is_raised(c.subject)
        if on_ground or carries_the_others(c.layout, c.subject, c.frame):
            return []
        return [
            spec("falls", c.subject, drop=c.length(0.3, 0.02, 0.1)),
            *sideways_fall(c),
            *_off_the_top(c),
            *_slowly(c),
        ]
    gone = any_of(
        spec("deforms", c.subject, strain=0.1),
        spec("breaks", c.subject),
        spec("spreads", c.subject, factor=1.3),
    )
    return [spec("falls", c.subject, drop=c.length(0.1, 0.01, 0.1)), gone, *_slowly(c)]


def _off_the_top(c: Context) -> list[Spec]:
    """What was on top of a stack that comes down does not lie on what it stood on."""
    below = c.layout.carrier(c.subject)
    if below not in c.frame.patient or c.layout.above(c.subject):
        return []
    return [spec("leaves", c.subject, other=below)]


def _slowly(c: Context) -> list[Spec]:
    """No faster than one can follow, where that is said."""
    gently = c.frame.manner & {"slow", "gentle"}
    return [spec("speed_between", c.subject, low=0.01, high=1.0)] if gently else []


def break_apart(c: Context) -> list[Spec]:
    """At least one of its joints lets go, where it gets to if that is said."""
    onto = [s for s in along(c) if s.kind == "contacts"]
    return [*touch(c), spec("breaks", c.subject), *onto]


def spread(c: Context) -> list[Spec]:
    """Covers more ground, towards where it is said."""
    ways = [w for w in c.ways() if w not in ("up", "down")]
    item = c.layout.state.object(c.subject)
    away = apart(c.frame, c.subject, c.layout)
    if item is not None and item.body.kind == "rigid":
        # "The marbles scatter": away from one another, each as it is.
        way = {"direction": away[0]} if away and not c.frame.agent else {}
        return [spec("moves", c.subject, distance=c.length(0.5, 0.05, 0.3), **way)]
    found = [spec("spreads", c.subject, factor=1.3)]
    if ways:
        distance = c.length(0.15, 0.02, 0.1)
        found.append(
            any_of(*(spec("moves", c.subject, distance=distance, direction=w) for w in ways))
        )
    return found


def deform(c: Context) -> list[Spec]:
    """Loses its shape; by what is said to do it."""
    return [*touch(c), spec("deforms", c.subject, strain=0.05)]


def recover(c: Context) -> list[Spec]:
    """ "Is squeezed and springs back": nearly nothing of it is left in the end."""
    left = spec("deforms", c.subject, strain=YIELDING.left_strain, at_end=True, negated=True)
    return [left]
