"""Large things that are models of themselves: a "car" beside a cup is a toy.

A name tells the usual size of the real thing. Where it is a metre or more, the thing may as
well be a toy, and what stands around it tells which: things on one picture are seldom farther
apart from the camera than a few times, so sizes that fit together say the same metres per pixel.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from physagent_studio.knowledge import Usual


@dataclass(frozen=True, slots=True)
class ToySettings:
    """When a large thing is taken for a model of itself."""

    min_large_m: float = 1.0  # 0.5..3: what is usually larger comes as a toy too
    size_m: float = 0.12  # 0.05..0.3: of a toy, as a hand holds it
    size_spread_log: float = 0.5  # 0.2..1: of toys
    depth_spread_log: float = 0.7  # 0.3..1.5: of the distances of things in one picture
    real_odds_log: float = math.log(2.0)  # 0..3: the real thing is twice as likely at first sight


TOY = ToySettings()


def as_toys(usual: Mapping[str, Usual], extents: Mapping[str, float]) -> dict[str, Usual]:
    """The usual sizes, with those of a toy where everything around says so.

    extents: how large each thing looks, pixels along its longer side. Things whose size a person
    has given (spread of at most .02) are never toys, and speak for the rest.
    """
    large = [
        n for n, u in usual.items() if u.known and u.metres >= TOY.min_large_m and u.spread > 0.02
    ]
    others = [n for n, u in usual.items() if u.known and n not in large]
    if not large or not others:
        return dict(usual)
    gain = TOY.real_odds_log
    for name in large:
        for other in others:
            gain += _odds(usual[name], extents[name], usual[other], extents[other])
    if gain >= 0:
        return dict(usual)
    toy = {n: replace(usual[n], metres=TOY.size_m, spread=TOY.size_spread_log) for n in large}
    return {**usual, **toy}


def _odds(one: Usual, seen: float, other: Usual, beside: float) -> float:
    """Logarithm of how much better two things fit as they are than with the one as a toy."""

    def misfit(metres: float, spread: float) -> float:
        off = math.log(metres / max(seen, 1.0)) - math.log(other.metres / max(beside, 1.0))
        variance = spread**2 + other.spread**2 + TOY.depth_spread_log**2
        return 1.5 * math.log1p(off**2 / variance / 1.5) + 0.5 * math.log(variance)

    return misfit(TOY.size_m, TOY.size_spread_log) - misfit(one.metres, one.spread)
