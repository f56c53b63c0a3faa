"""What is said beside the verb, whatever the verb is: how far, on which side, through what."""

from __future__ import annotations

from physagent_studio.agent.rules.contract.senses.extents import extents
from physagent_studio.agent.rules.contract.senses.remaining import is_last
from physagent_studio.agent.rules.contract.senses.whereabouts import is_ground
from physagent_studio.agent.rules.contract.specs import (
    SPEC,
    Context,
    Spec,
    any_of,
    spec,
)
from physagent_studio.agent.rules.scene.measures import place_name
from physagent_studio.language import Place

SIDES = {
    "behind": "behind", "in_front": "in_front", "left_of": "left", "right_of": "right",
    "under": "under",
}  # fmt: skip
"""Relations to a thing that are sides of it."""
_ENDING = ("fall", "land", "stop", "settle", "rest", "be", "end", "stay", "reach", "topple")
"""Senses that say where something is in the end; others only say where it gets."""


def beside(c: Context) -> list[Spec]:
    """The demands that do not depend on the sense of the verb."""
    return [
        *_beginning(c),
        *_sides(c),
        *_share(c),
        *_through(c),
        *_around(c),
        *extents(c),
        *_alone(c),
    ]


def _beginning(c: Context) -> list[Spec]:
    """ "The ball behind the box rolls …"."""
    rows = [(r, p) for r, p in c.frame.begins if r in SIDES and _is_thing(c, p)]
    return [
        spec("side_of", c.subject, other=place_name(p), side=SIDES[r], to_step=SPEC.start_steps)
        for r, p in rows
    ]


def _sides(c: Context) -> list[Spec]:
    found: list[Spec] = []
    for relation, place in c.frame.places:
        if relation not in SIDES or not _is_thing(c, place):
            continue
        if relation == "in_front" and c.frame.sense in ("stop", "settle"):
            # "Stops in front of the cup" is before it gets there, from wherever it comes.
            continue
        describes = c.frame.link == "which" and c.frame.sense == "rest"
        first = (c.frame.sense in ("be", "hang", "stack") or describes) and not c.earlier
        half = place.part == "center" and is_last(c)
        ends = (half or c.frame.sense in _ENDING) and not first
        found.append(
            spec(
                "side_of", c.subject, other=place_name(place), side=SIDES[relation],
                at_end=ends or None, to_step=SPEC.start_steps if first else None,
            )
        )  # fmt: skip
    return found


def _is_thing(c: Context, place: Place) -> bool:
    """Whether a place has sides: not the ground, and not the subject itself."""
    return place.kind != "group" and place.name != c.subject and not is_ground(c, place)


def _share(c: Context) -> list[Spec]:
    """ "Halfway down the ramp": of the way that this clause speaks of."""
    if c.frame.share is None:
        return []
    place = c.frame.extent
    if place is None or place.name == c.subject:
        return []
    low, high = c.frame.share
    return [spec("covers", c.subject, other=place_name(place), low=low, high=high)]


def _alone(c: Context) -> list[Spec]:
    """ "Only the small ball moves": nothing else does."""
    if not c.frame.only or c.frame.agent or c.frame.sense not in ("move", "roll", "slide", "drift"):
        return []
    told = {n for f in c.reading.frames for n in (*f.patient, *f.agent)}
    others = [o.name for o in c.layout.state.objects if o.name not in told]
    return [spec("stays", name, distance=0.05, tilt=15.0) for name in others]


def _around(c: Context) -> list[Spec]:
    """ "Rolls around the plate": along a bent path, on three sides of it at least."""
    found: list[Spec] = []
    circles = c.frame.sense == "circle"
    relations = ("around", "object") if circles else ("around",)
    for relation, place in c.frame.places:
        if relation not in relations or not _is_thing(c, place) or place.kind == "support":
            continue
        left, right, behind, front = (
            spec("side_of", c.subject, other=place_name(place), side=side)
            for side in ("left", "right", "behind", "in_front")
        )
        # What goes round a thing does not bump into it.
        clear = spec("contacts", c.subject, other=place_name(place), negated=True)
        if place.kind == "object":
            found.append(clear)
        if circles:
            found += [left, right, behind, front]
            continue
        across = Spec("all_of", {}, (left, right, any_of(behind, front)))
        along = Spec("all_of", {}, (behind, front, any_of(left, right)))
        found += [any_of(across, along), spec("path_bends", c.subject, angle=30.0)]
    return found


def _through(c: Context) -> list[Spec]:
    """Through an opening or over an area."""
    marks = [p for r, p in c.frame.places if r == "through" and p.kind == "landmark"]
    return [spec("passes_over", c.subject, landmark=place_name(mark)) for mark in marks]
