"""How far, how fast and when: what a clause says in numbers, or with "a little"."""

from __future__ import annotations

from physagent_studio.agent.rules.contract.specs import Context, Spec, spec
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.program import Clip

_TRAVELS = words_of("move slide drift roll push pull slip fly reverse dislodge kick")
_FALLS_ON = words_of("fall land bounce jump topple flip descend collapse leave float")
_HITS = words_of("hit knock knock_over crush")
_TURNS = words_of("spin turn turn_around rotate lean topple lose_balance")


def extents(c: Context) -> list[Spec]:
    """No farther than is said, as fast as is said, and not before it is said."""
    return [*_no_farther(c), *_as_fast(c), *_not_earlier(c), *_no_more_turned(c)]


def is_slight(c: Context) -> bool:
    """Whether only a little of it is told."""
    return "slight" in c.frame.manner


def _no_farther(c: Context) -> list[Spec]:
    """ "Slides 20 cm" is not sliding off the table; "slides a little" has an end as well."""
    if c.frame.sense not in _TRAVELS or c.frame.negated:
        return []
    going_on = _told_later(c, (_TRAVELS | _FALLS_ON) - {"reverse"})
    far = _most(c)
    if far is None or going_on or c.frame.place("off", "from") is not None:
        return []
    ways = [w for w in c.ways() if w not in ("up", "down")]
    way = ways[0] if len(ways) == 1 else None
    return [spec("moves", c.subject, distance=far, direction=way, negated=True)]


def _most(c: Context) -> float | None:
    if c.frame.distance is not None:
        return round(1.3 * c.frame.distance + 0.02, 3)
    return c.length(1.5, 0.08, 0.6) if is_slight(c) else None


def _as_fast(c: Context) -> list[Spec]:
    """ "At 2 m/s": about as fast; what also falls may well get faster."""
    said = c.frame.speed
    if said is None:
        return []
    falls = c.frame.sense in _FALLS_ON or _told_later(c, _FALLS_ON)
    falls |= c.frame.place("off", "from", "down") is not None
    high = None if falls else round(1.5 * said, 3)
    who = c.frame.agent[0] if c.frame.agent and c.frame.sense in _HITS else c.subject
    return [spec("speed_between", who, low=round(0.6 * said, 3), high=high)]


def _told_later(c: Context, senses: frozenset[str]) -> bool:
    """Whether a later clause says so, and does not deny it."""
    return any(f.sense in senses and not f.negated for f in c.later)


def _not_earlier(c: Context) -> list[Spec]:
    """ "After 1 second the mug tips over": until then it is still."""
    if c.frame.delay is None or c.earlier:
        return []
    steps = int(0.8 * c.frame.delay / Clip().step_seconds)
    return [spec("stays", c.subject, distance=0.05, tilt=15.0, to_step=steps)] if steps > 1 else []


def _no_more_turned(c: Context) -> list[Spec]:
    """ "Turns by 90 degrees", "rotates a bit"."""
    if c.frame.sense not in _TURNS - {"topple"} or _told_later(c, _FALLS_ON):
        return []
    most = 1.4 * c.frame.angle + 10.0 if c.frame.angle is not None else 100.0
    told = c.frame.angle is not None or is_slight(c)
    return [spec("rotates", c.subject, angle=round(most, 1), negated=True)] if told else []
