"""How fast a thing has to meet what it hits."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.contract.intents import Intent
from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.measures import UP, Layout, level, unit
from physagent_studio.agent.rules.schedule.scripts.task import TASK


@dataclass(frozen=True, slots=True)
class BlowSettings:
    """How chains of blows are looked at."""

    # count, 2..20: of things that hit one another, looked at for the first's speed
    max_links: int = 8
    sliding_ratio: float = 7 / 5  # 1..1.5: a ball slides off so much faster than it then rolls
    # ratio, 0.1..0.4: of its speed that a thing has at least after a blow at one like it
    min_kept_share: float = 0.2
    over_edge_s: float = 1.5  # s, 0.8..2: in which what is hit gets over the edge where it shall
    shoved_sizes: float = 0.6  # own sizes, 0.2..2: that a thing slides on that is hit
    away_sizes: float = 2.0  # own sizes, 1..4: the same of one that is knocked away
    rolled_sizes: float = 2.0  # own sizes, 0.5..5: that a ball rolls on that is hit
    # ratio, 1..2: over the speed that fells what does not slide away
    knock_ratio: float = 1.3
    # ratio, 1..2: over what is needed after a blow, for what is lost of it until the next one
    handing_on_ratio: float = 1.25


BLOW = BlowSettings()


def blow(layout: Layout, intent: Intent, links: int = BLOW.max_links) -> float:
    """Least speed with which a thing has to meet what it hits, so that all of that does its part.

    links: how many of those that hit one another in turn are looked at.
    """
    own = intent.name
    felled = (_knocking_speed(layout, own, other) for other in intent.fells)
    sent = (f for f in intent.frames if own in f.agent and f.direction == "off")
    away = {name for frame in sent for name in frame.patient}
    shoved = (_shoving_speed(layout, own, other, other in away) for other in intent.shoves)
    onward = (_handing_on(layout, own, one, links - 1) for one in intent.strikes if links > 1)
    rolled = (_rolling_speed(layout, own, other) for other in intent.hits)
    over = (_over_the_edge(layout, intent, one) for one in intent.strikes)
    return max((*felled, *shoved, *rolled, *onward, *over), default=0.0)


def to_the_middle(layout: Layout, intent: Intent) -> float:
    """Angle from the first of several things that stand together, and that it shall run into, to
    the middle of them, degrees; 0 where it would pass between them."""
    start, group = layout.position(intent.name), intent.together
    if not group or group[0] != intent.hits[0] or not all(layout.has(name) for name in group):
        return 0.0
    places = np.array([level(layout.position(name) - start) for name in group])
    aim, first = unit(places.mean(axis=0)), unit(places[0])
    across = np.array([-aim[1], aim[0], 0.0])
    own = layout.extent(intent.name, across)
    wide = [own + layout.extent(name, across) for name in group]
    if not np.any(np.abs(places @ across) < wide):
        return 0.0
    return math.degrees(math.atan2(float(np.cross(first, aim)[2]), float(first @ aim)))


def sent_off(arrives: float, slowing: float, distance: float) -> float:
    """Speed at the start of a way against a constant deceleration that leaves `arrives`."""
    return min(math.sqrt(arrives**2 + 2 * slowing * distance), TASK.max_speed_mps)


def _knocking_speed(layout: Layout, own: str, other: str) -> float:
    """Speed with which the other one is hit and is knocked over."""
    if layout.rolls(other):
        return 0.0
    at = min(layout.extent(own, UP) + 0.0, 0.6 * layout.height(other)) or 0.05
    width = layout.extent(other, unit(level(layout.position(other) - layout.position(own))))
    knock = mech.speed_to_knock(
        layout.mass(other), layout.height(other), width, layout.mass(own),
        layout.touch(own, other).restitution, max(at, 0.2 * layout.height(other)),
    )  # fmt: skip
    return BLOW.knock_ratio * knock


def _shoving_speed(layout: Layout, own: str, other: str, away: bool) -> float:
    """Speed with which the other one is hit and goes on visibly, or away from where it was."""
    if layout.rolls(other):
        return 0.0
    far = BLOW.away_sizes if away else BLOW.shoved_sizes
    after = math.sqrt(2 * _slowing(layout, other) * far * layout.size(other))
    return _to_hand_on(layout, own, other, after)


def _rolling_speed(layout: Layout, own: str, other: str) -> float:
    """Speed with which a ball is hit and is seen to roll on."""
    if not layout.rolls(other):
        return 0.0
    after = math.sqrt(2 * _slowing(layout, other) * BLOW.rolled_sizes * layout.size(other))
    return _to_hand_on(layout, own, other, after * BLOW.sliding_ratio)


def _handing_on(layout: Layout, own: str, struck: Intent, links: int) -> float:
    """Speed with which a thing is hit that shall then hit others as hard as they need it."""
    other, needed = struck.name, blow(layout, struck, links)
    if not needed:
        return 0.0
    aim = level(layout.position(struck.hits[0]) - layout.position(other))
    after = sent_off(needed, _slowing(layout, other), float(np.linalg.norm(aim)))
    sliding = BLOW.sliding_ratio if layout.rolls(other) else 1.0
    return _to_hand_on(layout, own, other, BLOW.handing_on_ratio * after * sliding)


def _over_the_edge(layout: Layout, intent: Intent, struck: Intent) -> float:
    """Speed of a blow after which the one that is hit gets over the edge of its table, and the one
    that hits it, as far as that is told of them; 0 where it is not."""
    own, other = intent.name, struck.name
    way = unit(level(layout.position(other) - layout.position(own)))
    touch, masses = layout.touch(own, other), (layout.mass(own), layout.mass(other))
    kept = max((masses[0] - touch.restitution * masses[1]) / sum(masses), BLOW.min_kept_share)
    needed = 0.0
    for one in (intent, struck):
        edge = layout.way_to_edge(other, way) if _comes_off(layout, one) else math.inf
        if not math.isfinite(edge):
            continue
        after = mech.speed_to_arrive(edge, BLOW.over_edge_s, _slowing(layout, one.name))
        sliding = BLOW.sliding_ratio if one is struck and layout.rolls(other) else 1.0
        speed = after / kept if one is intent else _to_hand_on(layout, own, other, after * sliding)
        needed = max(needed, speed)
    return needed


def _comes_off(layout: Layout, intent: Intent) -> bool:
    """Whether it is told to come off the support that carries it, by itself or by a blow."""
    base, carrier = layout.base(intent.name), layout.carrier(intent.name)
    places = (f.place("off", "from") for f in intent.frames if intent.name in f.patient)
    off = any(place is not None and place.name in (base, carrier) for place in places)
    return off and carrier != layout.ground()


def _slowing(layout: Layout, name: str) -> float:
    """Deceleration of what rolls or slides on what carries it, m/s²."""
    base = layout.carrier(name) or layout.ground()
    if layout.rolls(name):
        return mech.rolling_slowing(layout.touch(name, base).rolling)
    return mech.G * layout.friction(name, base)


def _to_hand_on(layout: Layout, own: str, other: str, after: float) -> float:
    """Speed of a blow that leaves the other one with the speed `after`, m/s."""
    mass = layout.mass(own)
    gained = (1 + layout.touch(own, other).restitution) * mass
    return after * (mass + layout.mass(other)) / gained
