"""Senses of turning and falling over."""

from __future__ import annotations

from physagent_studio.agent.rules.contract.senses.common import (
    arrival,
    gone_over,
    posture,
    siblings,
    sideways_fall,
    struck_before,
    struck_or_passed_on,
    touch,
)
from physagent_studio.agent.rules.contract.senses.whereabouts import along
from physagent_studio.agent.rules.contract.specs import Context, Spec, any_of, before, spec


def topple(c: Context) -> list[Spec]:
    """Falls over, onto its side where that is said."""
    if c.layout.rolls(c.subject):
        return [spec("moves", c.subject, distance=c.length(0.5, 0.02, 0.2))]
    over = gone_over(c)
    found = [over, *sideways_fall(c)]
    if c.frame.agent and len(c.frame.patient) > 1:
        # "The first domino topples the others": one of them, which topples the next.
        found += [one for one in struck_or_passed_on(c, over) if one is not over]
    else:
        struck = touch(c) or struck_before(c)
        found += touch(c)
        if struck:
            found.append(before(struck[0], over))
    on = c.frame.place("on", "atop", "against")
    if on is not None and on.kind == "support":
        found.append(spec("reaches", c.subject, other=on.name))
    elif on is not None and on.kind == "object" and on.name != c.subject:
        found.append(spec("contacts", c.subject, other=on.name))
    toward = c.frame.place("toward")
    if toward is not None and toward.kind == "object" and toward.name != c.subject:
        far = c.length(0.25, 0.02, 0.2)
        found.append(spec("moves", c.subject, distance=far, toward=toward.name))
    found += siblings(c)
    return [*found, *(s for s in along(c) if s.kind in ("leaves", "rests_on"))]


def lose_balance(c: Context) -> list[Spec]:
    """Tilts."""
    return [spec("rotates", c.subject, angle=20.0)]


def flip(c: Context) -> list[Spec]:
    """Turns over about a level axis; a number says how often."""
    times = c.frame.count
    angle = 80.0 if times is None else 360.0 * times - 210.0
    ways = [w for w in c.ways() if w not in ("up", "down")]
    flips = any_of(*(spec("flips", c.subject, angle=angle, direction=w) for w in ways or [None]))
    if c.layout.rolls(c.subject):
        return [spec("rotates", c.subject, angle=angle)]
    found = [flips, *(s for s in along(c) if s.kind != "passes_over")]
    if times is not None:
        found.append(spec("flips", c.subject, angle=360.0 * times + 180.0, negated=True))
    if c.frame.posture == "airborne":
        found.append(before(flips, spec("contacts", c.subject, other=c.layout.ground())))
    return found


def spin(c: Context) -> list[Spec]:
    """Turns about itself."""
    turns = spec("rotates", c.subject, angle=_least_turn(c, 180.0), **_about(c))
    told = any(f.negated or f.sense == "stay" for f in c.later)
    if c.frame.posture == "still" and not told:
        # "Spins on the spot".
        aside = spec("moves", c.subject, distance=c.length(0.5, 0.03, 0.2))
        return [turns, aside.opposite()]
    return [turns, *along(c)]


def _about(c: Context) -> dict[str, object]:
    """The upright axis, of what spins where it stands: falling over is no spinning."""
    aloft = c.layout.carrier(c.subject) is None
    thrown = any(f.sense in ("fly", "throw", "kick", "jump", "fall", "flip") for f in c.earlier)
    return {} if aloft or thrown or c.layout.rolls(c.subject) else {"axis": (0.0, 0.0, 1.0)}


def _least_turn(c: Context, plain: float) -> float:
    """How far it turns at least, degrees: as is said, by itself or so often; else `plain`."""
    if c.frame.angle is not None:
        return round(0.8 * c.frame.angle, 1)
    if c.frame.count is not None:
        return 360.0 * c.frame.count - 60.0
    return 5.0 if "slight" in c.frame.manner else plain


def turn(c: Context) -> list[Spec]:
    """Turns, without saying how."""
    return [spec("rotates", c.subject, angle=_least_turn(c, 30.0)), *posture(c)]


def turn_around(c: Context) -> list[Spec]:
    """Faces another way than before."""
    if c.layout.rolls(c.subject):
        return reverse(c)
    angle = _least_turn(c, 120.0)
    return [spec("rotates", c.subject, angle=angle, axis=(0.0, 0.0, 1.0))]


def _blow_before(c: Context) -> list[Spec]:
    """ "They collide and each rolls back": the blow that the clause before tells of."""
    told = c.earlier[-1] if c.earlier else None
    return struck_before(c) if told is not None and told.sense == "hit" else []


def reverse(c: Context) -> list[Spec]:
    """Goes back where it came from, or another way; first the way that is said."""
    times = c.frame.count
    # What turns back by itself comes back along its way; off what it hits it may go anywhere.
    angle = 90.0 if (blow := _blow_before(c)) or (times or 1) != 1 else 135.0
    back = spec("reverses", c.subject, angle=angle, times=times if times != 1 else None)
    ways = [w for w in c.ways() if c.frame.direction in ("left", "right", "away")]
    if ways:
        far = c.length(0.5, 0.02, 0.2)
        return [before(spec("moves", c.subject, distance=far, direction=ways[0]), back)]
    if blow:
        return [back, before(blow[0], back)]
    following = c.reading.frames[c.index + 1 : c.index + 2]
    if following and following[0].link == "after" and following[0].sense == "reach":
        reached = arrival(c, following[0])
        return [back, before(reached, back)] if reached is not None else [back]
    return [back]
