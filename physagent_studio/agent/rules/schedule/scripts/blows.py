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
    rolled_sizes: float = 2.0  # own sizes, 0.5..5: that a ball rolls on that is hit


BLOW = BlowSettings()


def blow(layout: Layout, intent: Intent, links: int = BLOW.max_links) -> float:
    """Least speed with which a thing has to meet what it hits, so that all of that does its part.

    links: how many of those that hit one another in turn are looked at.
    """
    own = intent.name
    felled = (_knocking_speed(layout, own, other) for other in intent.fells)
    shoved = (_shoving_speed(layout, own, other) for other in intent.shoves)
    onward = (_handing_on(layout, own, one, links - 1) for one in intent.strikes if links > 1)
    rolled = (_rolling_speed(layout, own, other) for other in intent.hits)
    return max((*felled, *shoved, *rolled, *onward), default=0.0)


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
    return 1.3 * knock


def _shoving_speed(layout: Layout, own: str, other: str) -> float:
    """Speed with which the other one is hit and goes on visibly."""
    if layout.rolls(other):
        return 0.0
    after = math.sqrt(2 * _slowing(layout, other) * 0.6 * layout.size(other))
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
    return _to_hand_on(layout, own, other, after * sliding)


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
