"""How a thing that stands on the ground is turned, from the lower rim of its mask.

Seen from above its horizon, what stands on level ground and is about rectangular shows the two
sides of its footprint that face the camera as the lower rim of its outline. Laid onto the ground
they are two lines at a right angle. Of all turns that one is taken whose two lines the rim is
nearest to. Where the horizon is a guess it is sought as well, for only under the right one are the
two lines at a right angle and about as long as things that drive are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.shapes import FloatArray


@dataclass(frozen=True, slots=True)
class FootprintSettings:
    """How the lower rim of a mask is read as two sides."""

    samples_count: int = 60  # 20..300: of the rim, evenly across the picture
    # 0.01..0.1: over the rim's width, beyond which a point is of no side: it is off the ground
    far_ratio: float = 0.04
    least_far_px: float = 2.0  # 1..8: the same at least, for rims are whole pixels
    # 0..90: first, end and step of the turns that are tried: a quarter is all of them
    turns_deg: tuple[float, float, float] = (0.0, 90.0, 2.0)
    on_share: float = 0.25  # 0.1..0.5: of that, and a pixel, within which a point is on a side
    # 0.2..0.9: of the usual distance, for the best turn to be told from the others
    max_cost_share: float = 0.6
    min_points: int = 6  # count, 3..20: of a side, to be seen at all
    known_px: float = 5.0  # 1..20: a horizon surer than this is not sought
    widest_px: float = 150.0  # 30..400: off at most, by which a horizon is sought, twice over
    tried_count: int = 25  # 5..100: horizons on the way
    below_px: float = 8.0  # 2..30: by which the foot lies below any horizon that is tried
    length_ratio: float = 2.2  # 1.5..3: over the width, of what drives
    length_spread_log: float = 0.35  # 0.1..0.8: of that
    misfit_px: float = 0.35  # 0.1..2: that weigh as much as one standard deviation of the others


FOOTPRINT = FootprintSettings()

TURNS = np.radians(np.arange(*FOOTPRINT.turns_deg))
"""Turns that are tried, radians."""


@dataclass(frozen=True, slots=True)
class Footprint:
    """angle: degrees, seen from above, 0 … 180, of the longer one of the sides that are seen; 0 is
    to the right. along, across: how much of it and of the other is seen, m; across is 0 where the
    other is not."""

    angle: float
    along: float
    across: float


class _Laid(NamedTuple):
    """The rim under one horizon: its cost, the turn, lengths of both sides, how clear it is."""

    cost: float
    turn: float
    lengths: tuple[float, float]
    clear: bool
    view: Camera


def footprint_of(mask: np.ndarray, camera: Camera, height: float) -> Footprint | None:
    """How the thing of a mask (H, W) bool stands on ground at that height, m; None if unclear."""
    rim = rim_below(mask)
    eye = camera.position[2] - height
    if rim is None or eye <= 0:
        return None
    rows, columns = mask.shape
    pixels = rim * np.array([camera.size[0] / columns, camera.size[1] / rows])
    guess = camera.horizon
    unsure = 0.0 if camera.confirmed else min(camera.horizon_sigma or 0.0, FOOTPRINT.widest_px)
    # Where a horizon leaves the rim unexplained, it was not as sure as it seemed.
    for off in (unsure,) if camera.confirmed else (unsure, FOOTPRINT.widest_px):
        known = off <= FOOTPRINT.known_px
        strays = np.zeros(1) if known else np.linspace(-2, 2, FOOTPRINT.tried_count)
        laid = [_laid(pixels, camera, guess + by * off, eye, by) for by in strays.tolist()]
        best = min(filter(None, laid), key=lambda found: found.cost, default=None)
        if best is not None and best.clear:
            break
    else:
        return None
    longer = int(np.argmax(best.lengths))
    angle = _seen_by(camera, best.view, best.turn + longer * math.pi / 2, pixels)
    return Footprint(angle, best.lengths[longer], best.lengths[1 - longer])


def _laid(
    pixels: FloatArray, camera: Camera, horizon: float, eye: float, strays: float
) -> _Laid | None:
    """The rim (n, 2) on the ground that a camera at that height sees under a horizon, turned as
    fits best; None where it would lie above the horizon. strays: of the horizon, in deviations."""
    if horizon > float(pixels[:, 1].min()) - FOOTPRINT.below_px:
        return None
    view = Camera.from_horizon(camera.size, horizon, eye, focal=camera.focal, roll=camera.roll)
    places = _on_ground(view, pixels)
    if places is None:
        return None
    far = max(FOOTPRINT.far_ratio * float(np.ptp(pixels[:, 0])), FOOTPRINT.least_far_px)
    found = [_sides(places, view, turn) for turn in TURNS]
    costs = [float(np.minimum(gaps.min(axis=0), far).mean()) for gaps, _ in found]
    best = int(np.argmin(costs))
    lengths = _lengths(*found[best], max(FOOTPRINT.on_share * far, 1.0))
    odd = (
        (math.log(max(lengths) / min(lengths)) - math.log(FOOTPRINT.length_ratio))
        / FOOTPRINT.length_spread_log
        if min(lengths) > 0
        else 0.0
    )
    cost = costs[best] / FOOTPRINT.misfit_px + (strays**2 + odd**2) / 2
    clear = costs[best] <= FOOTPRINT.max_cost_share * float(np.median(costs))
    return _Laid(cost, float(TURNS[best]), lengths, clear, view)


def _on_ground(view: Camera, pixels: FloatArray) -> FloatArray | None:
    """Places (n, 2) on the ground of pixels (n, 2); None where one is not below the horizon."""
    rays, eye = view.rays(pixels), np.array(view.position, float)
    if (rays[:, 2] >= -1e-3).any():
        return None
    return (eye + rays * (-eye[2] / rays[:, 2])[:, None])[:, :2]


def _seen_by(camera: Camera, view: Camera, turn: float, pixels: FloatArray) -> float:
    """Degrees, 0 … 180, of a direction on the ground of `view`, on the ground of `camera`: the
    one that looks alike in the picture at the foot of the thing."""
    foot = pixels[len(pixels) // 2]
    place = _on_ground(view, foot[None])
    if place is None:
        return math.degrees(turn) % 180
    step = 0.01 * view.position[2]
    onward = place + step * np.array([[math.cos(turn), math.sin(turn)]])
    ends, _ = view.project(np.column_stack([np.vstack([place, onward]), np.zeros(2)]))
    along = (ends[1] - ends[0]) / max(float(np.linalg.norm(ends[1] - ends[0])), 1e-9)
    here = _on_ground(camera, np.array([foot, foot + along]))
    if here is None:
        return math.degrees(turn) % 180
    return math.degrees(math.atan2(*(here[1] - here[0])[::-1])) % 180


def rim_below(mask: np.ndarray) -> FloatArray | None:
    """(n, 2) pixels of the convex rim below a mask, its two ends left out."""
    columns = np.flatnonzero(mask.any(axis=0))
    if len(columns) < FOOTPRINT.samples_count // 2:
        return None
    lowest = mask.shape[0] - 1 - np.argmax(mask[::-1], axis=0)
    hull: list[tuple[float, float]] = []
    for column in columns.tolist():
        x, y = float(column), float(lowest[column])
        while len(hull) > 1:
            (a, b), (c, d) = hull[-2:]
            if (c - a) * (y - d) - (d - b) * (x - c) < 0:
                break
            hull.pop()
        hull.append((x, y))
    corners = np.array(hull)
    across = np.linspace(corners[0, 0], corners[-1, 0], FOOTPRINT.samples_count + 2)[1:-1]
    return np.stack([across, np.interp(across, corners[:, 0], corners[:, 1])], axis=1)


def _sides(places: FloatArray, view: Camera, turn: float) -> tuple[FloatArray, FloatArray]:
    """How far points (n, 2) lie behind each of the two sides of a footprint turned by `turn` (rad),
    (2, n) pixels, and where along it, (2, n) m."""
    toward = np.array(view.position[:2]) - np.median(places, axis=0)
    away = float(np.linalg.norm(toward))
    slant = math.hypot(away, view.position[2])
    pixel = slant / view.focal
    gaps, along = [], []
    for angle in (turn, turn + np.pi / 2):
        way = np.array([np.cos(angle), np.sin(angle)])
        out = np.array([-way[1], way[0]])
        out = out if float(out @ toward) >= 0 else -out
        # A step away from the camera is foreshortened, one across is not.
        deep = float(out @ toward) / away
        size = math.hypot(deep * view.position[2] / slant, math.sqrt(max(0.0, 1 - deep**2))) / pixel
        reach = places @ out
        gaps.append((reach.max() - reach) * size)
        along.append(places @ way)
    return np.array(gaps), np.array(along)


def _lengths(gaps: FloatArray, along: FloatArray, on_px: float) -> tuple[float, float]:
    """How much of each side is seen, m; 0 where there are too few points on it."""
    nearer = gaps.argmin(axis=0)
    first, second = (
        float(np.ptp(along[side][on])) if int(on.sum()) >= FOOTPRINT.min_points else 0.0
        for side in (0, 1)
        for on in [(nearer == side) & (gaps[side] < on_px)]
    )
    return first, second
