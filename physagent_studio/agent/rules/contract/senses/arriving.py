"""Senses of coming to a place and leaving it."""

from __future__ import annotations

from physagent_studio.agent.rules.contract.senses.common import arrival, goes_aside, posture
from physagent_studio.agent.rules.contract.senses.remaining import is_container, is_last
from physagent_studio.agent.rules.contract.senses.whereabouts import is_ground, meets_one, off
from physagent_studio.agent.rules.contract.specs import (
    Context,
    Spec,
    any_of,
    before,
    spec,
)
from physagent_studio.agent.rules.scene.measures import place_name
from physagent_studio.language import Place


def reach(c: Context) -> list[Spec]:
    """Comes to a place; "before reaching" means that it does not get there."""
    place = c.frame.place("object", "on", "at", "toward", "in", "into") or _told_before(c)
    if place is None or place.kind == "group":
        return []
    name = place_name(place)
    main = c.earlier[-1] if c.earlier else None
    if c.frame.link == "before" and main is not None:
        if main.sense in ("stop", "settle", "stay", "rest", "slow"):
            several = [place_name(p) for r, p in c.frame.places if r == "object"] or [name]
            near = c.length(1.6, 0.1, 0.6)
            close = "close" in main.manner and len(several) == 1
            return [
                *(spec("stops_before", c.subject, before=one) for one in several),
                *([spec("stops", c.subject, near=name, distance=near)] if close else []),
            ]
        return []
    got = arrival(c, c.frame)
    if place.kind == "support" and not place.part and c.frame.link != "after":
        found = [spec("reaches", c.subject, other=name)]
        start = c.layout.carrier(c.subject)
        if start is not None and start != name and got is not None:
            found.append(before(spec("contacts", c.subject, other=start), got))
        return found
    return [got] if got is not None else []


def _told_before(c: Context) -> Place | None:
    """ "… toward the wall but stops before it gets there": the place that was told."""
    frames = [f for f in c.earlier if f.places]
    return frames[-1].place("toward", "at", "object", "on", "in", "into") if frames else None


def strike(c: Context) -> list[Spec]:
    """Touches a support, or gets to a landmark."""
    got = arrival(c, c.frame)
    return [got] if got is not None else []


def cross(c: Context) -> list[Spec]:
    """Passes a line, an edge or a thing."""
    place = c.frame.place("object", "over", "past", "along", "on", "in", "into", "between")
    if place is None and c.frame.place("through") is not None:
        return []
    if place is None or place.kind == "group":
        return []
    if is_ground(c, place):
        return [spec("moves", c.subject, distance=c.length(2.0, 0.2, 1.0))]
    over = c.frame.place("over", "past") is not None
    if place.kind == "object" and not place.part and not over:
        # "Passes the block" is going by it, and passing is not bumping into it.
        return [
            spec("passes_over", c.subject, landmark=place.name, by=True),
            spec("contacts", c.subject, other=place.name, negated=True),
        ]
    apart = [spec("contacts", c.subject, other=end, negated=True) for end in place.ends]
    return [spec("passes_over", c.subject, landmark=place_name(place)), *apart]


def enter(c: Context) -> list[Spec]:
    """Ends inside."""
    place = c.frame.place("object", "in", "into", "on", "toward")
    if place is None or place.kind == "group":
        return []
    if place.kind == "landmark":
        return [spec("lands_in", c.subject, landmark=place_name(place))]
    return [spec("contacts", c.subject, other=place.name)]


def land(c: Context) -> list[Spec]:
    """Comes down onto or into something, in a posture where one is said."""
    place = c.frame.place("on", "in", "into", "object", "toward", "at", "atop")
    found: list[Spec] = []
    if place is not None and place.members:
        found += meets_one(c, place)
    elif place is None or place.kind == "group":
        found.append(_on_something(c))
    elif place.kind == "landmark":
        found.append(spec("lands_in", c.subject, landmark=place_name(place)))
    elif c.frame.posture or (c.frame.place("atop") is not None and is_last(c)):
        found.append(spec("reaches", c.subject, other=place.name))
    elif place.kind in ("object", "support") and _is_inside(c, place):
        found.append(spec("lands_in", c.subject, landmark=place.name))
    elif place.kind == "object" and is_last(c) and any(f.sense == "jump" for f in c.earlier):
        # "Hops to the left and lands on the plate": it is up there in the end.
        found.append(spec("reaches", c.subject, other=place.name))
    else:
        found.append(spec("contacts", c.subject, other=place.name))
    beside = c.frame.place("near")
    if beside is not None and beside.kind == "object":
        found.append(spec("contacts", c.subject, other=place_name(beside), negated=True))
        if is_last(c):
            near = c.length(2.0, 0.1, 0.6)
            found.append(spec("stops", c.subject, near=place_name(beside), distance=near))
    if "hard" in c.frame.manner:
        found.append(spec("speed_between", c.subject, low=0.7))
    if "straight" in c.frame.manner:
        # "Lands in the same spot".
        found.append(goes_aside(c, c.length(1.0, 0.05, 0.3)).opposite())
    return [*found, *posture(c)]


def _on_something(c: Context) -> Spec:
    """It comes down: on the ground, or where it leapt from."""
    ground, below = c.layout.ground(), c.layout.carrier(c.subject)
    leaps = any(f.sense in ("jump", "rise", "bounce", "flip") for f in c.earlier)
    falls = any(f.sense in ("fall", "leave") or f.place("off", "from") for f in c.earlier)
    on_ground = spec("contacts", c.subject, other=ground)
    onto = next((p for f in c.earlier if f.sense == "jump" and (p := f.place("on", "atop"))), None)
    if onto is not None and onto.kind in ("object", "support") and onto.name != c.subject:
        # "Jumps onto the table and lands beside the jug": up there.
        return spec("contacts", c.subject, other=onto.name)
    if leaps and below == ground and is_last(c):
        # It touched the ground before it leapt, too.
        return spec("reaches", c.subject, other=ground)
    if not leaps or falls or below in (None, ground):
        return on_ground
    return any_of(on_ground, spec("reaches", c.subject, other=below))


def _is_inside(c: Context, place: Place) -> bool:
    """ "Lands in the box"."""
    within = c.frame.place("in", "into") == place
    return within and is_container(place.name) and is_last(c)


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
    on_ground = c.layout.carrier(c.subject) == c.layout.ground()
    if place is None or is_ground(c, place) or (place.kind == "group" and on_ground):
        return [spec("airborne", c.subject, seconds=0.12)]
    if place.kind == "landmark":
        return [spec("moves", c.subject, distance=c.length(0.5, 0.02, 0.2))]
    return off(c, place)


def miss(c: Context) -> list[Spec]:
    """Never touches it."""
    missed = [
        p
        for r, p in c.frame.places
        if r == "object" and p.kind not in ("landmark", "group") and p.name != c.subject
    ]
    marks = [p for r, p in c.frame.places if r == "object" and p.kind == "landmark"]
    others = (f for f in c.reading.frames if f is not c.frame and not f.negated)
    alone = not any(c.subject in f.patient + f.agent for f in others) and not c.frame.negated
    moved = [spec("moves", c.subject, distance=c.length(0.5, 0.02, 0.2))] if alone else []
    return [
        # Only what moves misses anything.
        *(moved if missed or marks else []),
        *(spec("contacts", c.subject, other=p.name, negated=True) for p in missed),
        *(_not_reached(c, p) for p in marks),
    ]


def _not_reached(c: Context, place: Place) -> Spec:
    """A goal is missed by not ending in it, a line by not crossing it."""
    inside = place.landmark_kind in ("opening", "area") or _is_opening(c, place)
    kind = "lands_in" if inside else "passes_over"
    return spec(kind, c.subject, landmark=place_name(place), negated=True)


def _is_opening(c: Context, place: Place) -> bool:
    mark = c.layout.state.landmark(place.name)
    return mark is not None and mark.kind in ("opening", "area")


def withdrawn(c: Context) -> list[Spec]:
    """What stood on it has nothing below it any more."""
    return [spec("airborne", c.subject, seconds=0.1)]


def lose_support(c: Context) -> list[Spec]:
    """Nothing carries it for a while."""
    return [spec("airborne", c.subject, seconds=0.1)]
