"""The outlines that things of known forms can have, for each angle of view.

Outlines of boxes in an orthographic view are zonogons, the sums of the shadows of three edges; see
Ziegler, "Lectures on Polytopes", 1995, chapter 7. Those of what is upright and round are the hulls
of level circles.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.knowledge import Usual


@dataclass(frozen=True, slots=True)
class FormSettings:
    """Which forms are tried, and how likely each is."""

    # 0..90: first, end and step of the angles below the level, at which things are looked at
    angles_deg: tuple[float, float, float] = (2.0, 90.0, 3.0)
    # 0..180: first, end and step of the directions in which the widths of boxes are taken
    widths_deg: tuple[float, float, float] = (0.0, 180.0, 10.0)
    # 0..370: the same, in which it is taken how far round outlines reach
    reaches_deg: tuple[float, float, float] = (6.0, 366.0, 12.0)
    yaw_step_deg: float = 7.5  # 2..15: of the turns of boxes
    lying_share: float = 0.7  # 0.4..0.95: of flat things that lie rather than stand
    side_ratio: float = 0.7  # 0.4..1: of a box's shorter level side to the longer, if unknown
    side_spread_log: float = 0.3  # 0.1..0.6: of that
    height_ratio: float = 0.6  # 0.2..1.5: of a box's height to its longer level side, if unknown
    height_spread_log: float = 0.5  # 0.2..1: of that
    known_spread_log: float = 0.2  # 0.05..0.4: of ratios of a kind, where no spread is known
    # 0.1..4: of the top of a round thing to its foot: bottles, cans, cups and bowls
    top_ratios: tuple[float, ...] = (0.3, 0.5, 0.75, 0.9, 1.0, 1.1, 1.3, 1.7, 2.3)
    # 0.02..20: the lowest and highest one over the radius of its foot: plates to bottles
    height_ratios: tuple[float, float] = (0.06, 11.0)
    # 0..3: of what is widest between: its radius, and how high it is
    belly_ratios: tuple[tuple[float, float], ...] = ((1, 0.55), (1, 0.75), (1.3, 0.4), (1.6, 0.4))
    wide_belly_ratios: tuple[float, float] = (1.15, 0.6)  # 0..3: the same, of wide tops
    belly_share: float = 0.4  # 0.1..0.7: of round things that are widest between foot and top
    rounded_ratio: float = 0.35  # 0.1..0.6: of the radius, by which a rounded edge is rounded
    rounded_share: float = 0.3  # 0.1..0.6: of round things with a rounded edge below, or above
    aspect_doubt: float = 1.5  # ratio, 1..3: of the spread of round kinds' heights over widths


FORM = FormSettings()
ANGLES = np.radians(np.arange(*FORM.angles_deg))
"""How far below the level things are looked at, rad: the angles that are tried."""
WAYS = np.radians(np.arange(*FORM.widths_deg))
"""Directions in which the widths of boxes are taken."""
ALL_WAYS = np.radians(np.arange(*FORM.reaches_deg))
"""Directions in which it is taken how far round outlines reach."""
Table = NDArray[np.float32]


def is_boxy(usual: Usual) -> bool:
    """Whether things of a kind are about as right-angled as a box, as cars are."""
    return _is_upright(usual) and (usual.drives or "box" in usual.shapes)


def is_round(usual: Usual) -> bool:
    """Whether things of a kind stand upright and are round from above."""
    round_ = usual.shapes[:1] in (("revolved",), ("cylinder",), ("frustum",))
    return _is_upright(usual) and round_ and not is_boxy(usual)


def _is_upright(usual: Usual) -> bool:
    return usual.known and usual.lies is None


def boxes_of(usual: Usual) -> tuple[Table, FloatArray]:
    """(F, A, W) logarithms of the widths of boxes of a kind, of mean 0, and log weights (F,)."""
    return _box_widths(usual.drives, usual.depth, usual.aspect, usual.flat)


def rounds_of(usual: Usual) -> tuple[Table, FloatArray]:
    """(F, A, W) how far round forms of a kind reach, over the mean, and log weights (F,)."""
    reaches, weights, aspects = _round_reaches()
    if usual.aspect is None:
        return reaches, weights
    middle, spread = usual.aspect
    off = (aspects - math.log(middle)) / (FORM.aspect_doubt * spread)
    return reaches, weights - 0.5 * off**2


@lru_cache(maxsize=8)
def _box_widths(
    drives: bool,
    depth: float | None,
    aspect: tuple[float, float] | None,
    flat: float | None,
) -> tuple[Table, FloatArray]:
    sides, weights = _sides(drives, depth, aspect, flat)
    yaw = np.radians(np.arange(0, 180, FORM.yaw_step_deg))[:, None, None]
    down, ahead = np.sin(ANGLES)[:, None], np.cos(ANGLES)[:, None]
    x, y = np.cos(WAYS), np.sin(WAYS)
    edges = (
        np.abs(np.cos(yaw) * x + np.sin(yaw) * down * y),
        np.abs(-np.sin(yaw) * x + np.cos(yaw) * down * y),
        np.abs(ahead * y)[None],
    )
    summed = sum(sides[:, k, None, None, None] * edge for k, edge in enumerate(edges))
    widths = np.log(summed).reshape(-1, len(ANGLES), len(WAYS))
    widths -= widths.mean(2, keepdims=True)
    return widths.astype(np.float32), np.repeat(weights, len(yaw))


def _sides(
    drives: bool,
    depth: float | None,
    aspect: tuple[float, float] | None,
    flat: float | None,
) -> tuple[FloatArray, FloatArray]:
    """Sides (F, 3) of boxes of a kind, the last one upright, and their log weights (F,)."""
    known = FORM.known_spread_log
    if flat is not None:
        thin, other, weights = _spread(
            (flat, FORM.height_spread_log), (FORM.side_ratio, FORM.side_spread_log)
        )
        one, stands = np.ones_like(thin), math.log((1 - FORM.lying_share) / 2)
        ways = ((one, other, thin), (one, thin, other), (other, thin, one))
        shares = (math.log(FORM.lying_share), stands, stands)
        return (
            np.concatenate([np.stack(way, 1) for way in ways]),
            np.concatenate([weights + share for share in shares]),
        )
    side = (depth, known) if depth else (FORM.side_ratio, FORM.side_spread_log)
    high = aspect or (FORM.height_ratio, FORM.height_spread_log)
    if depth == 1 and aspect is None and not drives:
        high = (1.0, known)
    across, tall, weights = _spread(side, high)
    return np.stack([np.ones_like(across), across, tall], 1), weights


def _spread(
    one: tuple[float, float], other: tuple[float, float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pairs of two ratios, each given with the spread of its logarithm, and their log weights."""
    off, away = (v.ravel() for v in np.meshgrid(np.linspace(-2, 2, 5), np.linspace(-2, 2, 9)))
    weights = -0.5 * (off**2 + away**2)
    return one[0] * np.exp(one[1] * off), other[0] * np.exp(other[1] * away), weights


@cache
def _round_reaches() -> tuple[Table, FloatArray, FloatArray]:
    """(F, A, W) how far round forms reach, log weights (F,), logs of heights over widths (F,).

    A form is a foot of radius 1, a top, and often a wider circle between; its edges may be rounded.
    """
    rows = [
        (top, tall, *belly, below, above * top, share, tall / (2 * max(1.0, top, belly[0])))
        for top in FORM.top_ratios
        for belly, share in _bellies(top)
        for tall in np.geomspace(*FORM.height_ratios, 22)
        for below in (0.0, FORM.rounded_ratio)
        for above in (0.0, FORM.rounded_ratio)
        if 2 * max(below, above * top) < tall
    ]
    top, tall, belly, at, below, above, share, aspect = np.array(rows).T[..., None, None]
    share = share * np.where(below > 0, FORM.rounded_share, 1 - FORM.rounded_share)
    share = share * np.where(above > 0, FORM.rounded_share, 1 - FORM.rounded_share)
    up = np.cos(ANGLES)[:, None] * np.sin(ALL_WAYS)
    circle = np.hypot(np.cos(ALL_WAYS), np.sin(ANGLES)[:, None] * np.sin(ALL_WAYS))
    reach = (1 - below) * circle + below * (1 + up)
    reach = np.maximum(reach, (top - above) * circle + (tall - above) * up + above)
    reach = np.maximum(reach, np.where(belly > 0, belly * circle + at * tall * up, -np.inf))
    return centred(reach).astype(np.float32), np.log(share.ravel()), np.log(aspect.ravel())


def _bellies(top: float) -> list[tuple[tuple[float, float], float]]:
    """What may be widest between a foot and a top: radius and place, none first, and its share."""
    wide = (FORM.wide_belly_ratios[0] * top, FORM.wide_belly_ratios[1])
    found = FORM.belly_ratios if top < 1 else (wide,)
    return [
        ((0.0, 0.0), 1 - FORM.belly_share),
        *((b, FORM.belly_share / len(found)) for b in found),
    ]


def centred(reach: FloatArray) -> FloatArray:
    """How far it reaches from its middle, over the mean."""
    x, y = np.cos(ALL_WAYS), np.sin(ALL_WAYS)
    for way in (x, y):
        high, low = int(way.argmax()), int(way.argmin())
        middle = (reach[..., high] - reach[..., low]) / (way[high] - way[low])
        reach = reach - middle[..., None] * way
    return reach / reach.mean(-1, keepdims=True)
