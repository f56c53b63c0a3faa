"""Senses of doing something to another thing."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_studio.agent.rules.contract.senses.common import (
    POSTURE,
    gone_over,
    hit_as_one,
    least_along,
    least_way,
    lies_in_the_end,
    siblings,
    sideways_fall,
    struck_before,
    struck_or_passed_on,
    touch,
    travel,
)
from physagent_studio.agent.rules.contract.senses.motion import move
from physagent_studio.agent.rules.contract.senses.whereabouts import along
from physagent_studio.agent.rules.contract.senses.yielding import collapse
from physagent_studio.agent.rules.contract.specs import (
    Context,
    Spec,
    any_of,
    before,
    spec,
)


@dataclass(frozen=True, slots=True)
class AwaySettings:
    """How far what is knocked away gets."""

    away_sizes: float = 1.5  # own sizes, 1..3: from its place to where a gap is seen between them


AWAY = AwaySettings()


def hit(c: Context) -> list[Spec]:
    """Two objects touch."""
    if c.frame.negated and not c.frame.agent:
        return _touched_by_anything(c)
    whole = hit_as_one(c, c.frame)
    found = [*(touch_one(c) if whole else touch(c)), *siblings(c)]
    if c.frame.agent and c.frame.manner & {"gentle", "slow"}:
        found.append(spec("speed_between", c.frame.agent[0], low=0.01, high=1.5))
    return [*found, *_still_stands(c)] or move(c)


def _still_stands(c: Context) -> list[Spec]:
    """ "Slides slowly until it touches the cup": it stands there as it went."""
    gone = [f for f in c.reading.frames[: c.index] if set(f.patient) & set(c.frame.agent)]
    told = [f for f in (*gone, c.frame) if f.manner & {"slow", "gentle"} and not f.negated]
    slid = any(f.sense in ("slide", "push", "pull", "move") and not f.agent for f in gone)
    return [
        spec("upright", agent, tilt=POSTURE.flat_deg)
        for agent in c.frame.agent
        if slid and told and not c.frame.negated and not c.layout.rolls(agent)
    ]


def _touched_by_anything(c: Context) -> list[Spec]:
    """ "The vase was not hit": by whatever there is but what it stands on and what stands on it."""
    near = {*c.frame.patient, c.layout.carrier(c.subject), *c.layout.above(c.subject)}
    others = [item.name for item in c.layout.state.objects if item.name not in near]
    found = [spec("contacts", c.subject, other=name) for name in others]
    return found or [spec("moves", c.subject, distance=0.05)]


def push(c: Context) -> list[Spec]:
    """The subject is moved; by an object where one is named."""
    # "Without disturbing it" leaves it where it is; it may well be touched.
    spared = c.frame.negated and c.frame.sense == "dislodge"
    touched = [] if spared else touch(c)
    moved = travel(c) if not c.frame.agent else _pushed_away(c)
    found = [*touched, *moved, *siblings(c), *along(c), *lies_in_the_end(c)]
    if touched and moved:
        found.append(before(touched[0], moved[0]))
    return found


def _pushed_away(c: Context) -> list[Spec]:
    ways = c.ways()
    softly = bool(c.frame.manner & {"gentle", "slight"})
    away = c.frame.direction == "off" and c.frame.place("off", "from") is None
    # At its own size it has just left its place; at half as much more there is a gap to be seen.
    far = c.length(AWAY.away_sizes, 0.08, 0.4) if away else c.length(0.7, 0.05, 0.15)
    distance = c.length(0.1, 0.01, 0.05) if softly else far
    if not ways:
        return [spec("moves", c.subject, distance=distance)]
    told_far = "far" in c.frame.manner
    least = {w: least_along(c, least_way(c), w) if told_far else distance for w in ways}
    return [any_of(*(spec("moves", c.subject, distance=least[w], direction=w) for w in ways))]


def kick(c: Context) -> list[Spec]:
    """Gets a speed in a moment."""
    found = [*move(c), spec("speed_between", c.subject, low=0.8), *lies_in_the_end(c)]
    high = c.frame.posture == "airborne"
    if not high:
        return found
    # As high as it is large: a hop is not seen to be one.
    risen = spec("moves", c.subject, distance=c.length(1.0, 0.02, 0.5), direction="up")
    return [*found, spec("airborne", c.subject, seconds=0.15), risen]


def crush(c: Context) -> list[Spec]:
    """The subject is deformed or breaks under another."""
    harmed = any_of(spec("deforms", c.subject, strain=0.05), spec("breaks", c.subject))
    touched = touch(c)
    # It may give way in the very moment of the blow, but not earlier.
    return [*touched, harmed, *(before(harmed, one).opposite() for one in touched)]


def touch_one(c: Context) -> list[Spec]:
    """The agent touches one at least of those that it acts on."""
    agents = [a for a in c.frame.agent if a not in c.frame.patient]
    hits = [spec("contacts", a, other=p) for a in agents for p in c.frame.patient]
    return [any_of(*hits)] if hits else []


def knock_over(c: Context) -> list[Spec]:
    """The subject falls over; after it was hit, where something hits it."""
    if c.layout.rolls(c.subject):
        return [*touch(c), spec("moves", c.subject, distance=c.length(0.5, 0.02, 0.2))]
    item = c.layout.state.object(c.subject)
    if item is not None and item.body.kind == "granular":
        return [*touch(c), *collapse(c), *sideways_fall(c)]
    if any(c.layout.carrier(name) in c.frame.patient for name in c.frame.patient):
        return [*touch_one(c), *collapse(c)]
    over = gone_over(c)
    if c.frame.agent and len(c.frame.patient) > 1:
        return [*struck_or_passed_on(c, over), *siblings(c), *sideways_fall(c)]
    struck = touch(c) or struck_before(c)
    found = [*touch(c), over, *siblings(c), *sideways_fall(c)]
    return [*found, before(struck[0], over)] if struck else found
