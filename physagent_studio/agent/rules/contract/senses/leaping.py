"""Senses of leaping: once or several times, up, down, or to a thing."""

from __future__ import annotations

from physagent_studio.agent.rules.contract.senses.common import keeps_standing
from physagent_studio.agent.rules.contract.senses.motion import upward
from physagent_studio.agent.rules.contract.senses.remaining import is_last
from physagent_studio.agent.rules.contract.senses.whereabouts import along, is_ground
from physagent_studio.agent.rules.contract.specs import Context, Spec, spec
from physagent_studio.agent.rules.scene.measures import place_name
from physagent_studio.agent.rules.scene.steps import descents
from physagent_studio.knowledge import kind_of


def jump(c: Context) -> list[Spec]:
    """Leaves the ground for a moment; what lives or leaps on the spot comes down as it stood."""
    kind = kind_of(c.subject)
    on_the_spot = not any(r in ("over", "onto", "into", "off") for r, _ in c.frame.places)
    alive = kind is not None and kind.is_alive
    upright = keeps_standing(c) if alive or on_the_spot else []
    found = [*upward(c), spec("airborne", c.subject, seconds=0.1), *along(c), *upright]
    below = c.layout.carrier(c.subject)
    if (c.frame.count or 0) > 1 and below is not None:
        # Of so many leaps each but the last is taken off from where it came down.
        found.append(spec("bounces", c.subject, other=below, times=(c.frame.count or 2) - 1))
    found += _leaps_to(c)
    onto = c.frame.place("on", "atop")
    if upright and onto is not None and not is_ground(c, onto) and is_last(c):
        # On its feet up there, and not hung over the edge.
        found.append(spec("upright", c.subject, tilt=20.0))
    if c.frame.direction == "down" and c.layout.is_raised(c.subject):
        # "Jumps down" is lower in the end than it stood.
        least = min(descents(c.layout, c.subject), default=c.length(0.5, 0.03, 0.2))
        found.append(spec("moves", c.subject, distance=round(0.8 * least, 3), direction="down"))
    return found


def _leaps_to(c: Context) -> list[Spec]:
    """ "Hops over to the box": nearer to it, and near it in the end, where nothing else is told."""
    aim = c.frame.place("toward", "at", "near")
    if aim is None or is_ground(c, aim) or aim.name == c.subject or aim.kind == "group":
        return []
    found = [spec("moves", c.subject, distance=c.length(0.5, 0.02, 0.2), toward=place_name(aim))]
    near = c.length(2.0, 0.1, 0.6)
    return (
        [*found, spec("stops", c.subject, near=place_name(aim), distance=near)]
        if is_last(c)
        else found
    )
