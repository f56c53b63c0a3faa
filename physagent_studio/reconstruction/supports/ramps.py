"""Ramps: the profile that the picture shows, in an upright plane that faces the camera."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.stairs import profile_of, treads_of
from physagent_studio.program.scene.state import Ramp
from physagent_studio.reconstruction.camera.rays import on_plane, on_upright_through
from physagent_studio.reconstruction.photo.line_segments import Segments, joined


@dataclass(frozen=True, slots=True)
class RampSettings:
    """When a ramp's far edge is seen behind its near one: one looks down on its upper side."""

    max_turn_deg: float = 8.0  # 2..15: between the two edges, which meet far off
    min_length_share: float = 0.3  # 0.1..0.8: of the near edge: things stand before the far one
    # 0.03..0.15: of the near edge's length between them: less is a board's thickness
    min_gap_share: float = 0.06
    max_gap_share: float = 0.5  # 0.2..1: of that length: what is farther off is another thing's
    rim_px: float = 4.0  # 1..10: a foot is seen as far beyond either edge


RAMP = RampSettings()

Pixel = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Profile:
    """A ramp's outline in pixels: where its slope meets the ground, its upper end, and the far

    end of the plateau behind it (equal to `top` where there is none). far: lower and upper end of
    the slope's far edge, where its upper side is seen.
    """

    toe: Pixel
    top: Pixel
    end: Pixel
    far: tuple[Pixel, Pixel] | None = None

    @property
    def uphill(self) -> int:
        """+1 where the ramp rises to the right of the picture, −1 where it rises to the left."""
        return 1 if self.top[0] >= self.toe[0] else -1

    def surface(self, x: float) -> float | None:
        """Row of the ramp's upper surface at column x; None beside it."""
        columns = [self.toe[0], self.top[0], self.end[0]]
        rows = [self.toe[1], self.top[1], self.end[1]]
        if not min(columns) <= x <= max(columns):
            return None
        order = np.argsort(columns, kind="stable")
        return float(np.interp(x, np.array(columns)[order], np.array(rows)[order]))

    def carries(self, x: float, y: float) -> bool:
        """Whether a pixel shows the upper side between its two edges, or nearly."""
        row = self.surface(x)
        if row is None or self.far is None:
            return False
        (x0, y0), (x1, y1) = self.far
        beyond = y0 + (y1 - y0) * (x - x0) / (x1 - x0)
        return beyond - RAMP.rim_px <= y <= row + RAMP.rim_px


def find_profile(
    found: Segments, clicks: Sequence[tuple[float, float]], size: tuple[int, int]
) -> Profile | None:
    """The slope near the clicks, its toe and top, and the plateau that continues it.

    Three clicks are taken as toe, foot below the top, and top.
    """
    if len(clicks) == 3:
        toe, _, top = clicks
        return Profile(toe, top, top)
    if not clicks:
        return None
    slope = _slope(found, clicks, size)
    if slope is None:
        return None
    if seen := _looked_down_on(found, slope, clicks):
        return seen
    toe, top = slope
    toe = _down_to_base(found, toe, top, clicks, size)
    return Profile(toe, top, _plateau(found, toe, top, size))


def _slope(
    found: Segments, clicks: Sequence[tuple[float, float]], size: tuple[int, int]
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Ends (lower, upper) of the best oblique edge: long, and near a click."""
    oblique = (np.abs(found.angle) > math.radians(6)) & (np.abs(found.angle) < math.radians(65))
    used = found.only(oblique)
    if not len(used.length):
        return None
    joined_ends, length = joined(used)
    reach = 0.12 * max(size)
    distance = np.full(len(length), np.inf)
    for click in clicks:
        distance = np.minimum(distance, [_distance(np.array(click), ends) for ends in joined_ends])
    merit = length * np.exp(-((distance / (2 * reach)) ** 2))
    # Of the parallel edges of a slope the near one lies lowest in the picture.
    best = np.flatnonzero(merit > 0.6 * merit.max())
    ends = joined_ends[max(best, key=lambda k: float(joined_ends[k][:, 1].mean()))]
    return _low_first(ends)


def _looked_down_on(
    found: Segments, slope: tuple[Pixel, Pixel], clicks: Sequence[Pixel]
) -> Profile | None:
    """The near and the far edge of a slope whose upper side holds a click; None where it is not
    seen. Of the near edges of a thick board the longest bounds its upper side."""
    ends, _ = joined(found)
    low, high = np.array(slope)
    ahead = (high - low) / np.linalg.norm(high - low)
    span = float(np.linalg.norm(high - low))
    steps = ends[:, 1] - ends[:, 0]
    lengths = np.linalg.norm(steps, axis=1)
    sines = np.abs(steps[:, 0] * ahead[1] - steps[:, 1] * ahead[0]) / np.maximum(lengths, 1e-9)
    alike = sines < math.sin(math.radians(RAMP.max_turn_deg))
    middles = ends.mean(1) - low
    # Up in the picture, across the slope.
    above = -(middles[:, 1] - middles[:, 0] * ahead[1] / ahead[0])
    gaps = above / span
    near = alike & (np.abs(gaps) < RAMP.min_gap_share)
    far = alike & (gaps > RAMP.min_gap_share) & (gaps < RAMP.max_gap_share)
    far &= lengths > RAMP.min_length_share * span
    if not near.any() or not far.any():
        return None
    toe, top = _low_first(ends[max(np.flatnonzero(near), key=lambda k: lengths[k])])
    lower, upper = _low_first(ends[max(np.flatnonzero(far), key=lambda k: lengths[k])])
    seen = Profile(toe, top, top, (lower, upper))
    return seen if any(seen.carries(*click) for click in clicks) else None


def _low_first(ends: FloatArray) -> tuple[Pixel, Pixel]:
    low, high = sorted(ends.tolist(), key=lambda point: -point[1])
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))


def _distance(point: FloatArray, ends: FloatArray) -> float:
    """Distance of a point from a segment, pixels."""
    a, b = ends
    along = float(np.clip((point - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-9), 0, 1))
    return float(np.linalg.norm(point - a - along * (b - a)))


def _down_to_base(
    found: Segments,
    toe: tuple[float, float],
    top: tuple[float, float],
    clicks: Sequence[tuple[float, float]],
    size: tuple[int, int],
) -> tuple[float, float]:
    """The slope's lower end, carried on to the level edge that the ramp stands on, if one is seen.

    The base edge runs below the slope, and the two meet near the end of that edge.
    """
    dx, dy = toe[0] - top[0], toe[1] - top[1]
    best, strongest = toe, 0.0
    for ends, angle, length in zip(found.ends, found.angle, found.length, strict=True):
        row = float(ends[:, 1].mean())
        share = (row - top[1]) / dy
        if abs(angle) > math.radians(6) or not 0.97 <= share <= 1.9:
            continue
        meets = top[0] + share * dx
        nearest = float(np.abs(ends[:, 0] - meets).min())
        under = min(ends[:, 0].max(), max(toe[0], top[0])) - max(
            ends[:, 0].min(), min(toe[0], top[0])
        )
        below_clicks = all(row > y - 0.02 * size[1] for _, y in clicks[:1])
        if (
            nearest < 0.05 * size[0]
            and under > 0.3 * abs(dx)
            and below_clicks
            and length > strongest
        ):
            # The ramp ends where its base does.
            away = 1 if dx > 0 else -1
            end = float(max(ends[:, 0] * away)) * away
            best, strongest = (min(meets * away, end * away) * away, row), float(length)
    return best


def _plateau(
    found: Segments,
    toe: tuple[float, float],
    top: tuple[float, float],
    size: tuple[int, int],
) -> tuple[float, float]:
    """Far end of a level edge that starts at the slope's upper end and leads away from it."""
    away = 1 if top[0] >= toe[0] else -1
    near = 0.035 * max(size)
    best = top
    for ends, angle in zip(found.ends, found.angle, strict=True):
        if abs(angle) > math.radians(5):
            continue
        start, finish = (ends[0], ends[1]) if away > 0 else (ends[1], ends[0])
        touches = abs(start[1] - top[1]) < near and (start[0] - top[0]) * away < 2 * near
        if touches and (finish[0] - best[0]) * away > 0 and (finish[0] - top[0]) * away > near:
            best = (float(finish[0]), top[1])
    return best


def place_ramp(camera: Camera, profile: Profile, width: float | None = None) -> Ramp | None:
    """The ramp on the floor z = 0 with this profile, in the upright plane through its toe.

    None where the toe lies above the horizon. width: across, m; by default 0.4 of its length.
    """
    toe = on_plane(camera, [profile.toe], 0.0)[0]
    if not np.isfinite(toe).all():
        return None
    spots = on_upright_through(camera, [profile.top, profile.end], toe, (0.0, 1.0, 0.0))
    run, rise = abs(float(spots[0, 0] - toe[0])), float(spots[0, 2])
    plateau = max(abs(float(spots[1, 0] - toe[0])) - run, 0.0)
    if run < 1e-3 or rise < 1e-3:
        return None
    if width is None and profile.far is not None:
        width = _width(camera, profile.far, toe, spots[0])
    across = width or 0.4 * (run + plateau)
    # The edge that is seen is the near one: the ramp's middle lies half its width behind.
    place = (float(toe[0]), float(toe[1]) + across / 2, 0.0)
    yaw = 0.0 if profile.uphill > 0 else math.pi
    return Ramp(toe=place, yaw=yaw, run=run, rise=rise, width=across, plateau=plateau)


def _width(
    camera: Camera, far: tuple[Pixel, Pixel], toe: FloatArray, top: FloatArray
) -> float | None:
    """How far behind the near edge of a slope, from toe to top, its far edge lies, m."""
    up = top - toe
    places = on_upright_through(camera, far, toe, np.cross(up, (0.0, 1.0, 0.0)))
    width = float(np.mean(places[:, 1]) - toe[1])
    return width if math.isfinite(width) and width > 0 else None


def height_at(ramp: Ramp, x: float, y: float) -> float | None:
    """Height of the ramp's surface under a world place, m; None beside it."""
    ahead = (x - ramp.toe[0]) * math.cos(ramp.yaw) + (y - ramp.toe[1]) * math.sin(ramp.yaw)
    across = -(x - ramp.toe[0]) * math.sin(ramp.yaw) + (y - ramp.toe[1]) * math.cos(ramp.yaw)
    if abs(across) > ramp.width / 2 or not 0 <= ahead <= profile_of(ramp)[-1][0]:
        return None
    treads = treads_of(ramp)
    if treads:
        return ramp.toe[2] + max(tread.top for tread in treads if tread.start <= ahead)
    return ramp.toe[2] + ramp.rise * min(ahead / ramp.run, 1.0)
