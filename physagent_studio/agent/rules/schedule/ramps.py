"""Down a slope: gravity does it, friction decides how far."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.agent.rules.contract.specs import sideways
from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.framing import FRAMING, free_way_from
from physagent_studio.agent.rules.scene.measures import WAYS, level, unit
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts import Task, turn_back
from physagent_studio.program.actions import Action, Directed
from physagent_studio.program.scene.state import Ramp


def slope_of(task: Task) -> float:
    """Slope of the ramp that carries it, rad."""
    ramp = task.layout.ramp_below(task.name)
    if ramp is None or not isinstance(ramp.shape, Ramp):
        return 0.0
    return math.atan2(ramp.shape.rise, ramp.shape.run)


def ways_ahead(task: Task) -> tuple[float, float]:
    """Way to the top edge where it stands on the flat part behind it, and way down the slope, m."""
    ramp = task.layout.ramp_below(task.name)
    if ramp is None or not isinstance(ramp.shape, Ramp):
        return 0.0, 0.3
    uphill = np.array([math.cos(ramp.shape.yaw), math.sin(ramp.shape.yaw), 0.0])
    ahead = float((task.layout.position(task.name) - np.array(ramp.shape.toe)) @ uphill)
    flat = max(ahead - ramp.shape.run, 0.0)
    return flat, max(ahead - flat, 0.02) / max(math.cos(slope_of(task)), 0.2)


def friction_for(task: Task) -> float | None:
    """Friction of the object that lets it run, or stops it where it shall; None: as it is."""
    ramp = task.layout.ramp_below(task.name)
    if ramp is None or task.layout.rolls(task.name) or task.wheels is not None:
        return None
    if isinstance(ramp.shape, Ramp) and ramp.shape.steps:
        return None
    slope = math.tan(slope_of(task))
    if _stops_on_it(task):
        wanted = _stopping_friction(task)
    elif task.intent.has("roll", "move", "reach", "turn_around", "slide", "drift", "descend"):
        wanted = 0.35 * slope
    else:
        return None
    # The simulation takes the geometric mean of both sides.
    own = task.layout.friction(ramp.name, ramp.name)
    return round(float(np.clip(wanted * wanted / max(own, 0.02), 0.005, 3.0)), 4)


def rolling_for(task: Task) -> float | None:
    """Resistance of wheels with which it stops on a slope where it shall, or slowly goes down it;
    None: as usual, or off any slope."""
    ramp = task.layout.ramp_below(task.name)
    if ramp is None or (isinstance(ramp.shape, Ramp) and ramp.shape.steps):
        return None
    if _stops_on_it(task):
        return round(min(_stopping_friction(task), 1.0), 4)
    slow_share = 0.7  # 0.3..0.95: of the pull of the slope that is used up
    if task.intent.manner("slow", "gentle"):
        return round(slow_share * math.tan(slope_of(task)), 4)
    max_share = 0.9  # 0.6..0.98: the same where it has to stop below: it has to set out at all
    wanted = min(_resistance_below(task), max_share * math.tan(slope_of(task)))
    least_ratio = 0.02  # 0.005..0.05: small wheels on a hard floor resist as much anyway
    return round(wanted, 4) if wanted > least_ratio else None


def _resistance_below(task: Task) -> float:
    """Resistance with which it comes to rest on the ground below the slope, before what stands

    there and within the picture; 0 where it shall hit something, leave or turn.
    """
    layout, ramp = task.layout, task.layout.ramp_below(task.name)
    downhill = layout.downhill(task.name)
    away = task.intent.has("leave", "turn_around", "reverse") or task.intent.hits
    away = away or task.intent.place("against", senses=("stop", "settle"))
    if ramp is None or not isinstance(ramp.shape, Ramp) or downhill is None or away:
        return 0.0
    toe, way = np.asarray(ramp.shape.toe, float), unit(level(downhill))
    # As it stands there, with its middle over the toe.
    there = toe + np.array([0.0, 0.0, layout.height(task.name) / 2])
    room = free_way_from(layout, task.name, there, way)
    drop = float(layout.position(task.name)[2] - there[2])
    run = abs(float((layout.position(task.name) - toe) @ way))
    return max(drop, 0.0) / max(FRAMING.good_share * room + run, 1e-3)


def _stops_on_it(task: Task) -> bool:
    """Whether it comes to rest on the slope: not "against the box", which stands before that."""
    halts = [f for f in task.intent.frames if f.sense in ("stop", "settle", "slow")]
    against = [p.name for f in halts for r, p in f.places if r == "against" and p.kind == "object"]
    beyond = any(task.layout.ramp_below(name) is None for name in against)
    return (bool(halts) and not beyond) or task.ends_short


def _stopping_friction(task: Task) -> float:
    """Friction that uses up the start and the height on the way: ½v² + g h = μ g (d + s cos)."""
    return _stopping(task)[1]


def starting_speed(task: Task) -> float:
    """Speed with which a thing that shall stop sets out: it is there in half of the clip."""
    return _stopping(task)[0]


def _stopping(task: Task) -> tuple[float, float]:
    """(speed, friction) of a slide that ends on the slope; the height before the top edge is
    not there yet to get it over the flat part, so the speed has to."""
    flat, slope = ways_ahead(task)
    said = any(frame.share is not None for frame in task.intent.frames)
    stop_share = 0.7  # 0.5..1: of the way down, where "near the lower end" is
    share = task.share if said and task.share is not None and task.ends_short else stop_share
    angle, way = slope_of(task), share * slope
    speed = least = float(np.clip(2 * (flat + way) / task.seconds(0.5), 0.1, 1.5))
    friction = 0.0
    for _ in range(8):
        energy = speed**2 / 2 + mech.G * math.sin(angle) * way
        friction = energy / (mech.G * (flat + math.cos(angle) * way))
        speed = min(max(least, 1.2 * mech.speed_to_stop(flat, friction)), 2.0)
    firm_ratio = 1.3  # 1.05..2: over the friction that just holds a thing there
    # On a slope that nearly bears it a thing slides on for ever, or not at all.
    if friction < (firm := firm_ratio * math.tan(angle)):
        friction = firm
        lost = firm * (flat + math.cos(angle) * way) - math.sin(angle) * way
        speed = min(math.sqrt(2 * mech.G * lost), 2.0)
    return speed, friction


def down_ramp(task: Task) -> list[Action]:
    """Runs down the ramp; turns, tips or drifts on the way where that is said."""
    downhill = task.layout.downhill(task.name)
    if downhill is None:
        return []
    stops = _stops_on_it(task)
    below = stops and _stops_at_the_foot(task)
    stops = stops and not below
    speed = starting_speed(task) if stops else max(0.15, 0.5 * task.layout.size(task.name))
    speed = speed if stops else max(speed, _over_plateau(task))
    flat = unit(level(downhill))
    slope = -math.degrees(math.asin(float(np.clip(-downhill[2], 0, 1))))
    way = act.toward_or_along(speed, vector=flat, elevation=slope)
    found: list[Action] = [act.push(task.name, way, duration=10, label="start")]
    if below:
        found.append(_braked_below(task))
    if task.intent.has("drift"):
        found.append(_drift(task))
    if task.intent.has("topple", "lose_balance"):
        found += _tip_at_bottom(task)
    if task.intent.has("turn_around", "reverse"):
        found += turn_back(task)
    return found


def _stops_at_the_foot(task: Task) -> bool:
    """Whether it is a ball, which no friction stops on the slope, and is told no other place."""
    places = [p for f in task.intent.frames if f.sense in ("stop", "settle") for _, p in f.places]
    rolls = task.layout.rolls(task.name) and task.wheels is None
    return rolls and not task.ends_short and all(p.part == "lower_end" for p in places)


def _braked_below(task: Task) -> Action:
    """What stops it once it is down, within its own size."""
    _, way = ways_ahead(task)
    rolled_share = 5 / 7  # of what a sliding thing would have, in a ball's way down
    fallen = rolled_share * mech.G * math.sin(slope_of(task)) * way
    force = act.against(max(fallen / task.layout.size(task.name), 0.2))
    when = act.on_contact(task.name, task.layout.ground())
    return act.push(task.name, force, start=0, when=when, duration=task.clip.steps, label="brake")


def _over_plateau(task: Task) -> float:
    """Speed that carries it over the flat part behind the top edge; 0 where it is on the slope."""
    ramp = task.layout.ramp_below(task.name)
    flat, _ = ways_ahead(task)
    if ramp is None or flat <= 0:
        return 0.0
    return 1.4 * mech.speed_to_stop(flat, task.layout.friction(task.name, ramp.name))


def _drift(task: Task) -> Action:
    """A light push across the slope."""
    across = sideways(task.name, task.layout)[1]
    force = act.toward_or_along(0.8, way=across, quantity="acceleration")
    return act.push(task.name, force, start=10, duration=40, label="drift")


def _tip_at_bottom(task: Task) -> list[Action]:
    """On the ground it is tipped over its side: a turn about the way it runs. No longer on its
    wheels, it scrapes along and is soon at rest."""
    downhill = task.layout.downhill(task.name)
    assert downhill is not None
    axis = unit(level(downhill))
    across = sideways(task.name, task.layout)[1]
    side = 1.0 if float(np.cross(axis, WAYS["up"]) @ WAYS[across]) > 0 else -1.0
    when = act.on_contact(task.name, task.layout.ground(), 8)
    steps = 25  # steps, 15..40: that tipping over takes
    rate = math.radians(90) / (steps * task.clip.step_seconds)
    grip = 0.4  # 0.2..0.8: friction of its side on the ground
    scraping = Directed(
        magnitude=round(grip * mech.G, 3), along="against_velocity", quantity="acceleration"
    )
    return [
        act.spin(task.name, axis * side, rate, duration=steps, when=when, label="tip"),
        act.push(task.name, scraping, duration=steps, when=when, label="scrape"),
    ]
