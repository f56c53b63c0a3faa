"""Ways that are told one after the other."""

from dataclasses import replace

from physagent_studio.agent.rules.contract.specs import Context, Spec, ways_of
from physagent_studio.agent.rules.scene.measures import are_opposite


def in_turn(c: Context, found: list[Spec]) -> list[Spec]:
    """ "Left, then right": the second way counts from where the first one ended, not from where it
    stood. Each has as much of the clip as the others."""
    legs = [f for f in c.earlier if f.sense in _LEGS and not f.negated]
    ways = [way for f in legs for way in ways_of(f.direction, f, c.subject, c.layout)[:1]]
    item = c.layout.state.object(c.subject)
    backed = any("backwards" in f.manner for f in legs)
    if item is None or (item.wheels is not None and not backed):
        # "Drives to the right and turns left" is one way with a bend.
        return found
    if not ways or c.frame.link != "then" or not are_opposite(ways[-1], next(iter(c.ways()), None)):
        return found
    others = [f for f in c.later if f.sense in _LEGS and f.direction and not f.negated]
    begins = round(len(ways) / (len(ways) + 1 + len(others)) * c.steps)
    return [
        replace(s, fields={**s.fields, "from_step": begins})
        if s.kind == "moves" and "direction" in s.fields and not s.fields.get("negated")
        else s
        for s in found
    ]


_LEGS = ("move", "slide", "roll", "push", "pull", "drift")
