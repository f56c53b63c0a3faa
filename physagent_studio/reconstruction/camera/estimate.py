"""The camera from the picture: where the horizon is, and how sure that is.

Several cues vote on the row of the horizon and the focal length: edges of right-angled things,
circles seen as ellipses, things of known size that stand at different depths, what stands on the
ground lies below it, and the way people hold cameras. The answer is the best row
and the spread of the votes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.camera import right_angles
from physagent_studio.reconstruction.camera.outlines import Outline
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.switches import at_work


@dataclass(frozen=True, slots=True)
class PriorSettings:
    """What is expected of a camera before the picture is looked at."""

    pitch_rad: float = math.radians(9.0)  # 0..0.5: people look down a little
    pitch_spread_rad: float = math.radians(8.0)  # 0.05..0.5: a hand's tilt, about that
    above_share: float = 0.15  # 0.02..0.4: of pictures that are taken from above, however steeply
    # 0.5..1.5: what lies (tools, cutlery, keys) is looked at from above, at 35 to 90 degrees
    lying_pitch_rad: float = math.radians(58.0)
    lying_spread_rad: float = math.radians(20.0)  # 0.1..0.6: about that
    eye_level_m: float = 0.7  # 0.2..2: above what is looked at, between a hand's breadth and eyes
    eye_level_spread_log: float = 0.9  # 0.3..2: of that height, from a table top to the ground
    normal_lens_mm: float = 50.0  # 35..60: photos whose edges tell it have 36 to 107, 62 mid
    film_diagonal_mm: float = 43.27  # 43..43.5: of 35 mm film, for which that lens is meant
    focal_spread_log: float = 0.4  # 0.1..1: of focal lengths about the normal one
    shortest_focal_log: float = -0.8  # -2..0: of the shortest one tried, over the normal one
    longest_focal_log: float = 1.1  # 0..2: of the longest
    # 0.2..0.8: off the best tilt, beyond which what is as likely is another answer, no spread
    spread_within_rad: float = 0.37
    widest_px: float = 1e5  # 1e4..1e5: a spread that is said: from right above there is no end
    circle_spread_rad: float = math.radians(2.0)  # 0.01..0.1: of the slope that a circle tells
    right_angle_weight: float = 0.5  # weight, 0..1: edges side by side are not independent


PRIOR = PriorSettings()


@dataclass(frozen=True, slots=True)
class Standing:
    """A thing that stands on a level plane: where, how large it looks, how large it is.

    foot: row of its lowest point. extent: pixels. metres, spread: its usual size and the
    standard deviation of its logarithm. plane: which plane; only things on one are compared.
    lies: whether it is of a kind that lies rather than stands.
    """

    foot: float
    extent: float
    metres: float
    spread: float
    plane: str
    lies: bool = False


@dataclass(frozen=True, slots=True)
class Disc:
    """A circle on a level plane: row of its middle, height over width of its ellipse."""

    row: float
    flatness: float


@dataclass(frozen=True, slots=True)
class Horizon:
    """row: pixels, in the middle column. sigma: pixels. focal: pixels. roll: radians clockwise."""

    row: float
    sigma: float
    focal: float
    roll: float = 0.0


def usual_focal(size: tuple[int, int]) -> float:
    """Focal length in pixels of a normal lens, for a picture of (width, height) pixels."""
    return PRIOR.normal_lens_mm / PRIOR.film_diagonal_mm * math.hypot(*size)


def estimate(
    size: tuple[int, int],
    found: Segments,
    standing: Sequence[Standing],
    limits: Sequence[float] = (),
    discs: Sequence[Disc] = (),
    focal: float | None = None,
    angles: Sequence[right_angles.Edges] | None = None,
    outlines: Sequence[Outline] = (),
) -> Horizon:
    """The horizon and focal length of a picture.

    size: (width, height). found: its straight edges. standing: things on level planes. limits:
    rows of further points that certainly lie on a level plane, hence below the horizon. discs:
    circles on level planes. focal: pixels, where it is known. angles: the edges of each
    right-angled thing; without them all of `found` are taken to belong to one. outlines: of things
    whose form is known.
    """
    rows = size[1]
    if angles is None:
        angles = right_angles.edges_by_thing(found, size, ())
    # Of horizons far above, as of views from right above, the next one is a share farther off.
    far = rows / 2 - 5.5 * rows * np.exp(np.arange(1.5, 0.0, -0.02))
    grid = np.concatenate([far, np.arange(-5.0 * rows, 1.1 * rows, 2.0)])
    shared = _below(grid, [item.foot for item in standing], rows, 0.02)
    shared += _below(grid, limits, rows, 0.0)
    if at_work("known sizes"):
        shared += _sizes(grid, standing)
    usual = usual_focal(size)
    lying = bool(standing) and all(item.lies for item in standing)
    factors = _factors(focal, usual, finely=len(angles) > 0)
    votes = np.stack(
        [
            shared
            + _posture(grid, rows, usual * factor, lying)
            + _roundness(grid, rows, usual * factor, discs)
            + _forms(grid, rows, usual * factor, outlines)
            + (_eye_level(grid, rows, usual * factor, standing) if at_work("eye level") else 0.0)
            - (0.5 * (math.log(factor) / PRIOR.focal_spread_log) ** 2 if focal is None else 0.0)
            for factor in factors
        ]
    )
    if at_work("right angles"):
        votes += _right_angles(grid, rows, usual * factors, angles)
    best = np.unravel_index(int(votes.argmax()), votes.shape)
    row = float(grid[best[1]])
    length = usual * float(factors[best[0]])
    spread = _spread(votes, np.arctan2(rows / 2 - grid, length), int(best[1]))
    slope = length / math.cos(math.atan2(rows / 2 - row, length)) ** 2
    return Horizon(row, min(max(spread * slope, 1.0), PRIOR.widest_px), length)


def _spread(votes: FloatArray, tilt: FloatArray, best: int) -> float:
    """Standard deviation, rad, of the tilts (R,) about the best one, by their votes (F, R)."""
    off = tilt - tilt[best]
    weight = np.exp(votes - votes.max()).sum(0) * np.abs(np.gradient(tilt))
    weight *= np.abs(off) < PRIOR.spread_within_rad
    return math.sqrt(float((weight * off**2).sum() / weight.sum()))


def _factors(focal: float | None, usual: float, *, finely: bool) -> FloatArray:
    """Focal lengths to try, as shares of the usual one."""
    if focal is not None:
        return np.array([focal / usual])
    return np.exp(
        np.linspace(PRIOR.shortest_focal_log, PRIOR.longest_focal_log, 39 if finely else 14)
    )


def _right_angles(
    grid: FloatArray, rows: int, focals: FloatArray, angles: Sequence[right_angles.Edges]
) -> FloatArray:
    """(F, R) what the edges of right-angled things say of each focal length and row."""
    votes = np.zeros((len(focals), len(grid)))
    if not angles:
        return votes
    pitches = right_angles.PITCHES
    for vote, focal, own in zip(votes, focals, right_angles.votes(angles, focals), strict=True):
        tilt = np.clip(np.arctan2(rows / 2 - grid, focal), pitches[0], pitches[-1])
        vote += PRIOR.right_angle_weight * CubicSpline(pitches, own)(tilt)
    return votes


def _posture(grid: FloatArray, rows: int, focal: float, lying: bool) -> FloatArray:
    """Log prior of the pitch, of which a share is views from anywhere above; of pictures of nothing
    but what lies, of theirs."""
    pitch = np.arctan2(rows / 2 - grid, focal)
    if lying:
        return -0.5 * ((pitch - PRIOR.lying_pitch_rad) / PRIOR.lying_spread_rad) ** 2
    off = (pitch - PRIOR.pitch_rad) / PRIOR.pitch_spread_rad
    usual = (1 - PRIOR.above_share) / (PRIOR.pitch_spread_rad * math.sqrt(2 * math.pi))
    above = PRIOR.above_share / (math.pi / 2)
    return np.where(
        off > 0,
        np.log(above + usual * np.exp(-0.5 * off**2)),
        math.log(above + usual) - 0.5 * off**2,
    )


def _roundness(grid: FloatArray, rows: int, focal: float, discs: Sequence[Disc]) -> FloatArray:
    """A level circle is an ellipse as flat as the view is low there."""
    votes = np.zeros_like(grid)
    pitch = np.arctan2(rows / 2 - grid, focal)
    for disc in discs:
        seen = pitch + math.atan2(disc.row - rows / 2, focal)
        slope = math.asin(min(max(disc.flatness, 0.01), 0.999))
        off = (seen - slope) / PRIOR.circle_spread_rad
        votes -= 2 * np.log1p(0.25 * off**2)
    return votes


def _forms(grid: FloatArray, rows: int, focal: float, outlines: Sequence[Outline]) -> FloatArray:
    """Outlines are those of things of their kinds, seen from so far above."""
    pitch = np.arctan2(rows / 2 - grid, focal)
    return sum((outline.at(pitch, focal) for outline in outlines), np.zeros_like(grid))


def _below(grid: FloatArray, feet: Sequence[float], rows: int, margin: float) -> FloatArray:
    """What stands on the ground is seen below the horizon."""
    votes = np.zeros_like(grid)
    for foot in feet:
        over = (grid - (foot - margin * rows)) / (0.01 * rows)
        votes -= np.where(over > 0, np.minimum(over, 30) ** 1.0, 0)
    return votes


def _sizes(grid: FloatArray, standing: Sequence[Standing]) -> FloatArray:
    """Things of known size on one plane must give one height of the camera above it."""
    votes = np.zeros_like(grid)
    for plane in {item.plane for item in standing}:
        items = [item for item in standing if item.plane == plane]
        if len(items) < 2:
            continue
        below = np.array([item.foot for item in items])[None] - grid[:, None]
        logs = np.log(np.maximum(below, 1.0))
        logs = logs + np.log([item.metres / item.extent for item in items])
        spread = np.array([item.spread for item in items]) + 0.05
        weight = 1 / spread**2
        middle = (logs * weight).sum(1, keepdims=True) / weight.sum()
        votes -= 1.5 * np.log1p(((logs - middle) / spread) ** 2 / 1.5).sum(1)
    return votes


def _eye_level(
    grid: FloatArray, rows: int, focal: float, standing: Sequence[Standing]
) -> FloatArray:
    """People hold cameras somewhere between a hand's breadth and their eyes above a plane."""
    votes = np.zeros_like(grid)
    pitch = np.arctan2(rows / 2 - grid, focal)
    for plane in {item.plane for item in standing}:
        best = min((item for item in standing if item.plane == plane), key=lambda s: s.spread)
        below = np.maximum(best.foot - grid, 1.0)
        # Depths are taken along the view, which looks down.
        height = np.log(below * np.cos(pitch) * best.metres / best.extent)
        sigma = math.hypot(PRIOR.eye_level_spread_log, best.spread)
        votes -= 0.5 * ((height - math.log(PRIOR.eye_level_m)) / sigma) ** 2
    return votes


def weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """The value that halves the total weight."""
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weights[order]) / weights.sum()
    return float(values[order][int(np.searchsorted(share, 0.5))])
